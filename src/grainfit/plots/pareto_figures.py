"""Pareto front: smallest misfit against Rayleigh time step."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from grainfit.analysis.analysis import Analysis
from grainfit.analysis.pareto import ParetoFront
from grainfit.metamodels.metamodels import Metamodels
from grainfit.plots.arrange import arrange
from grainfit.plots.axes import log_axis
from grainfit.plots.figure import Figure, no_figure
from grainfit.plots.style import BLUE, VERMILION
from grainfit.problem import Problem
from grainfit.work_folder.saved_calibration import SavedCalibration

if TYPE_CHECKING:
    from plotly.graph_objects import Figure as PlotlyFigure

#: Above this ratio of the largest misfit to the smallest, the axis is logarithmic.
_LARGEST_RATIO = 30.0
#: Room above and below the misfits, as a factor.
_ROOM = 1.4
_TOO_SMALL_FOR_LOGARITHMS = 1e-12
_TIME_UNITS = ((1e-6, "ns", 1e9), (1e-3, "µs", 1e6), (1.0, "ms", 1e3))


def pareto(saved: SavedCalibration, analysis: Analysis | None = None) -> PlotlyFigure:
    """Draw the smallest possible misfit at each Rayleigh time step.

    Takes a calibration and its analysis, by default ``saved.analyse()``; returns a Plotly figure.

    Raises
    ------
    InputError
        There are too few runs for a metamodel, or the time step is the same for all parameters.
    """
    analysis = analysis or saved.analyse()
    metamodels, front = analysis.metamodels, analysis.pareto
    if metamodels is None:
        raise no_figure(" ".join(analysis.notes))
    if front is None or not len(front.time_steps):
        raise no_figure(why_no_front(saved.problem))
    return arrange([[pareto_figure(saved, metamodels, front)]], "Misfit and time step")


def why_no_front(problem: Problem) -> str:
    """Return the reason why a problem has no Pareto front."""
    if problem.rayleigh is None:
        return (
            "No Rayleigh time step is known of this problem, so there is nothing to trade: it "
            "follows from the particles' radius, density, Young's modulus and Poisson's ratio."
        )
    return (
        "Nothing that is free changes the Rayleigh time step: it is the same for all parameter "
        "sets. Where it matters, free density, Young's modulus or Poisson's ratio of the particles."
    )


def time_unit(largest: float) -> tuple[str, float]:
    """Return a unit in which time steps are readable, and the number of such units in a second."""
    return next(
        ((unit, factor) for limit, unit, factor in _TIME_UNITS if largest < limit), ("s", 1.0)
    )


def pareto_figure(saved: SavedCalibration, metamodels: Metamodels, front: ParetoFront) -> Figure:
    """Return the figure of a front that has points."""
    unit, factor = time_unit(float(front.time_steps[-1]))
    misfits = front.misfits
    times = (factor * front.time_steps).tolist()
    data: list[Mapping[str, Any]] = [
        {
            "type": "scatter",
            "mode": "lines+markers",
            "name": "best compromises",
            "x": times,
            "y": misfits.tolist(),
            "customdata": front.probability_all_met.tolist(),
            "line": {"color": BLUE, "width": 1.5},
            "marker": {"color": BLUE, "size": 10},
            "hovertemplate": (
                f"time step %{{x:.4g}} {unit}<br>misfit %{{y:.3g}}<br>"
                "all responses agree: %{customdata:.0%}<extra></extra>"
            ),
        }
    ]
    answer = saved.result.parameters if saved.result else {}
    answer_time = saved.problem.rayleigh_time_step(answer) if answer else None
    if answer_time is not None:
        point = metamodels.problem.to_unit(answer)
        data.append(
            {
                "type": "scatter",
                "mode": "markers",
                "name": "the answer",
                "x": [factor * answer_time],
                "y": metamodels.misfit([point]).tolist(),
                "marker": {"color": VERMILION, "size": 15, "symbol": "star"},
                "hovertemplate": f"the answer: %{{x:.4g}} {unit}<extra></extra>",
            }
        )
    return Figure(
        data=tuple(data),
        layout={
            "xaxis": {"title": {"text": f"Rayleigh time step ({unit})"}, "zeroline": False},
            "yaxis": {
                "title": {"text": "misfit (squared tolerances)"},
                **_misfit_axis([value for trace in data for value in trace["y"]]),
            },
            "hovermode": "closest",
            "clickmode": "event",
        },
        description=(
            "The smallest possible misfit at each Rayleigh time step: further right is "
            "faster, further down is closer to the measurements."
        ),
        height=380,
    )


def _misfit_axis(misfits: Sequence[float]) -> Mapping[str, Any]:
    low, high = max(min(misfits), _TOO_SMALL_FOR_LOGARITHMS), max(misfits)
    if high <= _LARGEST_RATIO * low:
        return {"type": "linear", "rangemode": "tozero"}
    return log_axis(low / _ROOM, _ROOM * high)
