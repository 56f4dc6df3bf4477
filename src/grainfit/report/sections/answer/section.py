"""Answer in one box: verdict, values, uncertainty and cost."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass
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
    unit_for_people,
    with_unit,
)
from grainfit.problem import Parameter
from grainfit.report.rendering import fill_template
from grainfit.report.rows import ParameterRow, curve_row, deviation, parameter_row, response_row
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


def answer(context: ReportContext) -> Section:
    """Verdict, parameters with their intervals, responses against measurements, cost."""
    result = context.reading.result
    found, curves = (result.responses, result.curves) if result else ({}, {})
    responses = [
        response_row(context.response_label(target.name), target, found.get(target.name))
        for target in context.targets
    ]
    responses += [
        curve_row(curve, curves.get(curve.name)) for curve in context.reading.problem.curves
    ]
    tests = _bulk_tests(context)
    html = fill_template(
        "answer/page",
        verdict=verdict(context),
        provisional=not context.answer and context.posterior is not None,
        parameters=[_parameter_row(context, parameter) for parameter in context.parameters],
        why_no_interval=context.why_no_posterior,
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
    return f"{words} deviates by {deviation(response)}, and {accepted} are accepted"


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
    label = context.parameter_label(name)
    return parameter_row(label, parameter, value, context.intervals.get(name))


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
            warm_start_runs=sum(len(evaluation.runs) for evaluation in reading.warm_start),
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
    shown = verdict(context).details
    yield from (plain(words) for words in dict.fromkeys(said) if words not in shown)


def _bulk_tests(context: ReportContext) -> dict[str, BulkTest]:
    """Return the bulk tests of the runs, by name of the test, as far as they are known."""
    tests = {}
    for record in context.reading.records.values():
        if record.test not in tests:
            with suppress(InputError):
                tests[record.test] = recreate_test(record.definition)
    return {name: test for name, test in tests.items() if test is not None}
