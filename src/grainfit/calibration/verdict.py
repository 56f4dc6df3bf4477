"""Verdict on an answer, by the probability that it meets every target."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from grainfit.analysis.scatter import useless_scatter
from grainfit.calibration.verification import (
    Contradiction,
    FreshRuns,
    contradictions,
    lacking_runs,
)
from grainfit.formatting import (
    counted,
    in_a_row,
    number,
    on_curve,
    plain_probability,
    unit_for_people,
    with_unit,
)
from grainfit.metamodels.curve_reduction import ComponentTarget, CurveBasis
from grainfit.metamodels.outliers import Outliers
from grainfit.problem import Problem, Target
from grainfit.result import MetamodelQuality, Status
from grainfit.strategies.answer import Answer
from grainfit.strategies.out_of_reach import miss_of

#: Most seeds of outlying runs in one sentence.
_MOST_SHOWN = 5


@dataclass(frozen=True)
class Outcome:
    """An answer, the fresh seeds at it, and the verdict on it.

    Parameters
    ----------
    answer : Answer
        The answer, with what all runs lead to expect.
    status : str
        The verdict, one of `grainfit.result.Status`.
    fresh : FreshRuns
        Runs that verify it.
    contradictions : sequence of Contradiction
        Targets for which they contradict all runs together.
    confidence : float
        Probability from which a target counts as met.
    fewest_fresh : int
        Number of fresh seeds without which no answer is calibrated.
    lacking : int
        Runs with fresh seeds that are missing from that number, of all tests.
    repeats : mapping of str to int
        Runs with different seeds whose mean is one evaluation, by name of the test.
    """

    answer: Answer
    status: Status
    fresh: FreshRuns
    contradictions: Sequence[Contradiction]
    confidence: float
    fewest_fresh: int
    lacking: int
    repeats: Mapping[str, int] = field(default_factory=dict)

    def runs_of(self, problem: Problem, target: Target) -> int:
        """Return the runs of one evaluation of the test of a target."""
        if not self.repeats:
            return 1
        test = problem.scope_of(target.name).name
        # Without scopes, all tests are evaluated together.
        return self.repeats.get(test, max(self.repeats.values()))


def judge(
    problem: Problem,
    answer: Answer,
    fresh: FreshRuns,
    confidence: float,
    fewest_fresh: int,
    repeats: Mapping[str, int] | None = None,
) -> Outcome:
    """Judge an answer.

    It is calibrated when every expected response is within its tolerance with the demanded
    probability, by all runs, and enough fresh seeds at it do not contradict them.

    Parameters
    ----------
    problem : Problem
        Parameters and targets.
    answer : Answer
        The answer, described by all runs.
    fresh : FreshRuns
        Runs with fresh seeds at or very near the answer.
    confidence : float
        Demanded probability.
    fewest_fresh : int
        Number of fresh seeds without which no answer is calibrated.
    repeats : mapping of str to int, optional
        Runs with different seeds whose mean is one evaluation, by name of the test.
    """
    contradicted = contradictions(problem, fresh.verified(), answer)
    lacking = sum(lacking_runs(problem, answer, fresh, fewest_fresh).values())
    return Outcome(
        answer,
        _status(answer, confidence, bool(contradicted) or lacking > 0),
        fresh,
        contradicted,
        confidence,
        fewest_fresh,
        lacking,
        repeats or {},
    )


def _status(answer: Answer, confidence: float, in_doubt: bool) -> Status:
    if answer.out_of_reach:
        return "unreachable"
    if any(basis.has_other_shape for basis in _bases(answer)):
        return "out_of_tolerance"
    both = (answer.probability_all_met, answer.probability_without_outliers)
    if min(both) >= confidence and not in_doubt:
        return "calibrated"
    return "out_of_tolerance" if max(both) <= 1 - confidence else "undecided"


def _bases(answer: Answer) -> Sequence[CurveBasis]:
    return answer.reduction.bases if answer.reduction else ()


# Words --------------------------------------------------------------------------------------


def reasons(problem: Problem, outcome: Outcome) -> Iterator[str]:
    """Say what the user has to know about a verdict: outlying runs, doubts, and what would help.

    Parameters
    ----------
    problem : Problem
        Parameters and targets.
    outcome : Outcome
        The verdict.
    """
    yield from _about_contradictions(outcome)
    answer = outcome.answer
    if apart := _not_together(problem, outcome):
        yield apart
    yield from (_about_shape(basis) for basis in _bases(answer) if basis.has_other_shape)
    for target in problem.targets:
        if isinstance(target, ComponentTarget):
            continue
        if found := answer.outliers.get(target.name):
            yield _about_outliers(target, found)
        if quality := answer.quality.get(target.name):
            yield from _about_scatter(target, quality)
            yield from _about_useless(problem, outcome, target, quality)
    if outcome.status != "undecided":
        return
    with_all, without = answer.probability_all_met, answer.probability_without_outliers
    if answer.outliers and abs(with_all - without) > 1 - outcome.confidence:
        yield (
            f"Undecided because of outlying runs: with them, every target is met with a "
            f"probability of {plain_probability(with_all)}; if they did not count, this answer "
            f"would be right with {plain_probability(without)}. Look at their pictures: if such "
            "runs also happen in the laboratory, make the test wider or repeat it more often; if "
            'not, ask for the typical value with statistic = "median".'
        )
    elif with_all < outcome.confidence:
        yield _about_noise(problem, outcome)
    elif outcome.lacking and not outcome.contradictions:
        failed, ended = outcome.fresh.failures
        failing = bool(failed and outcome.fresh.evaluations)
        advice = f"{_of(failed, ended)} there failed" if failing else "allow more runs"
        yield (
            f"Undecided because only {outcome.fresh.count} of {outcome.fewest_fresh} runs with "
            f"fresh seeds at the answer {'succeeded' if failing else 'could be made'}: {advice}."
        )


def _about_contradictions(outcome: Outcome) -> Iterator[str]:
    of_curves = {name for basis in _bases(outcome.answer) for name in basis.names}
    found = {one.target.name: one for one in outcome.contradictions}
    yield from (str(one) for name, one in found.items() if name not in of_curves)
    for basis in _bases(outcome.answer):
        if not found.keys().isdisjoint(basis.names):
            yield _about_contradicted(basis, outcome)


def _about_contradicted(basis: CurveBasis, outcome: Outcome) -> str:
    of_all = outcome.fresh.verified()
    verified = [of_all[name] for name in basis.names]
    scores = (
        [outcome.answer.predicted[name] for name in basis.names],
        [response.mean for response in verified],
    )
    nothing = np.zeros(len(verified))
    wanted, found = (basis.expected(np.array(along), nothing)[0] for along in scores)
    miss = miss_of(basis.target, wanted, found)
    return (
        f"{basis.target.name} is in doubt: from the curve that all runs together lead to expect, "
        f"the mean of the {verified[0].runs} fresh seeds at the answer {miss}. The metamodels miss "
        "something there: more runs would tell."
    )


def _not_together(problem: Problem, outcome: Outcome) -> str:
    """Say that correlated targets are met one by one, but not together; "" otherwise."""
    answer = outcome.answer
    each = answer.probabilities.values()
    if not problem.correlations or outcome.status == "calibrated":
        return ""
    if answer.probability_all_met >= outcome.confidence or min(each) < outcome.confidence:
        return ""
    names = dict.fromkeys(name for pair in problem.correlations for name in pair[:2])
    return (
        f"{in_a_row(names)} are each within their tolerances, but deviate as their correlation "
        "makes unlikely. Look for an error that they do not share, or lower the coefficient."
    )


def _about_shape(basis: CurveBasis) -> str:
    chance = plain_probability(basis.shape_probability)
    return (
        f"{basis.target.name}: no simulated curve has the shape of the measured one. Errors as "
        f"they are stated leave such a rest with a probability of {chance}. Look at both curves: "
        "correct the data, leave out a part that the test does not show, or state the uncertainty "
        "that the model itself has."
    )


def _about_outliers(target: Target, found: Outliers) -> str:
    size = max(found.residuals.tolist(), key=abs)
    away = with_unit(number(abs(size), 3), unit_for_people(target.unit))
    seeds = ", ".join(map(str, found.seeds[:_MOST_SHOWN]))
    more = ", ..." if len(found.seeds) > _MOST_SHOWN else ""
    return (
        f"{target.name}: {counted(len(found.indices), 'run')} of {found.runs} "
        f"{'lies' if len(found.indices) == 1 else 'lie'} far from the others (seed {seeds}{more}), "
        f"up to {away} {'above' if size > 0 else 'below'} what they lead to expect."
    )


def _about_scatter(target: Target, quality: MetamodelQuality) -> Iterator[str]:
    if quality.noise_range is not None:
        low, high = (number(noise, 2) for noise in quality.noise_range)
        yield (
            f"{target.name}: the scatter from run to run changes over the intervals, from {low} to "
            f"{with_unit(high, unit_for_people(target.unit))}; at the answer it is "
            f"{number(quality.noise, 2)}. All intervals take that into account."
        )
    if quality.has_two_states:
        yield (
            f"{target.name}: the runs scatter about two values rather than one. The mean over "
            "seeds is expected, but no single run looks like it: look at the pictures."
        )


def _about_useless(
    problem: Problem, outcome: Outcome, target: Target, quality: MetamodelQuality
) -> Iterator[str]:
    """Say that a response tells nothing at its tolerance, unless the answer is certain anyway."""
    if outcome.status == "calibrated" or isinstance(target, ComponentTarget):
        return
    runs = outcome.runs_of(problem, target)
    if words := useless_scatter(target, quality.noise * math.sqrt(runs)):
        yield words


def _about_noise(problem: Problem, outcome: Outcome) -> str:
    answer = outcome.answer
    noisy = [
        target
        for target in problem.targets
        if answer.probabilities[target.name] < outcome.confidence
    ] or list(problem.targets)
    runs = max((outcome.runs_of(problem, target) for target in noisy), default=1)
    one = "one run" if runs == 1 else f"one mean of {runs} runs"
    names = {target.name for target in noisy}
    curves = [basis for basis in _bases(answer) if not names.isdisjoint(basis.names)]
    numbers = [target for target in noisy if not isinstance(target, ComponentTarget)]
    scatter = ", ".join(
        [
            *(
                f"{number(answer.quality[target.name].noise, 2)} in {target.name} "
                f"(tolerance {number(target.tolerance, 2)})"
                for target in numbers
            ),
            *(_scatter_of_curve(basis, answer) for basis in curves),
        ]
    )
    wider = "A wider tolerance" if numbers else "A larger uncertainty of the measured points"
    return (
        f"Every expected response is within its tolerance with a probability of "
        f"{plain_probability(answer.probability_all_met)}, and "
        f"{plain_probability(outcome.confidence)} is asked for. "
        f"{_runs_to_take(outcome, answer.runs_needed * runs)}: "
        f"{one} scatters by {scatter}. {wider}, a larger sample in the test, or a response that "
        "scatters less would help more."
    )


def _scatter_of_curve(basis: CurveBasis, answer: Answer) -> str:
    noises = np.array([answer.quality[name].noise for name in basis.names])
    target = basis.target
    _, spread = basis.expected(np.zeros(len(noises)), noises**2)
    ratios = spread / target.standard_uncertainties
    worst = int(ratios.argmax())
    place = on_curve(target.coordinates[worst], target.coordinate, target.coordinate_unit)
    return (
        f"{number(float(np.sqrt((ratios**2).mean())), 2)} σ of the measured "
        f"points in {target.name} (root mean square, most at {place})"
    )


def _runs_to_take(outcome: Outcome, successful: int) -> str:
    """Say how many runs would give a number of successful ones; failing runs count, too."""
    failed, ended = outcome.fresh.failures
    where = "there" if outcome.fresh.evaluations else "in the search"
    if failed and failed == ended:
        words = f"{counted(successful, 'more run')} at the answer would have to succeed"
        return f"About {words}, but {_of(failed, ended)} failed {where}"
    if not failed:
        return f"It would take about {counted(successful, 'more run')} at the answer"
    runs = math.ceil(successful * ended / (ended - failed))
    return (
        f"It would take about {counted(runs, 'more run')} at the answer, as {_of(failed, ended)} "
        f"failed {where}"
    )


def _of(failed: int, ended: int) -> str:
    return f"{failed} of {counted(ended, 'run')}"
