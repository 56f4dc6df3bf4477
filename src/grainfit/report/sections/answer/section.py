"""Answer in one box: verdict, values, uncertainty and cost."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from statistics import fmean
from typing import Any, Literal

from grainfit.analysis.stiffness_notes import stiffness_notes
from grainfit.bulk_tests.base import BulkTest
from grainfit.bulk_tests.registry import recreate_test
from grainfit.errors import InputError
from grainfit.formatting import (
    counted,
    duration,
    number,
    plain,
    probability,
    rounded,
    unit_for_people,
    with_unit,
)
from grainfit.materials.card import Determination
from grainfit.plots.labels import Label
from grainfit.problem import CurveTarget, Parameter, Target
from grainfit.report.rendering import render
from grainfit.report.section import ReportContext, Section
from grainfit.report.sections.answer.next_step import next_step
from grainfit.report.sections.answer.simulated_tests import simulated_tests
from grainfit.result import ResponseResult, Result, RunCounts


@dataclass(frozen=True)
class Verdict:
    """Outcome of a calibration: a grade, one line, and details."""

    grade: Literal["good", "warn", "bad"]
    line: str
    details: tuple[str, ...] = ()

    @property
    def mark(self) -> str:
        """A sign that shows the grade without colour."""
        return {"good": "✓", "warn": "!", "bad": "✗"}[self.grade]


@dataclass(frozen=True)
class ParameterRow:
    """A parameter as it is shown; positions are percentages of its interval."""

    label: Label
    value: str
    interval: str
    why_no_interval: str
    determination: Determination | Literal[""]
    position: float | None
    credible: tuple[float, float] | None
    searched: str
    measured: str


@dataclass(frozen=True)
class ResponseRow:
    """A response as it is shown."""

    label: Label
    measured: str
    tolerance: str
    expected: str
    half_width: str
    fresh: str
    deviation: str
    verdict: str


def answer(context: ReportContext) -> Section:
    """Verdict, parameters with their intervals, responses against measurements, cost."""
    result = context.reading.result
    responses = [_response_row(context, target) for target in context.targets]
    responses += [_curve_row(context, target) for target in context.reading.problem.curves]
    tests = _bulk_tests(context)
    html = render(
        "answer/page",
        verdict=verdict(context),
        provisional=not context.answer and context.posterior is not None,
        parameters=[_parameter_row(context, parameter) for parameter in context.parameters],
        responses=responses,
        has_fresh=any(row.fresh for row in responses),
        fixed=[
            (context.parameter_label(name), number(value, 6))
            for name, value in context.reading.fixed.items()
        ],
        sizes=next((plain(test.sizes.words) for test in tests.values()), ""),
        time_step=_time_step(result) if result else None,
        cost=_cost(context),
        notices=list(_notices(context, tests)),
        tests=simulated_tests(tests),
        **next_step(context),
    )
    return Section("answer", "Answer", html)


def verdict(context: ReportContext) -> Verdict:
    """Return the outcome of the calibration in words, or its progress."""
    reading = context.reading
    runs = sum(len(evaluation.runs) for evaluation in reading.evaluations)
    ended = f"Simulated so far: {counted(runs, 'run')}"
    match reading.state:
        case "running":
            words = f"{ended}; under way: {counted(reading.running, 'run')}."
            return Verdict("warn", "Running: no answer yet.", (words,))
        case "failed":
            why = plain(reading.failure)
            details = [why[0].upper() + why[1:]] if why else []
            if reading.evaluations:
                details.append(f"{ended}.")
            return Verdict("bad", "Stopped by an error.", tuple(details))
        case "interrupted":
            so_far = "The numbers are the best so far." if context.answer else "No answer yet."
            words = f"{ended}. Start the same command again to continue."
            return Verdict("warn", f"Interrupted. {so_far}", (words, *_determinations(context)))
    if not context.answer:
        words = plain(reading.result_fault) or (
            "Its result.json is missing. Start the same command again: it is written again."
        )
        ended = f"It has ended ({plain(reading.state)}), but there is no answer to be read."
        return Verdict("warn", ended, (words,))
    return _final_verdict(context)


def _final_verdict(context: ReportContext) -> Verdict:
    result = context.reading.result
    assert result is not None, "an answer comes from a result"
    sure = (*filter(None, [result.sureness]), *_determinations(context))
    if context.reading.state == "calibrated":
        return Verdict("good", "Calibrated: every measurement is met within its tolerance.", sure)
    misses = tuple(map(str, result.out_of_reach))
    if context.reading.state == "unreachable" and misses:
        return Verdict("bad", "Out of reach within the given intervals.", misses)
    if context.reading.state == "undecided":
        return _undecided(context, result, sure)
    missed = "; ".join(
        _miss(context.response_label(name).words, response)
        for name, response in result.responses.items()
        if response.verdict != "met"
    )
    if not missed:
        # Correlated ones, which are met one by one.
        line = "Not calibrated: the measurements are not met together."
        return Verdict("bad", line, (*_reasons(result), *sure))
    return Verdict("bad", f"Not calibrated: {missed}.", sure)


def _undecided(context: ReportContext, result: Result, sure: tuple[str, ...]) -> Verdict:
    """Return what is in doubt, and the reasons: they say what to do."""
    doubtful = [
        context.response_label(name).words + _likelihood(response)
        for name, response in result.responses.items()
        if response.verdict != "met"
    ]
    what = " and ".join(doubtful) or "every measurement"
    verb = "are" if len(doubtful) > 1 else "is"
    line = f"Undecided: the runs do not tell whether {what} {verb} met."
    if any(reason.gives_probability for reason in result.reasons):
        sure = tuple(_determinations(context))
    return Verdict("warn", line, (*_reasons(result), *sure))


def _reasons(result: Result) -> Iterator[str]:
    """Yield the reasons for the verdict; those of version 0.2.0 or older are among the notices."""
    yield from map(plain, map(str, result.reasons) if result.reasons else result.notices)


def _likelihood(response: ResponseResult) -> str:
    return "" if response.probability is None else f" ({probability(response.probability)})"


def _miss(words: str, response: ResponseResult) -> str:
    accepted = _accepted(response)
    if response.verdict == "in doubt" and response.probability is not None:
        likely = probability(response.probability)
        return f"{words} is within {accepted} with a probability of {likely}"
    return f"{words} deviates by {_deviation(response)}, and {accepted} are accepted"


def _determinations(context: ReportContext) -> Iterator[str]:
    """Say how well each parameter of the answer is determined."""
    words = "; ".join(
        f"{context.parameter_label(p.name).words} "
        + context.intervals[p.name].in_words(context.answer[p.name], p.unit)
        for p in context.parameters
        if p.name in context.intervals and p.name in context.answer
    )
    if words:
        yield f"{words[0].upper()}{words[1:]}."


def _parameter_row(context: ReportContext, parameter: Parameter) -> ParameterRow:
    posterior, name = context.posterior, parameter.name
    value = context.answer.get(name)
    if value is None and posterior is not None:
        value = float(posterior.median(name))
    found = context.intervals.get(name)
    interval = (found.low, found.high) if found else None
    # On a logarithmic scale, the digits of one end mean nothing at the other.
    half_width = (found.high - found.low) / 2 if found and parameter.scale == "linear" else None
    return ParameterRow(
        label=context.parameter_label(name),
        value=_shown(value, half_width),
        interval=" … ".join(_shown(bound, half_width) for bound in interval) if interval else "",
        why_no_interval=context.why_no_posterior,
        determination=found.determination if found else "",
        position=None if value is None else _position(parameter, value),
        credible=(_position(parameter, interval[0]), _position(parameter, interval[1]))
        if interval
        else None,
        searched=f"{number(parameter.minimum)} … {number(parameter.maximum)}",
        measured=_measured(parameter),
    )


def _measured(parameter: Parameter) -> str:
    """Return the value that a measurement of its own gave; empty without one."""
    if parameter.measured is None or parameter.uncertainty is None:
        return ""
    return f"measured {number(parameter.measured)} ± {number(parameter.uncertainty, 3)}"


def _shown(value: float | None, half_width: float | None) -> str:
    return number(value, 3) if half_width is None else rounded(value, half_width)


def _position(parameter: Parameter, value: float) -> float:
    """Position of a value in its interval, percent."""
    return round(100 * min(max(parameter.to_unit(value), 0.0), 1.0), 2)


def _response_row(context: ReportContext, target: Target) -> ResponseRow:
    result = context.reading.result
    response = result.responses.get(target.name) if result else None
    label = context.response_label(target.name)
    tolerance = target.tolerance
    measured = {"measured": number(target.value, 6), "tolerance": number(tolerance, 3)}
    if response is None:
        return ResponseRow(
            label,
            **measured,
            expected="–",
            half_width="",
            fresh="",
            deviation="–",
            verdict="",
        )
    expected, half_width = response.expected
    return ResponseRow(
        label,
        **measured,
        expected=rounded(expected, half_width),
        half_width=rounded(half_width, half_width),
        fresh=_fresh(response),
        deviation=_deviation(response),
        verdict=response.verdict,
    )


def _curve_row(context: ReportContext, target: CurveTarget) -> ResponseRow:
    result = context.reading.result
    found = result.curves.get(target.name) if result else None
    label = Label(target.name, target.name, "", "")
    return ResponseRow(
        label,
        measured=counted(len(target.values), "point"),
        tolerance="",
        expected="see the curve",
        half_width="",
        fresh=_root_mean_square(found.verified_deviations) if found else "",
        deviation=f"{number(found.deviation, 2)} σ" if found else "–",
        verdict=found.verdict if found else "",
    )


def _root_mean_square(deviations: Sequence[float]) -> str:
    if not deviations:
        return ""
    return f"{number(math.sqrt(fmean(one**2 for one in deviations)), 2)} σ off"


def _fresh(response: ResponseResult) -> str:
    mean, half_width = response.verified_mean, response.verified_interval
    if mean is None or half_width is None:
        return ""
    return f"{rounded(mean, half_width)} ± {rounded(half_width, half_width)}"


def _deviation(response: ResponseResult) -> str:
    return response.deviation_in_words(unit_for_people(response.unit)).replace("-", "−")


def _accepted(response: ResponseResult) -> str:
    if response.deviation_percent is None:
        return f"±{with_unit(number(response.tolerance, 3), unit_for_people(response.unit))}"
    return f"±{number(100 * response.tolerance / abs(response.target), 3)} %"


def _time_step(result: Result) -> dict[str, str] | None:
    step, before = result.rayleigh_time_step, result.rayleigh_time_step_before
    if step is None or not before:
        return None
    return {
        "value": seconds(step),
        "factor": number(step / before, 3),
        "before": seconds(before),
    }


def seconds(value: float) -> str:
    """Return a short time with a unit that suits it.

    Examples
    --------
    >>> seconds(0.002153)
    '2.153 ms'
    """
    for unit, size in (("s", 1.0), ("ms", 1e-3), ("µs", 1e-6)):
        if value >= size:
            return f"{number(value / size)} {unit}"
    return f"{number(value / 1e-9)} ns"


def _cost(context: ReportContext) -> dict[str, Any]:
    reading = context.reading
    result = reading.result
    stages = Counter[str]()
    for evaluation in reading.evaluations:
        stages[evaluation.proposal.stage] += len(evaluation.runs)
    counts = (
        result.runs
        if result
        else RunCounts(
            **stages,
            failed=sum(len(evaluation.failed_runs) for evaluation in reading.evaluations),
            total=sum(stages.values()),
            warm_start_runs=sum(len(evaluation.runs) for evaluation in reading.learnt),
        )
    )
    return {
        "counts": counts,
        "wall": duration(result.wall_seconds) if result else None,
        "simulated": duration(sum(record.seconds for record in reading.records.values())),
        "workers": reading.workers,
    }


def _notices(context: ReportContext, tests: Mapping[str, BulkTest]) -> Iterator[str]:
    result = context.reading.result
    said = [*result.remarks] if result else []
    if result:
        for name, quality in result.metamodels.items():
            words = quality.part or context.response_label(name).words
            said += [f"Metamodel of {words}: {warning}" for warning in quality.warnings]
    said += context.analysis.notes
    reading = context.reading
    said += stiffness_notes(reading.problem, tests, reading.fixed, context.answer or None)
    told = verdict(context).details
    yield from (plain(words) for words in dict.fromkeys(said) if words not in told)


def _bulk_tests(context: ReportContext) -> dict[str, BulkTest]:
    """Return the bulk tests of the runs, by name of the test, as far as they are known."""
    tests = {}
    for record in context.reading.records.values():
        if record.test not in tests:
            with suppress(InputError):
                tests[record.test] = recreate_test(record.definition)
    return {name: test for name, test in tests.items() if test is not None}
