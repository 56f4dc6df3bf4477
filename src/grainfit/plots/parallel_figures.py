"""Parallel coordinates: every run as a line over all parameters and responses."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from grainfit.evaluation import Evaluation
from grainfit.formatting import number
from grainfit.plots import messages
from grainfit.plots.arrange import arrange
from grainfit.plots.figure import Figure, no_figure
from grainfit.plots.labels import Label, label_of_parameter, label_of_response
from grainfit.plots.style import GREEN, ORANGE, QUIET
from grainfit.work_folder.saved_calibration import SavedCalibration

if TYPE_CHECKING:
    from plotly.graph_objects import Figure as PlotlyFigure

_HEIGHT = 380
#: Shares of the height: room for the numbers at both ends of a coordinate.
_RANGE = (-0.14, 1.16)


@dataclass(frozen=True)
class _Coordinate:
    """A vertical axis: its label, the values of the runs as shares of it, and its ends."""

    label: Label
    shares: Sequence[float | None]
    ends: tuple[str, str]
    #: Ends of the tolerance as shares; None for a parameter.
    band: tuple[float, float] | None = None


def parallel(saved: SavedCalibration) -> PlotlyFigure:
    """Draw every run as a line over all parameters and responses.

    Takes a calibration, which may still be running; returns a Plotly figure.

    Raises
    ------
    InputError
        No run has ended yet.
    """
    figure = parallel_figure(saved)
    if figure is None:
        raise no_figure(messages.NO_RUN())
    return arrange([[figure]], "Runs over parameters and responses")


def parallel_figure(saved: SavedCalibration) -> Figure | None:
    """Return the figure; None without runs."""
    runs = saved.evaluations
    if not runs:
        return None
    coordinates = [*_parameters(saved, runs), *_responses(saved, runs)]
    groups: dict[str, list[int]] = {name: [] for name in _STYLES}
    for index, run in enumerate(runs):
        groups[_group(saved, run)].append(index)
    lines = [_line(coordinates, index, name) for name, chosen in groups.items() for index in chosen]
    shown: set[str] = set()
    for line in lines:
        line["showlegend"] = line["name"] not in shown
        shown.add(line["name"])
    return Figure(
        tuple(lines),
        _layout(coordinates),
        "Every run as a line over the parameters and the responses, each from its lowest to its "
        "highest value; bands are the measured values with their tolerances.",
        height=_HEIGHT,
    )


#: By the outcome of a run; lines of the last ones are drawn above the others.
_STYLES: dict[str, dict[str, Any]] = {
    "failed": {"color": QUIET, "width": 1, "dash": "dot"},
    "misses a target": {"color": ORANGE, "width": 1},
    "meets every target by itself": {"color": GREEN, "width": 2},
}


def _group(saved: SavedCalibration, run: Evaluation) -> str:
    if run.failures:
        return "failed"
    known = [target for target in saved.problem.targets if target.name in run.responses]
    met = all(target.is_met_by(run.responses[target.name].value) for target in known)
    return "meets every target by itself" if met and known else "misses a target"


def _parameters(saved: SavedCalibration, runs: Sequence[Evaluation]) -> list[_Coordinate]:
    return [
        _Coordinate(
            label_of_parameter(saved, p.name),
            [p.to_unit(run.proposal.parameters[p.name]) for run in runs],
            (number(p.minimum, 3), number(p.maximum, 3)),
        )
        for p in saved.problem.parameters
    ]


def _responses(saved: SavedCalibration, runs: Sequence[Evaluation]) -> list[_Coordinate]:
    found = []
    for target in saved.problem.targets:
        values = [
            run.responses[target.name].value if target.name in run.responses else None
            for run in runs
        ]
        ends = target.value - target.tolerance, target.value + target.tolerance
        known = [*ends, *(value for value in values if value is not None)]
        low, high = min(known), max(known)
        found.append(
            _Coordinate(
                label_of_response(saved, target.name),
                [None if value is None else (value - low) / (high - low) for value in values],
                (number(low, 3), number(high, 3)),
                ((ends[0] - low) / (high - low), (ends[1] - low) / (high - low)),
            )
        )
    return found


def _line(coordinates: Sequence[_Coordinate], index: int, name: str) -> dict[str, Any]:
    return {
        "type": "scatter",
        "mode": "lines",
        "name": name,
        "legendgroup": name,
        "x": list(range(len(coordinates))),
        "y": [coordinate.shares[index] for coordinate in coordinates],
        "line": _STYLES[name],
        "opacity": 0.7,
        "meta": {"runs": [f"run {index + 1}"] * len(coordinates)},
        "hovertemplate": f"run {index + 1}<extra>{name}</extra>",
    }


def _layout(coordinates: Sequence[_Coordinate]) -> dict[str, Any]:
    places = range(len(coordinates))
    upright = [
        {"type": "line", "x0": x, "x1": x, "y0": 0, "y1": 1, "line": {"color": QUIET, "width": 1}}
        for x in places
    ]
    bands = [
        {
            "type": "rect",
            "x0": x - 0.06,
            "x1": x + 0.06,
            "y0": coordinate.band[0],
            "y1": coordinate.band[1],
            "fillcolor": GREEN,
            "opacity": 0.35,
            "line": {"width": 0},
        }
        for x, coordinate in zip(places, coordinates, strict=True)
        if coordinate.band
    ]
    ends = [
        {"x": x, "y": y, "text": text, "showarrow": False, "yanchor": anchor}
        for x, coordinate in zip(places, coordinates, strict=True)
        for y, text, anchor in zip((0, 1), coordinate.ends, ("top", "bottom"), strict=True)
    ]
    return {
        "xaxis": {
            "tickvals": list(places),
            "title": {"text": "parameters, then responses"},
            "ticktext": [coordinate.label.axis for coordinate in coordinates],
            "range": [-0.4, len(coordinates) - 0.6],
            "showgrid": False,
            "zeroline": False,
        },
        "yaxis": {"range": list(_RANGE), "visible": False, "fixedrange": True},
        "shapes": [*upright, *bands],
        "annotations": ends,
    }
