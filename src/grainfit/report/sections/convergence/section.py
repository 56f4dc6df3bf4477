"""Convergence: how the runs came to the measurements, one after another."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from html import escape
from itertools import accumulate
from typing import Any

import numpy as np

from grainfit.evaluation import Evaluation
from grainfit.formatting import plain
from grainfit.metamodels.metamodels import Metamodels, can_be_fitted
from grainfit.plots.style import GREEN, STAGES, VERMILION, tolerance_band, value_range
from grainfit.problem import Target
from grainfit.report.rendering import render
from grainfit.report.section import Figure, ReportContext, Section

#: Metamodels that are fitted to the first runs, and to how many of them at most: what a fit takes
#: grows with the cube of that.
_FITS = 8
_MOST_FITTED = 120
#: The same where as many were learnt from as well.
_FEWEST_FITTED = 20
#: Deviations below this share of the tolerance are as good as none, and a log axis has no zero.
_SMALLEST = 1e-3


def convergence(context: ReportContext) -> Section:
    """Largest deviation and every response over the number of the run."""
    evaluations = context.reading.evaluations
    html = render(
        "convergence/page",
        count=len(evaluations),
        labels=[context.response_label(target.name) for target in context.targets],
        failed=sum(1 for evaluation in evaluations if evaluation.failures),
        expected=bool(_checkpoints(context)),
    )
    if not evaluations:
        return Section("convergence", "Convergence", html)
    figures = {"convergence-misfit": _misfit_figure(context)}
    expected = _expected_at_the_answer(context)
    for index, target in enumerate(context.targets):
        figures[f"convergence-{index}"] = _response_figure(context, index, target, expected)
    return Section("convergence", "Convergence", html, figures)


def deviation_in_tolerances(targets: Sequence[Target], evaluation: Evaluation) -> float | None:
    """Largest deviation of a run's responses in units of their tolerances; None if one lacks."""
    if any(target.name not in evaluation.responses for target in targets):
        return None
    return max(
        abs(evaluation.responses[target.name].value - target.value) / target.tolerance
        for target in targets
    )


def _misfit_figure(context: ReportContext) -> Figure:
    evaluations = context.reading.evaluations
    found = [deviation_in_tolerances(context.targets, evaluation) for evaluation in evaluations]
    drawn = [None if value is None else max(value, _SMALLEST) for value in found]
    best = list(accumulate((np.inf if value is None else value for value in drawn), min))
    traces = [
        *_points_by_stage(evaluations, drawn, "%{y:.3g} × tolerance"),
        {
            "type": "scatter",
            "mode": "lines",
            "name": "best so far",
            "x": list(range(1, len(best) + 1)),
            "y": best,
            "line": {"shape": "hv", "color": VERMILION, "width": 2},
            "hoverinfo": "skip",
        },
        _failures(evaluations, drawn),
    ]
    known = [value for value in drawn if value is not None] or [1.0]
    low, high = np.log10(min(*known, 1.0)), np.log10(max(*known, 1.0))
    layout = {
        "xaxis": _run_axis(len(evaluations)),
        "yaxis": {
            "title": {"text": "largest deviation / tolerance"},
            "type": "log",
            "range": [float(low) - 0.2, float(high) + 0.2],
            "dtick": 1 if high - low > 2 else "D2",
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
        "with the best one so far and a line at 1, below which all responses are within tolerance."
    )
    return Figure(tuple(traces), layout, words, height=340)


def _response_figure(
    context: ReportContext, index: int, target: Target, expected: list[_Expectation]
) -> Figure:
    evaluations = context.reading.evaluations
    label = context.response_label(target.name)
    values = [
        evaluation.responses[target.name].value if target.name in evaluation.responses else None
        for evaluation in evaluations
    ]
    traces = [
        *_expectation_traces(index, expected),
        *_points_by_stage(evaluations, values, f"%{{y:.5g}} {escape(label.unit)}"),
        _failures(evaluations, values),
    ]
    known = [value for value in values if value is not None]
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
    return Figure(tuple(traces), layout, words, height=320)


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
                "marker": {"symbol": symbol, "color": colour, "size": 8, "line": {"width": 1.5}},
                "hovertemplate": f"run %{{x}}: {hover}<extra>{stage}</extra>",
            }


def _failures(evaluations: Sequence[Evaluation], values: Sequence[float | None]) -> dict[str, Any]:
    """Runs without a value, at the lower edge of the figure."""
    numbers = [number for number, value in enumerate(values, 1) if value is None]
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
        "marker": {"symbol": "x", "color": VERMILION, "size": 8},
        "text": [_wrapped(reason) for reason in reasons],
        "hovertemplate": "run %{x} failed: %{text}<extra></extra>",
    }


def _wrapped(text: str, width: int = 60) -> str:
    """The text in lines that fit into a figure, at most four."""
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
    }


def _failure_axis() -> dict[str, Any]:
    """An axis that is not seen, to put marks at the lower edge whatever is shown above."""
    return {"overlaying": "y", "range": [0, 1], "visible": False, "fixedrange": True}


# --- What was expected at the answer after so many runs ---------------------------------------

#: Number of runs, expected responses and their standard errors.
_Expectation = tuple[int, np.ndarray[Any, Any], np.ndarray[Any, Any]]


def _checkpoints(context: ReportContext) -> list[int]:
    """Numbers of runs after which it is asked what is expected at the answer."""
    reading = context.reading
    most = min(len(reading.evaluations), max(_MOST_FITTED - len(reading.learnt), _FEWEST_FITTED))
    if not context.answer or not can_be_fitted(reading.problem, _known_after(context, most)):
        return []
    least = next(
        n for n in range(most + 1) if can_be_fitted(reading.problem, _known_after(context, n))
    )
    return sorted({round(float(n)) for n in np.geomspace(max(least, 1), most, _FITS)})


def _known_after(context: ReportContext, count: int) -> Sequence[Evaluation]:
    """The first runs that were asked for, and all that was learnt before these."""
    reading = context.reading
    return replace(reading, evaluations=reading.evaluations[:count]).known


def _expected_at_the_answer(context: ReportContext) -> list[_Expectation]:
    problem = context.reading.problem
    found = []
    for count in _checkpoints(context):
        metamodels = Metamodels.fit(problem, _known_after(context, count))
        means, variances = metamodels.predict(problem.to_unit(context.answer))
        found.append((count, means[0], np.sqrt(variances[0])))
    return found


def _expectation_traces(index: int, expected: list[_Expectation]) -> list[dict[str, Any]]:
    """A line with its 95 % interval."""
    if len(expected) < 2:
        return []
    numbers = [count for count, _, _ in expected]
    means = np.array([mean[index] for _, mean, _ in expected])
    half = 1.96 * np.array([error[index] for _, _, error in expected])
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
