"""Rule of the verdict: an answer is calibrated when every target is probably met, and verified."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Literal

from grainfit.verdict.edge import is_at_edge
from grainfit.verdict.evidence import (
    CurveEvidence,
    Evidence,
    Expected,
    Scatter,
    TargetEvidence,
    Verified,
)
from grainfit.verdict.options import VERDICT
from grainfit.verdict.reasons import (
    AtEdge,
    Contradicted,
    CurveContradicted,
    Deterministic,
    DeterministicInDoubt,
    FreshSeedsMissing,
    NoisyResponse,
    NotTogether,
    OnTheEdge,
    OtherShape,
    OutliersDecide,
    Reason,
    RecordsRepeated,
    ScatterChanges,
    TooFewRuns,
    TooMuchScatter,
    TwoStates,
    UselessScatter,
)

Status = Literal[
    "calibrated", "predicted", "undecided", "out_of_tolerance", "unreachable", "interrupted"
]
Verdict = Literal["met", "in doubt", "missed"]


@dataclass(frozen=True)
class Judgement:
    """Verdict on an answer and on each of its targets.

    Parameters
    ----------
    status : {"calibrated", "undecided", "out_of_tolerance", "unreachable"}
        The verdict on the whole answer.
    responses, curves : mapping of str to {"met", "in doubt", "missed"}
        The verdict on each target, components of curves included, and on each curve.
    contradicted : tuple of str
        Targets for which the fresh seeds contradict all runs together.
    lacking : mapping of str to int
        Runs with fresh seeds that are missing, by name of the test.
    """

    status: Status
    responses: Mapping[str, Verdict]
    curves: Mapping[str, Verdict]
    contradicted: tuple[str, ...]
    lacking: Mapping[str, int]


def judge(evidence: Evidence) -> Judgement:
    """Judge an answer.

    It is calibrated when every expected response is within its tolerance with the demanded
    probability, by all runs, and enough fresh seeds at it do not contradict them.
    """
    contradicted = tuple(one.name for one in evidence.targets if is_contradicted(one))
    lacking = _lacking(evidence)
    doubted = bool(contradicted) or sum(lacking.values()) > 0 or len(evidence.no_record) > 0
    confidence = evidence.confidence
    every = [one.name for one in evidence.targets]
    unread = [n for miss in evidence.no_record for n in evidence.tests.get(miss.test, every)]
    return Judgement(
        _status(evidence, in_doubt=doubted),
        {
            one.name: verdict_by(
                one.probability,
                confidence,
                is_off=one.is_off,
                in_doubt=one.name in {*contradicted, *unread},
            )
            for one in evidence.targets
        },
        {one.name: _verdict_on_curve(one, evidence, contradicted) for one in evidence.curves},
        contradicted,
        lacking,
    )


def _status(evidence: Evidence, *, in_doubt: bool) -> Status:
    if evidence.out_of_reach:
        return "unreachable"
    if any(curve.has_other_shape for curve in evidence.curves):
        return "out_of_tolerance"
    probability = evidence.probability_all_met
    is_off = any(one.is_off for one in evidence.targets)
    return status_by(probability, evidence.confidence, is_off=is_off, in_doubt=in_doubt)


def status_by(
    probability: float, confidence: float, *, is_off: bool, in_doubt: bool = False
) -> Status:
    """Return the verdict on an answer.

    A small probability alone is no miss: where little is known, it may be that of the best answer.

    Parameters
    ----------
    probability, confidence : float
        That every expected response is within its tolerance, and the demanded one.
    is_off : bool
        Whether an expected response is beyond its tolerance.
    in_doubt : bool
        Whether something else keeps it from being calibrated.
    """
    if probability >= confidence and not in_doubt:
        return "calibrated"
    return "out_of_tolerance" if is_off and probability <= 1 - confidence else "undecided"


def probability_within(expected: float, error: float, value: float, tolerance: float) -> float:
    """Return the probability that an expected response is within a tolerance of a value.

    Parameters
    ----------
    expected, error : float
        The response and its standard error, normally distributed.
    value, tolerance : float
        The measured value, and the largest accepted deviation.
    """
    if error <= 0:
        return float(abs(expected - value) <= tolerance)

    def below(limit: float) -> float:
        return 0.5 * (1 + math.erf((limit - expected) / (error * math.sqrt(2))))

    return below(value + tolerance) - below(value - tolerance)


def verdict_by(
    probability: float, confidence: float, *, is_off: bool, in_doubt: bool = False
) -> Verdict:
    """Return the verdict on a response; parameters are those of `status_by`."""
    if is_off and probability <= 1 - confidence:
        return "missed"
    return "met" if probability >= confidence and not in_doubt else "in doubt"


def _verdict_on_curve(
    curve: CurveEvidence, evidence: Evidence, contradicted: tuple[str, ...]
) -> Verdict:
    if curve.has_other_shape:
        return "missed"
    parts = [one for one in evidence.targets if one.curve == curve.name]
    is_contradicted = any(one.name in contradicted for one in parts)
    probability = min(one.probability for one in parts)
    is_off = any(one.is_off for one in parts)
    return verdict_by(probability, evidence.confidence, is_off=is_off, in_doubt=is_contradicted)


def is_contradicted(target: TargetEvidence) -> bool:
    """Return whether the fresh seeds contradict what the other runs predict for a target."""
    if target.fresh is None or target.noise is None:
        return False
    if target.is_deterministic and not target.curve:
        # Its run is the response there, whatever the metamodel expects.
        return abs(target.fresh.mean - target.value) > target.tolerance
    if target.repeated is not None and excludes(target, target.fresh, target.repeated):
        return True
    if target.others is None:
        return False
    return contradicts(target.fresh, target.others, target.noise, target.tolerance)


def excludes(target: TargetEvidence, fresh: Verified, scatter: Scatter) -> bool:
    """Return whether the fresh seeds alone exclude that a target is met.

    Where a metamodel takes a cliff for scatter, its noise is large, and little contradicts it. Runs
    that differ in their seed only know nothing of the cliff.
    """
    # Loaded late: to show a verdict takes no SciPy.
    from scipy.special import stdtrit

    beyond = abs(fresh.mean - target.value) - target.tolerance
    limit = float(stdtrit(scatter.freedom, 1 - VERDICT.excluded / 2))
    error = limit * scatter.standard_deviation / math.sqrt(fresh.runs)
    return beyond > max(error, VERDICT.negligible * target.tolerance)


def contradicts(fresh: Verified, others: Expected, noise: float, tolerance: float) -> bool:
    """Return whether a mean of fresh seeds contradicts what the runs without them predict.

    Parameters
    ----------
    fresh : Verified
        Mean of the fresh seeds.
    others : Expected
        Expected response by the runs without them.
    noise : float
        Standard deviation of an evaluation.
    tolerance : float
        Largest accepted deviation.
    """
    by_chance = VERDICT.contradiction * math.hypot(
        noise / math.sqrt(fresh.runs), others.standard_error
    )
    return abs(fresh.mean - others.mean) > max(by_chance, VERDICT.negligible * tolerance)


def _lacking(evidence: Evidence) -> dict[str, int]:
    """Return how many runs with fresh seeds an answer lacks, by name of the test.

    One of several tests needs fewer where its responses scatter little; a deterministic model
    needs one.
    """
    lacking = {}
    for test, names in evidence.tests.items():
        targets = [one for one in evidence.targets if one.name in names]
        quiet = evidence.has_several_tests and all(map(_is_quiet, targets))
        fewest = evidence.fewest_fresh
        wanted = min(fewest, VERDICT.fewest_of_quiet) if quiet else fewest
        if test in evidence.deterministic:
            wanted = min(fewest, 1)
        made = min((one.fresh_seeds for one in targets), default=0)
        lacking[test] = max(0, wanted - made)
    return lacking


def _is_quiet(target: TargetEvidence) -> bool:
    return target.noise is not None and target.noise <= VERDICT.quiet * target.tolerance


# Reasons ------------------------------------------------------------------------------------


def reasons_for(evidence: Evidence, judgement: Judgement) -> Iterator[Reason]:
    """Yield what the user has to know about a verdict: outlying runs, doubts, and what would help.

    Parameters
    ----------
    evidence : Evidence
        The numbers on which the verdict rests.
    judgement : Judgement
        The verdict.
    """
    if judgement.status == "undecided":
        # What would decide it comes first.
        yield from _in_doubt(evidence, judgement)
    yield from _contradictions(evidence, judgement)
    yield from _not_together(evidence, judgement)
    for curve in evidence.curves:
        if curve.has_other_shape:
            yield OtherShape(curve.name, curve.shape_probability)
    missed = [one.target for one in evidence.out_of_reach]
    for target in evidence.targets:
        if not target.curve:
            # What no parameter set reaches, no number of runs does.
            is_doubted = judgement.status != "calibrated" and target.name not in missed
            yield from _about_runs(target, is_doubted=is_doubted)
    for test in evidence.deterministic:
        yield Deterministic(test)


def _contradictions(evidence: Evidence, judgement: Judgement) -> Iterator[Reason]:
    doubted = [one for one in evidence.targets if one.name in judgement.contradicted]
    for one in doubted:
        if one.fresh is not None and not one.curve:
            fresh = one.fresh
            expected = one.others.mean if one.others else one.expected
            yield Contradicted(
                one.name, one.unit, fresh.mean, fresh.half_width, fresh.runs, expected
            )
    for curve in evidence.curves:
        runs = [one.fresh.runs for one in doubted if one.fresh and one.curve == curve.name]
        if runs and curve.fresh_miss is not None:
            yield CurveContradicted(curve.name, runs[0], curve.fresh_miss)


def _not_together(evidence: Evidence, judgement: Judgement) -> Iterator[Reason]:
    if not evidence.correlated or judgement.status == "calibrated":
        return
    confidence = evidence.confidence
    each_is_met = min(one.probability for one in evidence.targets) >= confidence
    if evidence.probability_all_met < confidence and each_is_met:
        yield NotTogether(tuple(evidence.correlated))


def _about_runs(target: TargetEvidence, *, is_doubted: bool) -> Iterator[Reason]:
    """Yield what is unusual about the runs of a response."""
    if target.outlying is not None:
        yield target.outlying
    noise = target.known_noise
    if noise is None or target.is_deterministic:
        return
    if target.noise_range is not None:
        yield ScatterChanges(target.name, target.unit, *target.noise_range, noise)
    if target.has_two_states:
        yield TwoStates(target.name)
    if is_doubted:
        value = target.value if target.is_relative else None
        scatter = noise * math.sqrt(target.repeats)
        found = useless_scatter(target.name, target.unit, scatter, target.tolerance, value)
        if found is not None:
            yield found


def useless_scatter(
    target: str, unit: str, scatter: float, tolerance: float, value: float | None
) -> UselessScatter | None:
    """Return that single runs scatter by several times the tolerance; None if they do not.

    Parameters are those of `UselessScatter`.
    """
    if not VERDICT.useless_scatter <= scatter / tolerance < math.inf:
        return None
    return UselessScatter(target, unit, scatter, tolerance, value)


def _in_doubt(evidence: Evidence, judgement: Judgement) -> Iterator[Reason]:
    """Yield why neither of both verdicts is established."""
    if evidence.no_record:
        yield from evidence.no_record
        return
    if evidence.repeats_records and any(judgement.lacking.values()):
        yield RecordsRepeated(evidence.fresh_seeds, evidence.fewest_fresh)
        return
    with_all, without = evidence.probability_all_met, evidence.probability_without_outliers
    has_outliers = any(one.outlying is not None for one in evidence.targets)
    if has_outliers and with_all < evidence.confidence <= without:
        yield OutliersDecide(with_all, without)
    elif with_all < evidence.confidence:
        doubtful = [one for one in evidence.targets if one.probability < evidence.confidence]
        if doubtful and all(one.is_deterministic for one in doubtful):
            yield DeterministicInDoubt(_names(doubtful), with_all, evidence.confidence)
        elif at_edge := _on_the_edge(evidence, doubtful):
            yield at_edge
        elif few := [one for one in doubtful if not one.has_trend and one.repeated is None]:
            yield TooFewRuns(_names(few), with_all, evidence.confidence)
        else:
            yield _too_much_scatter(evidence)
    elif sum(judgement.lacking.values()) and not judgement.contradicted:
        failed = evidence.failed if evidence.is_verified else 0
        made, wanted = evidence.fresh_seeds, evidence.fewest_fresh
        if evidence.tests.keys() <= set(evidence.deterministic):
            wanted = min(wanted, 1)
        yield FreshSeedsMissing(made, wanted, failed, evidence.ended if failed else 0)


def _names(targets: Iterable[TargetEvidence]) -> tuple[str, ...]:
    """Return the names of responses and curves, each once."""
    return tuple(dict.fromkeys(one.curve or one.name for one in targets))


def _on_the_edge(evidence: Evidence, doubtful: Sequence[TargetEvidence]) -> OnTheEdge | None:
    """Return that responses are expected at the edge of their tolerance; None if none is."""
    expected = [
        AtEdge(
            one.name,
            abs(one.expected - one.value) / one.tolerance,
            one.standard_error / one.tolerance,
        )
        for one in doubtful
        if not one.curve
    ]
    found = [one for one in expected if is_at_edge(one.deviation, one.standard_error)]
    if not found:
        return None
    is_beyond = max(one.deviation for one in found) > VERDICT.beyond_edge
    return OnTheEdge(evidence.probability_all_met, evidence.confidence, tuple(found), is_beyond)


def _too_much_scatter(evidence: Evidence) -> TooMuchScatter:
    doubtful = [one for one in evidence.targets if one.probability < evidence.confidence]
    noisy = doubtful or list(evidence.targets)
    repeats = max((one.repeats for one in noisy), default=1)
    curves = {one.curve for one in noisy}
    return TooMuchScatter(
        evidence.probability_all_met,
        evidence.confidence,
        evidence.runs_needed * repeats,
        repeats,
        evidence.failed,
        evidence.ended,
        evidence.is_verified,
        tuple(
            NoisyResponse(one.name, one.noise or 0.0, one.tolerance)
            for one in noisy
            if not one.curve
        ),
        tuple(one.noise for one in evidence.curves if one.name in curves and one.noise is not None),
    )
