"""Verification: responses of the answer with fresh seeds that nothing was fitted to."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from html import escape
from typing import Any

from grainfit.formatting import number, rounded, with_unit
from grainfit.plots.figure import Figure
from grainfit.plots.labels import Label
from grainfit.plots.style import BLUE, STAGES, tolerance_band, value_range
from grainfit.problem import Target
from grainfit.report.rendering import render
from grainfit.report.section import ReportContext, Section
from grainfit.result import ResponseResult

#: Colour of the runs, as in the other figures.
_SYMBOL, _COLOUR = STAGES["verification"]


@dataclass(frozen=True)
class VerifiedRow:
    """A response over the verification runs, in words."""

    label: Label
    grade: str
    mark: str
    words: str


def verification(context: ReportContext) -> Section:
    """Fresh seeds at the answer against all runs and the measurements."""
    result = context.reading.result
    responses = {} if result is None or not context.answer else result.responses
    checked = [t for t in context.targets if len(_values(responses.get(t.name))) > 1]
    rows = [_row(context, target, responses[target.name]) for target in checked]
    figures = {
        f"verification-{index}": _figure(
            context.response_label(target.name), target, responses[target.name]
        )
        for index, target in enumerate(checked)
    }
    count = max((len(_values(found)) for found in responses.values()), default=0)
    html = render(
        "verification/page",
        rows=rows,
        count=count,
        has_answer=bool(context.answer),
        others=_all_verifications(context) - count,
    )
    return Section("verification", "Verification", html, figures)


def _values(response: ResponseResult | None) -> Sequence[float]:
    return () if response is None else response.verified_values


def _all_verifications(context: ReportContext) -> int:
    stages = [evaluation.proposal.stage for evaluation in context.reading.evaluations]
    return stages.count("verification")


def _row(context: ReportContext, target: Target, response: ResponseResult) -> VerifiedRow:
    label = context.response_label(target.name)
    mean, half_width = _mean(response)
    expected, expected_half = response.expected
    fresh = f"{rounded(mean, half_width)} ± {number(half_width, 2)}"
    by_all = f"{rounded(expected, expected_half)} ± {number(expected_half, 2)}"
    wanted = f"{number(target.value, 6)} ± {number(target.tolerance, 3)}"
    words = (
        f"their mean is {with_unit(fresh, label.unit)}; all runs together lead to expect "
        f"{with_unit(by_all, label.unit)}, and {with_unit(wanted, label.unit)} was measured"
    )
    if abs(mean - expected) <= half_width + expected_half:
        return VerifiedRow(label, "good", "✓ agrees", words)
    return VerifiedRow(label, "warn", "! differs", words)


def _mean(response: ResponseResult) -> tuple[float, float]:
    assert response.verified_mean is not None, "two values have a mean"
    assert response.verified_interval is not None, "and an interval"
    return response.verified_mean, response.verified_interval


def _figure(label: Label, target: Target, response: ResponseResult) -> Figure:
    values = list(response.verified_values)
    middle, half_width = _mean(response)
    unit = escape(label.unit)
    points: dict[str, Any] = {
        "type": "scatter",
        "mode": "markers",
        "name": "fresh seeds",
        "x": values,
        "y": ["runs"] * len(values),
        "customdata": list(response.verified_seeds),
        "marker": {"symbol": _SYMBOL, "color": _COLOUR, "size": 9, "opacity": 0.75},
        "hovertemplate": f"%{{x:.5g}} {unit}, seed %{{customdata}}<extra></extra>",
    }
    mean: dict[str, Any] = {
        "type": "scatter",
        "mode": "markers",
        "name": "mean with 95 % interval",
        "x": [middle],
        "y": ["mean"],
        "error_x": {"type": "data", "array": [half_width], "color": BLUE, "width": 8},
        "marker": {"symbol": "circle", "color": BLUE, "size": 11},
        "hovertemplate": f"%{{x:.5g}} ± {half_width:.2g} {unit}<extra>mean</extra>",
    }
    edges = [middle - half_width, middle + half_width]
    layout = {
        "xaxis": {
            "title": {"text": label.axis},
            "range": value_range(target, [*values, *edges]),
        },
        "yaxis": {"type": "category", "categoryarray": ["mean", "runs"], "range": [-0.6, 1.6]},
        "shapes": tolerance_band(target, "x"),
        "showlegend": False,
    }
    words = (
        f"{label.words} of {len(values)} verification runs and their mean with its 95 % interval, "
        "with the measured value and its tolerance as a band."
    )
    return Figure((points, mean), layout, words, height=190)
