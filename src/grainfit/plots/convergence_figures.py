"""Convergence of a calibration: deviations and responses over the number of the run."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from html import escape
from typing import TYPE_CHECKING, Any

import numpy as np

from grainfit.evaluation import Evaluation
from grainfit.formatting import plain, plain_interval, with_unit
from grainfit.metamodels.curve_reduction import Reduction
from grainfit.plots import messages
from grainfit.plots.arrange import arrange
from grainfit.plots.axes import log_axis, whole_step
from grainfit.plots.expected_course import Expectation, expectations_at_answer
from grainfit.plots.figure import Figure, no_figure
from grainfit.plots.labels import label_of_response
from grainfit.plots.style import GREEN, STAGES, VERMILION, tolerance_band, value_range
from grainfit.problem import Problem, Target
from grainfit.work_folder.saved_calibration import SavedCalibration

if TYPE_CHECKING:
    from plotly.graph_objects import Figure as PlotlyFigure

#: Smallest deviation shown, as a share of the tolerance, because a log axis has no zero.
_SMALLEST = 1e-3
#: Room above and below the deviations, as a factor.
_ROOM = 1.6
_FEWEST_OF_A_LINE = 2


def convergence(saved: SavedCalibration) -> PlotlyFigure:
    """Draw the largest deviation and every response over the number of the run.

    Takes a calibration, which may still be running; returns a Plotly figure.

    Raises
    ------
    InputError
        No run has ended yet.
    """
    figures = convergence_figures(saved)
    if not figures:
        raise no_figure(messages.NO_RUN())
    return arrange([[figure] for figure in figures.values()], "Convergence")


def convergence_figures(saved: SavedCalibration) -> dict[str, Figure]:
    """Return the figures by key: ``misfit``, and the number of each target; none without runs."""
    if not saved.evaluations:
        return {}
    expected = expectations_at_answer(saved)
    figures = {"misfit": _misfit_figure(saved, expected)}
    for index, target in enumerate(saved.problem.targets):
        figures[str(index)] = _response_figure(saved, index, target, expected)
    return figures


def deviation_in_tolerances(problem: Problem, evaluation: Evaluation) -> float | None:
    """Largest deviation of a run's responses in units of their tolerances; None if one lacks.

    The responses are those of the tests that were run, with components instead of curves.
    """
    targets = [target for target in problem.targets if _is_asked(problem, evaluation, target)]
    if not targets or any(target.name not in evaluation.responses for target in targets):
        return None
    return max(
        abs(evaluation.responses[target.name].value - target.value) / target.tolerance
        for target in targets
    )


def _is_asked(problem: Problem, evaluation: Evaluation, target: Target) -> bool:
    """Whether the test of a target was to be run."""
    return evaluation.proposal.asks_for(problem.scope_of(target.name).name)


def _misfit_figure(saved: SavedCalibration, expected: Sequence[Expectation]) -> Figure:
    reduction = Reduction.where_possible(saved.problem, saved.known)
    evaluations = reduction.evaluations(saved.evaluations)
    found = [deviation_in_tolerances(reduction.problem, evaluation) for evaluation in evaluations]
    drawn = [None if value is None else max(value, _SMALLEST) for value in found]
    line = list(_expected_misfit(saved.problem, expected))
    traces = [
        *_points_by_stage(evaluations, drawn, "%{y:.3g} × tolerance"),
        *line,
        _failures(evaluations, drawn, [True] * len(evaluations)),
    ]
    known = [value for value in drawn if value is not None] or [1.0]
    known += [value for trace in line for value in trace["y"]]
    layout = {
        "xaxis": _run_axis(len(evaluations)),
        "yaxis": {
            "title": {"text": "deviation / tolerance"},
            **log_axis(min(*known, 1.0) / _ROOM, _ROOM * max(*known, 1.0)),
        },
        "yaxis2": _failure_axis(),
        "shapes": [
            {
                "type": "line",
                "xref": "paper",
                "x0": 0,
                "x1": 1,
                "y0": 1,
                "y1": 1,
                "line": {"color": GREEN, "width": 1.5, "dash": "dot"},
            }
        ],
    }
    words = (
        "Largest deviation of each run in units of its tolerance over the number of the run, "
        "with the deviation expected at the answer and a line at 1, below which all responses are "
        "within tolerance."
    )
    title = "Largest deviation in units of the tolerance"
    return Figure(tuple(traces), layout, words, height=340, title=title)


def _expected_misfit(problem: Problem, expected: Sequence[Expectation]) -> Iterator[dict[str, Any]]:
    """Line of the largest expected deviation: unlike the best run, no lucky seed lowers it."""
    if len(expected) < _FEWEST_OF_A_LINE or not problem.targets:
        return
    values = np.array([target.value for target in problem.targets])
    tolerances = np.array([target.tolerance for target in problem.targets])
    means = np.array([one.means[: len(values)] for one in expected])
    yield {
        "type": "scatter",
        "mode": "lines",
        "name": "expected at the answer",
        "x": [one.runs for one in expected],
        "y": np.maximum(np.abs(means - values) / tolerances, _SMALLEST).max(axis=1).tolist(),
        "line": {"color": VERMILION, "width": 2},
        "hovertemplate": "after %{x} runs: %{y:.2g} × tolerance<extra>expected at the answer"
        "</extra>",
    }


def _response_figure(
    saved: SavedCalibration, index: int, target: Target, expected: Sequence[Expectation]
) -> Figure:
    evaluations = saved.evaluations
    label = label_of_response(saved, target.name)
    values = [
        evaluation.responses[target.name].value if target.name in evaluation.responses else None
        for evaluation in evaluations
    ]
    traces = [
        *_expectation_traces(index, expected),
        *_points_by_stage(evaluations, values, f"%{{y:.5g}} {escape(label.unit)}"),
        _failures(evaluations, values, [_is_asked(saved.problem, e, target) for e in evaluations]),
    ]
    known = [value for value in values if value is not None]
    known += [float(one.means[index]) for one in expected]
    layout = {
        "xaxis": _run_axis(len(evaluations)),
        "yaxis": {"title": {"text": label.axis}, "range": value_range(target, known)},
        "yaxis2": _failure_axis(),
        "shapes": tolerance_band(target, "y"),
    }
    words = (
        f"{label.words} of each run over the number of the run, with the measured value "
        f"{target.value:g} and its tolerance of {target.tolerance:g} as a band."
    )
    measured = plain_interval(target.value, target.tolerance)
    title = f"{label.plot}, measured {with_unit(measured, escape(label.unit))}"
    return Figure(tuple(traces), layout, words, height=320, title=title)


def _points_by_stage(
    evaluations: Sequence[Evaluation], values: Sequence[float | None], hover: str
) -> Iterator[dict[str, Any]]:
    for stage, (symbol, colour) in STAGES.items():
        numbers = [
            number
            for number, evaluation in enumerate(evaluations, 1)
            if evaluation.proposal.stage == stage and values[number - 1] is not None
        ]
        if numbers:
            yield {
                "type": "scatter",
                "mode": "markers",
                "name": stage,
                "x": numbers,
                "y": [values[number - 1] for number in numbers],
                "meta": {"runs": [f"run {number}" for number in numbers]},
                "marker": {"symbol": symbol, "color": colour, "size": 8, "line": {"width": 1.5}},
                "hovertemplate": f"run %{{x}}: {hover}<extra>{stage}</extra>",
            }


def _failures(
    evaluations: Sequence[Evaluation], values: Sequence[float | None], asked: Sequence[bool]
) -> dict[str, Any]:
    """Runs without a value that should have one, at the lower edge of the figure."""
    numbers = [
        number
        for number, (value, wanted) in enumerate(zip(values, asked, strict=True), 1)
        if value is None and wanted
    ]
    reasons = [
        "; ".join(evaluations[number - 1].failures.values()) or "it did not give this response"
        for number in numbers
    ]
    return {
        "type": "scatter",
        "mode": "markers",
        "name": "failed",
        "visible": bool(numbers),
        "x": numbers,
        "y": [0.03] * len(numbers),
        "yaxis": "y2",
        "meta": {"runs": [f"run {number}" for number in numbers]},
        "marker": {"symbol": "x", "color": VERMILION, "size": 8},
        "text": [_wrapped(reason) for reason in reasons],
        "hovertemplate": "run %{x} failed: %{text}<extra></extra>",
    }


def _wrapped(text: str, width: int = 60) -> str:
    """Wrap a text into at most four lines that fit into a figure."""
    shown = plain(text)
    lines = [shown[start : start + width] for start in range(0, len(shown), width)]
    return "<br>".join(escape(line) for line in [*lines[:4], *(["…"] if lines[4:] else [])])


def _run_axis(count: int) -> dict[str, Any]:
    return {
        "title": {"text": "number of the run"},
        "range": [0, count + 1],
        "rangemode": "nonnegative",
        "zeroline": False,
        "tickformat": "d",
        # Ticks between two runs would be written as the next one.
        "tick0": 0,
        "dtick": whole_step(count),
    }


def _failure_axis() -> dict[str, Any]:
    """Invisible axis that keeps marks at the lower edge, independent of the data above."""
    return {"overlaying": "y", "range": [0, 1], "visible": False, "fixedrange": True}


def _expectation_traces(index: int, expected: Sequence[Expectation]) -> list[dict[str, Any]]:
    """A line with its 95 % interval."""
    if len(expected) < _FEWEST_OF_A_LINE:
        return []
    numbers = [one.runs for one in expected]
    means = np.array([one.means[index] for one in expected])
    half = 1.96 * np.array([one.standard_errors[index] for one in expected])
    band = {
        "type": "scatter",
        "mode": "lines",
        "x": [*numbers, *numbers[::-1]],
        "y": [*(means + half), *(means - half)[::-1]],
        "fill": "toself",
        "fillcolor": "rgba(213, 94, 0, 0.15)",
        "line": {"width": 0},
        "hoverinfo": "skip",
        "showlegend": False,
    }
    line = {
        "type": "scatter",
        "mode": "lines",
        "name": "expected at the answer",
        "x": numbers,
        "y": means,
        "line": {"color": VERMILION, "width": 2},
        "customdata": half,
        "hovertemplate": "after %{x} runs: %{y:.5g} ± %{customdata:.2g}<extra>expected at the "
        "answer</extra>",
    }
    return [band, line]
