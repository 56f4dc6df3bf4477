"""Verdict in words and a colour, as the report and the page of a watch show it."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Literal

from grainfit.formatting import (
    as_sentence,
    counted,
    number,
    plain,
    probability,
    unit_for_people,
    with_unit,
)
from grainfit.report import verdict_messages as messages
from grainfit.report.rows import deviation
from grainfit.report.section import ReportContext
from grainfit.result import ResponseResult, Result
from grainfit.result.holdout import holdouts_in_short
from grainfit.verdict.messages import state_name
from grainfit.verdict.reasons import Deterministic, FullSizeMade


@dataclass(frozen=True)
class ShownVerdict:
    """Verdict on a calibration, or its progress: a grade, one line, and details."""

    grade: Literal["good", "warn", "bad"]
    line: str
    details: tuple[str, ...] = ()

    @property
    def mark(self) -> str:
        """A sign that shows the grade without colour."""
        return {"good": "✓", "warn": "!", "bad": "✗"}[self.grade]


def shown_verdict(context: ReportContext) -> ShownVerdict:
    """Return the outcome of the calibration in words, or its progress."""
    reading = context.reading
    runs = sum(len(evaluation.runs) for evaluation in reading.evaluations)
    ended = counted(runs, "run")
    match reading.state:
        case "running":
            running = counted(reading.running, "run")
            words = messages.SIMULATED_AND_RUNNING(runs=ended, running=running)
            return ShownVerdict("warn", messages.RUNNING(), (words,))
        case "failed":
            why = plain(reading.failure)
            details = [as_sentence(why)] if why else []
            if reading.evaluations:
                details.append(messages.SIMULATED(runs=ended))
            return ShownVerdict("bad", messages.STOPPED(), tuple(details))
        case "interrupted":
            line = messages.INTERRUPTED if context.answer else messages.INTERRUPTED_EARLY
            words = messages.CONTINUE(runs=ended)
            return ShownVerdict("warn", line(), (words, *_determinations(context)))
    if not context.answer:
        words = plain(reading.result_fault) or messages.RESULT_MISSING()
        unread = messages.NO_ANSWER(state=plain(state_name(reading.state)))
        return ShownVerdict("warn", unread, (words,))
    return _with_holdouts(_final_verdict(context), context.reading.result)


def _with_holdouts(found: ShownVerdict, result: Result | None) -> ShownVerdict:
    """Return a verdict with how hold-outs ended: what they refute is not simply good."""
    holdouts = result.holdouts if result else ()
    if not (words := holdouts_in_short(holdouts)):
        return found
    is_refuted = any(one.is_refuted for one in holdouts)
    grade = "warn" if found.grade == "good" and is_refuted else found.grade
    return replace(found, grade=grade, details=(plain(words), *found.details))


def _final_verdict(context: ReportContext) -> ShownVerdict:
    result = context.reading.result
    assert result is not None, "an answer comes from a result"
    sure = (*filter(None, [result.sureness]), *_determinations(context))
    if context.reading.state == "undecided":
        return _undecided(context, result, sure)
    if context.reading.state == "predicted":
        return ShownVerdict("warn", messages.PREDICTED(), (*_reasons(result), *sure))
    shown = Deterministic, FullSizeMade
    single = (plain(str(one)) for one in result.reasons if isinstance(one, shown))
    sure = (*single, *sure)
    if context.reading.state == "calibrated":
        return ShownVerdict("good", messages.CALIBRATED(), sure)
    misses = tuple(plain(str(one)) for one in result.out_of_reach)
    if context.reading.state == "unreachable" and misses:
        return ShownVerdict("bad", messages.UNREACHABLE(), misses)
    missed = "; ".join(
        _miss(context.response_label(name).words, response)
        for name, response in result.responses.items()
        if response.verdict != "met"
    )
    if not missed:
        # Correlated ones, which are met one by one.
        line = messages.NOT_TOGETHER()
        return ShownVerdict("bad", line, (*_reasons(result), *sure))
    return ShownVerdict("bad", messages.NOT_CALIBRATED(missed=missed), sure)


def _undecided(context: ReportContext, result: Result, sure: tuple[str, ...]) -> ShownVerdict:
    """Return what is in doubt, and the reasons: they say what to do."""
    doubtful = [
        context.response_label(name).words + (_likelihood(response) if result.sureness else "")
        for name, response in result.responses.items()
        if response.verdict != "met"
    ]
    verb = "are" if len(doubtful) > 1 else "is"
    line = messages.UNDECIDED(what=" and ".join(doubtful) or "every measurement", verb=verb)
    if any(reason.gives_probability for reason in result.reasons):
        sure = tuple(_determinations(context))
    return ShownVerdict("warn", line, (*_reasons(result), *sure))


def _reasons(result: Result) -> Iterator[str]:
    """Yield the reasons for the verdict; those of version 0.2.0 or older are among the notices."""
    yield from map(plain, map(str, result.reasons) if result.reasons else result.notices)


def _likelihood(response: ResponseResult) -> str:
    return "" if response.probability is None else f" ({probability(response.probability)})"


def _miss(words: str, response: ResponseResult) -> str:
    accepted = _accepted(response)
    if response.verdict == "in doubt" and response.probability is not None:
        likely = probability(response.probability)
        return messages.DOUBTFUL(response=words, accepted=accepted, probability=likely)
    return messages.MISSED(response=words, deviation=deviation(response), accepted=accepted)


def _determinations(context: ReportContext) -> Iterator[str]:
    """Say how many parameters of the answer are determined, and which of them are biased."""
    found = {
        p.name: context.intervals[p.name]
        for p in context.parameters
        if p.name in context.intervals and p.name in context.answer
    }
    counts = Counter(
        "determined" if one.is_determined else one.determination for one in found.values()
    )
    if found:
        parameters = counted(len(found), "parameter")
        parts = (f"{count} {words}" for words, count in counts.items())
        yield messages.DETERMINATIONS(parameters=parameters, parts=", ".join(parts))
    for name, one in found.items():
        if one.bias:
            words = context.parameter_label(name).words
            yield messages.BIASED(parameter=words, bias=context.in_words(one.bias))


def _accepted(response: ResponseResult) -> str:
    if response.deviation_percent is None:
        return f"±{with_unit(number(response.tolerance, 3), unit_for_people(response.unit))}"
    return f"±{number(100 * response.tolerance / abs(response.target), 3)} %"
