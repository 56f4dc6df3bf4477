"""Run all analyses of a calibration's runs at once."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

from grainfit.analysis import messages
from grainfit.analysis.identifiability import Identifiability, assess_identifiability
from grainfit.analysis.intervals import parameter_intervals
from grainfit.analysis.pareto import ParetoFront, pareto_front
from grainfit.analysis.posterior import Posterior, sample_posterior
from grainfit.analysis.sensitivity import Sensitivity, estimate_sensitivity
from grainfit.evaluation import Evaluation
from grainfit.metamodels.blow_ups import without_blow_ups
from grainfit.metamodels.known_runs import (
    LARGEST_DISTANCE,
    MOST_RUNS,
    distance_outside,
    fit_where_possible,
    nearest_runs,
)
from grainfit.metamodels.metamodels import Metamodels
from grainfit.one_line import OneLine
from grainfit.one_thread import one_thread
from grainfit.problem import Problem
from grainfit.result import MetamodelQuality, ParameterInterval
from grainfit.strategies.answer import metamodel_quality
from grainfit.strategies.feasibility import FeasibilityModel


@dataclass(frozen=True)
class Analysis(OneLine):
    """Results of all analyses of a calibration's runs.

    Attributes
    ----------
    metamodels : Metamodels or None
        Metamodels of the responses that enough runs yielded; their problem may have fewer
        targets. None when there is none.
    quality : mapping of str to MetamodelQuality
        Quality of each metamodel, by name of the target.
    posterior : Posterior or None
        Parameter sets that agree with the measurements.
    sensitivity : Sensitivity or None
        Sensitivity of each response to each parameter.
    intervals : mapping of str to ParameterInterval
        95 % interval of each parameter, which holds the answer; empty without a posterior.
    identifiability : Identifiability or None
        Parameters that the tests determine, and those that they leave open.
    pareto : ParetoFront or None
        Trade-off between time step and misfit.
    notes : tuple of str
        Notes for the reader, such as why a part is missing.
    """

    metamodels: Metamodels | None = None
    quality: Mapping[str, MetamodelQuality] = field(default_factory=dict)
    posterior: Posterior | None = None
    sensitivity: Sensitivity | None = None
    intervals: Mapping[str, ParameterInterval] = field(default_factory=dict)
    identifiability: Identifiability | None = None
    pareto: ParetoFront | None = None
    notes: tuple[str, ...] = ()


def analyse(
    problem: Problem,
    evaluations: Sequence[Evaluation],
    *,
    seed: int = 1,
    answer: Mapping[str, float] | None = None,
    biases: Mapping[str, str] | None = None,
) -> Analysis:
    """Analyse the runs of a calibration; too few runs are not an error.

    Parameters
    ----------
    problem : Problem
        Parameters and targets.
    evaluations : sequence of Evaluation
        All known runs, failed ones included.
    seed : int
        The same seed gives the same analysis.
    answer : mapping of str to float, optional
        The calibrated values, which the intervals hold; if there are many runs, those near them
        are preferred.
    biases : mapping of str to str, optional
        Reasons why parameters are biased, by name; see `soft_particles.known_biases`.

    Returns
    -------
    Analysis

    Examples
    --------
    >>> from grainfit import Parameter, Problem, Target
    >>> problem = Problem([Parameter("friction", 0.1, 0.9)], [Target("angle", 30.0)])
    >>> analyse(problem, []).notes
    ('There is no run yet that yielded a response: nothing can be said.',)
    """
    with one_thread():
        found = analyse_parameters(problem, evaluations, seed=seed, answer=answer, biases=biases)
        if found.metamodels is None or found.posterior is None:
            return found
        return replace(
            found,
            sensitivity=estimate_sensitivity(found.metamodels, seed=seed),
            identifiability=assess_identifiability(found.posterior, problem, answer, biases),
            pareto=pareto_front(found.metamodels, seed=seed),
        )


def analyse_parameters(
    problem: Problem,
    evaluations: Sequence[Evaluation],
    *,
    seed: int = 1,
    answer: Mapping[str, float] | None = None,
    biases: Mapping[str, str] | None = None,
) -> Analysis:
    """Return the part of `analyse` that the result of a calibration has: the 95 % intervals.

    Parameters
    ----------
    problem, evaluations, seed, answer, biases
        As for `analyse`.

    Returns
    -------
    Analysis
        With metamodels, their quality, posterior and intervals.
    """
    with one_thread():
        fitted, posterior = _fitted_and_sampled(problem, evaluations, seed, answer)
        if fitted.whole is None or fitted.reduced is None or posterior is None:
            return Analysis(notes=fitted.notes)
        return Analysis(
            metamodels=fitted.reduced,
            quality=metamodel_quality(fitted.whole, spread=_is_spread(fitted.runs)),
            posterior=posterior,
            intervals=parameter_intervals(posterior, problem, answer, biases),
            notes=(*fitted.notes, *(() if posterior.converged else (posterior.convergence,))),
        )


#: Last call of `_fitted_and_sampled`: the report of a run asks again for what the result has.
_last: tuple[Any, tuple[Fitted, Posterior | None]] | None = None


def _fitted_and_sampled(
    problem: Problem,
    evaluations: Sequence[Evaluation],
    seed: int,
    answer: Mapping[str, float] | None,
) -> tuple[Fitted, Posterior | None]:
    global _last
    # All but wall times, and the share of runs that were known.
    told = [(e.proposal, e.responses, e.curves, e.failures, e.made_at) for e in evaluations]
    asked = (problem, told, seed, answer)
    last = _last
    if last is None or last[0] != asked:
        fitted = fit_runs(problem, evaluations, seed=seed, answer=answer)
        reduced = fitted.reduced
        posterior = None
        if reduced is not None:
            succeeds = _feasibility(problem, evaluations).is_likely
            posterior = sample_posterior(reduced, succeeds, seed=seed)
        last = _last = asked, (fitted, posterior)
    return last[1]


def _feasibility(problem: Problem, evaluations: Sequence[Evaluation]) -> FeasibilityModel:
    placed = [e for e in evaluations if _has_all(problem, e.proposal.parameters)]
    return FeasibilityModel(problem, without_blow_ups(problem, placed))


def _is_spread(evaluations: Sequence[Evaluation]) -> bool:
    return all(evaluation.proposal.stage == "design" for evaluation in evaluations)


@dataclass(frozen=True)
class Fitted:
    """Metamodels of a calibration's runs.

    Attributes
    ----------
    whole, reduced : Metamodels or None
        Metamodels with all sets of hyperparameters, and with only the most probable ones, to
        limit the effort; None when there are too few runs.
    runs : tuple of Evaluation
        The runs that they were fitted to.
    notes : tuple of str
        Runs and responses that are left out, and why.
    """

    whole: Metamodels | None
    reduced: Metamodels | None
    runs: tuple[Evaluation, ...]
    notes: tuple[str, ...]


def fit_runs(
    problem: Problem,
    evaluations: Sequence[Evaluation],
    *,
    seed: int,
    answer: Mapping[str, float] | None,
) -> Fitted:
    """Fit metamodels to the runs of a calibration; their order does not matter.

    Parameters
    ----------
    problem : Problem
        Parameters and targets.
    evaluations : sequence of Evaluation
        All known runs, failed ones included.
    seed : int
        Decides the choice among too many runs.
    answer : mapping of str to float or None
        The calibrated values; of too many runs, those near them are preferred.
    """
    notes: list[str] = []
    usable = _usable(problem, sorted(evaluations, key=_order), notes)
    chosen = _chosen(problem, usable, answer, seed, notes)
    whole, missing = fit_where_possible(problem, chosen)
    if chosen:
        notes += [messages.NO_METAMODEL(name=name, why=why) for name, why in missing.items()]
    return Fitted(whole, whole.reduced() if whole else None, tuple(chosen), tuple(notes))


def _order(evaluation: Evaluation) -> tuple[list[tuple[str, float]], int]:
    return sorted(evaluation.proposal.parameters.items()), evaluation.proposal.seed


def _usable(
    problem: Problem, evaluations: Sequence[Evaluation], notes: list[str]
) -> list[Evaluation]:
    """Runs within the intervals, or not far beyond them, that yielded a response."""
    telling = [e for e in evaluations if not e.response_names.isdisjoint(problem.responses)]
    near = [e for e in telling if _is_near(problem, e.proposal.parameters)]
    if not telling:
        none = messages.NO_RESPONSES(runs=len(evaluations)) if evaluations else messages.NO_RUNS()
        notes.append(none)
    elif len(near) < len(telling):
        left_out, runs = len(telling) - len(near), len(telling)
        share = LARGEST_DISTANCE
        notes.append(messages.RUNS_FAR_OUTSIDE(left_out=left_out, runs=runs, share=share))
    return near


def _is_near(problem: Problem, values: Mapping[str, float]) -> bool:
    return _has_all(problem, values) and distance_outside(problem, values) <= LARGEST_DISTANCE


def _has_all(problem: Problem, values: Mapping[str, float]) -> bool:
    return all(parameter.name in values for parameter in problem.parameters)


def _chosen(
    problem: Problem,
    evaluations: list[Evaluation],
    answer: Mapping[str, float] | None,
    seed: int,
    notes: list[str],
) -> list[Evaluation]:
    """Choose the runs for the metamodels, and say so if some are left out."""
    holds = (
        answer is not None
        and _has_all(problem, answer)
        and distance_outside(problem, answer) == 0.0
    )
    chosen = nearest_runs(problem, evaluations, answer if holds else None, seed=seed)
    if len(chosen) < len(evaluations):
        inside = sum(distance_outside(problem, e.proposal.parameters) == 0.0 for e in evaluations)
        runs, which = len(evaluations), _which(inside, holds)
        notes.append(messages.RUNS_CHOSEN(chosen=MOST_RUNS, runs=runs, which=which))
    return chosen


def _which(inside: int, answer_is_known: bool) -> str:
    if inside <= MOST_RUNS:
        return f"the {inside} within the intervals and those nearest to them"
    centre = "the answer" if answer_is_known else "what looks like the answer"
    half = MOST_RUNS // 2
    return f"the {half} nearest to {centre} and {MOST_RUNS - half} spread over the others"
