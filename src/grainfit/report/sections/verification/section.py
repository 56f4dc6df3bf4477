"""Verification: responses of the answer with fresh seeds, as a check of what all runs expect."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from html import escape
from typing import Any

from grainfit.formatting import interval, number, plain, with_unit
from grainfit.plots.figure import Figure
from grainfit.plots.labels import Label
from grainfit.plots.style import BLUE, GREEN, STAGES, tolerance_band, value_range
from grainfit.problem import Target
from grainfit.report import messages
from grainfit.report.rendering import fill_template
from grainfit.report.section import ReportContext, Section
from grainfit.result import ResponseResult, Result
from grainfit.verdict.reasons import (
    Contradicted,
    FullSizeFailed,
    FullSizeMade,
    FullSizePending,
)
from grainfit.work_folder.saved_calibration import bulk_tests_of

#: Colour of the runs, as in the other figures.
_SYMBOL, _COLOUR = STAGES["verification"]
#: Rows of the figure.
_RUNS, _MEAN, _ALL = "fresh seeds", "their mean", "all runs"


@dataclass(frozen=True)
class VerifiedRow:
    """A response over the verification runs, in words."""

    label: Label
    grade: str
    mark: str
    words: str
    none_outlying: str


@dataclass(frozen=True)
class _Check:
    """A response at the answer by fresh seeds, and whether they contradict the other runs."""

    target: Target
    response: ResponseResult
    values: Mapping[int, float]
    differs: bool

    @property
    def mean(self) -> tuple[float, float]:
        """Mean of the fresh seeds, and half of its 95 % interval."""
        found = self.response
        assert found.verified_mean is not None, "two values have a mean"
        assert found.verified_interval is not None, "and an interval"
        return found.verified_mean, found.verified_interval


def verification(context: ReportContext) -> Section:
    """Fresh seeds at the answer against all runs and the measurements."""
    result = context.reading.result
    found = _checks(context, result) if result is not None and context.answer else []
    checks = [check for check in found if check.response.verified_interval is not None]
    curves = result.curves if result is not None and context.answer else {}
    counts = [len(check.values) for check in found] + [c.verified_runs for c in curves.values()]
    at_full_size = _at_full_size(result) if result else []
    count = 0 if at_full_size else max(counts, default=0)
    html = fill_template(
        "verification/page",
        rows=[_row(context, check) for check in checks],
        curves={plain(name): found.fresh for name, found in curves.items() if found.fresh},
        count=count,
        single=plain(result.single_runs()) if result else "",
        has_answer=bool(context.answer),
        has_ended=context.reading.state not in ("running", "interrupted"),
        others=_all_verifications(context) - count,
        full_size=at_full_size,
    )
    figures = {
        f"verification-{index}": _figure(context.response_label(check.target.name), check)
        for index, check in enumerate(checks)
    }
    return Section("verification", "Verification", html, figures)


def _at_full_size(result: Result) -> list[str]:
    """Return what runs of the laboratory's apparatus gave, where smaller ones were simulated."""
    kinds = FullSizePending, FullSizeMade, FullSizeFailed
    return [plain(str(reason)) for reason in result.reasons if isinstance(reason, kinds)]


def _checks(context: ReportContext, result: Result) -> list[_Check]:
    doubted = {reason.target for reason in result.reasons if isinstance(reason, Contradicted)}
    return [
        _Check(target, found, _fresh(context, target.name, found), target.name in doubted)
        for target in context.targets
        if (found := result.responses.get(target.name)) is not None
    ]


def _fresh(context: ReportContext, name: str, response: ResponseResult) -> Mapping[int, float]:
    """Return the responses of fresh seeds by seed."""
    if response.probability is not None:
        return dict(zip(response.verified_seeds, response.verified_values, strict=True))
    # Results of version 0.1.0 do not have them.
    return {
        evaluation.proposal.seed: evaluation.responses[name].value
        for evaluation in context.reading.evaluations
        if evaluation.proposal.stage == "verification"
        and evaluation.proposal.parameters == context.answer
        and name in evaluation.responses
    }


def _all_verifications(context: ReportContext) -> int:
    stages = [evaluation.proposal.stage for evaluation in context.reading.evaluations]
    return stages.count("verification")


def _row(context: ReportContext, check: _Check) -> VerifiedRow:
    label, target = context.response_label(check.target.name), check.target
    wanted = f"{number(target.value, 6)} ± {number(target.tolerance, 3)}"
    words = (
        f"their mean is {with_unit(interval(*check.mean), label.unit)}; all runs together "
        f"lead to expect {with_unit(interval(*check.response.expected), label.unit)}, and "
        f"{with_unit(wanted, label.unit)} was measured"
    )
    share = check.response.jams_not_excluded
    outlying = "" if share is None else _none_outlying(context, share, target.name)
    if check.differs:
        return VerifiedRow(label, "warn", "! differs", words, outlying)
    return VerifiedRow(label, "good", "✓ agrees", words, outlying)


def _none_outlying(context: ReportContext, share: float, name: str) -> str:
    """Say which share of outlying runs is not excluded; particles can also jam."""
    test, dot, _ = name.rpartition(".")
    tests = bulk_tests_of(context.reading)
    can_jam = test in tests if dot else bool(tests)
    words = messages.NO_JAMS if can_jam else messages.NO_OUTLYING_RUNS
    return words(share=number(100 * share, 2))


def _figure(label: Label, check: _Check) -> Figure:
    values, target = list(check.values.values()), check.target
    unit = escape(label.unit)
    points: dict[str, Any] = {
        "type": "scatter",
        "mode": "markers",
        "name": "fresh seeds",
        "x": values,
        "y": [_RUNS] * len(values),
        "customdata": list(check.values),
        "marker": {"symbol": _SYMBOL, "color": _COLOUR, "size": 9, "opacity": 0.75},
        "hovertemplate": f"%{{x:.5g}} {unit}, seed %{{customdata}}<extra></extra>",
    }
    rows = ((_MEAN, check.mean, BLUE), (_ALL, check.response.expected, GREEN))
    ends = [middle + sign * half for _, (middle, half), _ in rows for sign in (-1, 1)]
    layout = {
        "xaxis": {"title": {"text": label.axis}, "range": value_range(target, [*values, *ends])},
        "yaxis": {
            "type": "category",
            "categoryarray": [_ALL, _MEAN, _RUNS],
            "range": [-0.6, 2.6],
            "automargin": True,
        },
        "shapes": tolerance_band(target, "x"),
        "showlegend": False,
    }
    words = (
        f"{label.words} of {len(values)} verification runs, their mean with its 95 % interval and "
        "the expected value by all runs with its own, with the measured value and its tolerance as "
        "a band."
    )
    return Figure((points, *(_interval(*row, unit) for row in rows)), layout, words, height=220)


def _interval(
    name: str, interval: tuple[float, float], colour: str, unit: str
) -> Mapping[str, Any]:
    middle, half_width = interval
    return {
        "type": "scatter",
        "mode": "markers",
        "name": f"{name}, with 95 % interval",
        "x": [middle],
        "y": [name],
        "error_x": {"type": "data", "array": [half_width], "color": colour, "width": 8},
        "marker": {"symbol": "circle", "color": colour, "size": 11},
        "hovertemplate": f"%{{x:.5g}} ± {half_width:.2g} {unit}<extra>{name}</extra>",
    }
