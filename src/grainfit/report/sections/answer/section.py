"""Answer in one box: verdict, values, uncertainty and cost."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping
from typing import Any

from grainfit.analysis.soft_particles import of_hertz, stiffness_notes
from grainfit.bulk_tests.apparatus import as_smaller
from grainfit.bulk_tests.base import BulkTest
from grainfit.formatting import (
    duration,
    in_usual_unit,
    number,
    plain,
)
from grainfit.plots.labels import Label
from grainfit.problem import Parameter
from grainfit.report.rendering import fill_template
from grainfit.report.rows import ParameterRow, curve_row, parameter_row, response_row
from grainfit.report.section import ReportContext, Section
from grainfit.report.sections.answer.next_step import next_step
from grainfit.report.sections.answer.simulated_tests import simulated_tests
from grainfit.report.verdict import shown_verdict
from grainfit.result import Result, RunCounts
from grainfit.result.holdout import runs_of_holdouts
from grainfit.work_folder.saved_calibration import bulk_tests_of, twins_of

#: Digits of a fixed parameter: it is as it was given.
_DIGITS = 6


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
    tests = bulk_tests_of(context.reading)
    html = fill_template(
        "answer/page",
        verdict=shown_verdict(context),
        provisional=not context.answer and context.posterior is not None,
        parameters=[_parameter_row(context, parameter) for parameter in context.parameters],
        why_no_interval=context.why_no_posterior,
        responses=responses,
        has_fresh=any(row.fresh for row in responses),
        fixed=list(_fixed(context)),
        sizes=next((plain(test.sizes.words) for test in tests.values()), ""),
        time_step=_time_step(result) if result else None,
        cost=_cost(context),
        notices=list(_notices(context, tests)),
        tests=simulated_tests(_with_twins(context, tests), context.reading.options),
        has_twins=bool(context.reading.laboratory),
        **next_step(context),
    )
    return Section("answer", "Answer", html)


def _fixed(context: ReportContext) -> Iterator[tuple[Label, str]]:
    units = context.reading.units
    for name, value in context.reading.fixed.items():
        yield context.parameter_label(name), in_usual_unit(value, units.get(name, ""), _DIGITS)


def _with_twins(context: ReportContext, tests: Mapping[str, BulkTest]) -> dict[str, BulkTest]:
    """Return the tests, and the smaller ones that were simulated for them."""
    twins = twins_of(context.reading)
    return {**tests, **{as_smaller(name): twin for name, twin in twins.items()}}


def _parameter_row(context: ReportContext, parameter: Parameter) -> ParameterRow:
    posterior, name = context.posterior, parameter.name
    value = context.answer.get(name)
    if value is None and posterior is not None:
        value = float(posterior.median(name))
    label = context.parameter_label(name)
    return parameter_row(label, parameter, value, context.intervals.get(name))


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
        "holdouts": runs_of_holdouts(result.holdouts) if result else "",
        "wall": duration(result.wall_seconds) if result else None,
        "simulated": duration(sum(record.seconds for record in reading.records.values())),
        "workers": reading.workers,
    }


def _notices(context: ReportContext, tests: Mapping[str, BulkTest]) -> Iterator[str]:
    result = context.reading.result
    said = [*result.notices] if result else []
    if result:
        for name, quality in result.metamodels.items():
            words = quality.part or context.response_label(name).words
            said += [f"Metamodel of {words}: {warning}" for warning in quality.warnings]
    said += context.analysis.notes
    reading = context.reading
    tests = of_hertz(tests, reading.contact_models)
    said += stiffness_notes(reading.problem, tests, reading.fixed, context.answer or None)
    shown = shown_verdict(context).details
    untold = dict.fromkeys(words for words in said if words not in shown)
    yield from map(context.in_words, untold)
