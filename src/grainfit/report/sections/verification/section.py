"""Verification: responses of the answer with fresh seeds that nothing was fitted to."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from html import escape
from typing import Any

from grainfit.calibration.verification import Verified, verified_responses
from grainfit.evaluation import Evaluation
from grainfit.formatting import number, rounded, with_unit
from grainfit.plots.figure import Figure
from grainfit.plots.labels import Label
from grainfit.plots.style import BLUE, STAGES, tolerance_band, value_range
from grainfit.problem import Target
from grainfit.report.rendering import render
from grainfit.report.section import ReportContext, Section

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
    """Fresh seeds at the answer against the measurements."""
    runs = _runs_at_the_answer(context)
    verified = verified_responses(context.reading.problem, runs)
    rows = [
        _row(context, target, verified[target.name])
        for target in context.targets
        if target.name in verified
    ]
    figures = {
        f"verification-{index}": _figure(
            context.response_label(target.name), target, runs, verified[target.name]
        )
        for index, target in enumerate(
            target for target in context.targets if target.name in verified
        )
    }
    html = render(
        "verification/page",
        rows=rows,
        count=len(runs),
        failed=sum(1 for run in runs if run.failures),
        has_answer=bool(context.answer),
        others=_other_verifications(context) - len(runs),
    )
    return Section("verification", "Verification", html, figures)


def _runs_at_the_answer(context: ReportContext) -> list[Evaluation]:
    return [
        evaluation
        for evaluation in context.reading.evaluations
        if evaluation.proposal.stage == "verification"
        and evaluation.proposal.parameters == context.answer
    ]


def _other_verifications(context: ReportContext) -> int:
    stages = [evaluation.proposal.stage for evaluation in context.reading.evaluations]
    return stages.count("verification")


def _row(context: ReportContext, target: Target, verified: Verified) -> VerifiedRow:
    label = context.response_label(target.name)
    mean = f"{rounded(verified.mean, verified.half_width)} ± {number(verified.half_width, 2)}"
    wanted = f"{number(target.value, 6)} ± {number(target.tolerance, 3)}"
    words = (
        f"their mean is {with_unit(mean, label.unit)}, "
        f"and {with_unit(wanted, label.unit)} was measured"
    )
    result = context.reading.result
    if verified.is_met(target):
        if result is None or result.responses[target.name].verdict != "in doubt":
            return VerifiedRow(label, "good", "✓ met", words)
        words += (
            ". The tolerance ends within the interval, and by all runs together a response outside "
            "of it is expected"
        )
        return VerifiedRow(label, "warn", "! in doubt", words)
    if verified.is_marginally_missed(target):
        words += ". More runs could still turn it: the tolerance begins within the interval"
        return VerifiedRow(label, "warn", "! missed narrowly", words)
    return VerifiedRow(label, "bad", "✗ missed", words)


def _figure(label: Label, target: Target, runs: Sequence[Evaluation], verified: Verified) -> Figure:
    found = [run for run in runs if target.name in run.responses]
    values = [run.responses[target.name].value for run in found]
    unit = escape(label.unit)
    points: dict[str, Any] = {
        "type": "scatter",
        "mode": "markers",
        "name": "fresh seeds",
        "x": values,
        "y": ["runs"] * len(values),
        "customdata": [run.proposal.seed for run in found],
        "marker": {"symbol": _SYMBOL, "color": _COLOUR, "size": 9, "opacity": 0.75},
        "hovertemplate": f"%{{x:.5g}} {unit}, seed %{{customdata}}<extra></extra>",
    }
    mean: dict[str, Any] = {
        "type": "scatter",
        "mode": "markers",
        "name": "mean with 95 % interval",
        "x": [verified.mean],
        "y": ["mean"],
        "error_x": {"type": "data", "array": [verified.half_width], "color": BLUE, "width": 8},
        "marker": {"symbol": "circle", "color": BLUE, "size": 11},
        "hovertemplate": f"%{{x:.5g}} ± {verified.half_width:.2g} {unit}<extra>mean</extra>",
    }
    edges = [verified.mean - verified.half_width, verified.mean + verified.half_width]
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
