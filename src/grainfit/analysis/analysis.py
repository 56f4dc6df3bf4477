"""Run all analyses of a calibration's runs at once."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray
from threadpoolctl import threadpool_limits

from grainfit.analysis.identifiability import Identifiability, assess_identifiability
from grainfit.analysis.pareto import ParetoFront, pareto_front
from grainfit.analysis.posterior import Posterior, sample_posterior
from grainfit.analysis.sensitivity import Sensitivity, estimate_sensitivity
from grainfit.campaign.reuse import MOST_RUNS
from grainfit.errors import GrainfitError
from grainfit.evaluation import Evaluation
from grainfit.metamodels.kriging import Kriging
from grainfit.metamodels.metamodels import Metamodels
from grainfit.metamodels.unit_cube import spread_points
from grainfit.problem import Problem
from grainfit.result import MetamodelQuality
from grainfit.strategies.answer import metamodel_quality

Array = NDArray[np.float64]

_RUNS_OF_FIRST_GUESS = 40
_POINTS_OF_FIRST_GUESS = 1024
#: Squared numbers of runs, times sets of hyperparameters, summed over the responses.
_LARGEST_EFFORT = 400_000
#: Fixed cost of a prediction, in the same unit.
_EFFORT_OF_ASKING = 5_000
_FEWEST_COMPONENTS = 2


@dataclass(frozen=True)
class Analysis:
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
    identifiability: Identifiability | None = None
    pareto: ParetoFront | None = None
    notes: tuple[str, ...] = ()


def analyse(
    problem: Problem,
    evaluations: Sequence[Evaluation],
    *,
    seed: int = 1,
    answer: Mapping[str, float] | None = None,
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
        The calibrated values; if there are many runs, those near them are preferred.

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
    notes: list[str] = []
    with threadpool_limits(limits=1, user_api="blas"):
        known = _usable(problem, evaluations, notes)
        chosen = _bearable(problem, known, answer, seed, notes)
        fitted = _fit(problem, chosen, notes)
        if fitted is None:
            return Analysis(notes=tuple(notes))
        metamodels = _reduced(fitted)
        posterior = sample_posterior(metamodels, seed=seed)
        if not posterior.converged:
            notes.append(posterior.convergence)
        return Analysis(
            metamodels=metamodels,
            quality=metamodel_quality(fitted, spread=_is_spread(chosen)),
            posterior=posterior,
            sensitivity=estimate_sensitivity(metamodels, seed=seed),
            identifiability=assess_identifiability(posterior, metamodels.problem),
            pareto=pareto_front(metamodels, seed=seed),
            notes=tuple(notes),
        )


def _usable(
    problem: Problem, evaluations: Sequence[Evaluation], notes: list[str]
) -> list[Evaluation]:
    """Runs within the intervals that yielded a response."""
    names = [target.name for target in problem.targets]
    telling = [e for e in evaluations if any(name in e.responses for name in names)]
    inside = [e for e in telling if _is_inside(problem, e.proposal.parameters)]
    if not telling:
        notes.append(
            f"None of {len(evaluations)} runs yielded a response: nothing can be said."
            if evaluations
            else "There is no run yet that yielded a response: nothing can be said."
        )
    elif len(inside) < len(telling):
        notes.append(
            f"{len(telling) - len(inside)} of {len(telling)} runs are outside the intervals and "
            "are left out."
        )
    return inside


def _is_inside(problem: Problem, values: Mapping[str, float]) -> bool:
    return all(
        parameter.name in values and parameter.contains(values[parameter.name])
        for parameter in problem.parameters
    )


# Metamodels ---------------------------------------------------------------------------------


def _bearable(
    problem: Problem,
    evaluations: list[Evaluation],
    answer: Mapping[str, float] | None,
    seed: int,
    notes: list[str],
) -> list[Evaluation]:
    """Return the runs nearest to the answer, and as many spread over the others.

    They are chosen by parameters, never by responses: runs that hit the targets best do so partly
    by chance, and would make the noise look small and the answer right.
    """
    if len(evaluations) <= MOST_RUNS:
        return evaluations
    points = np.array([problem.to_unit(e.proposal.parameters) for e in evaluations])
    if answer and _is_inside(problem, answer):
        centre, words = problem.to_unit(answer), "the answer"
    else:
        centre, words = _first_guess(problem, evaluations, seed), "what looks like the answer"
    ranked = np.argsort(((points - centre) ** 2).sum(axis=1), kind="stable")
    nearest, others = np.split(ranked, [MOST_RUNS // 2])
    left = MOST_RUNS - len(nearest)
    chosen = np.append(nearest, others[np.arange(left) * len(others) // left])
    notes.append(
        f"The analysis rests on {MOST_RUNS} of {len(evaluations)} runs, because its effort grows "
        f"with the cube of their number: the {len(nearest)} nearest to {words} and {left} spread "
        "over the others."
    )
    return [evaluations[index] for index in np.sort(chosen)]


def _first_guess(problem: Problem, evaluations: list[Evaluation], seed: int) -> Array:
    """Best point by metamodels of a few runs; the middle of the cube without metamodels."""
    few = evaluations[:: -(-len(evaluations) // _RUNS_OF_FIRST_GUESS)]
    metamodels = _fit(problem, few, [])
    if metamodels is None:
        return np.full(problem.dimension, 0.5)
    random = np.random.default_rng(seed)
    points = spread_points(_POINTS_OF_FIRST_GUESS, problem.dimension, random)
    return np.asarray(points[metamodels.misfit(points).argmin()])


def _fit(problem: Problem, evaluations: list[Evaluation], notes: list[str]) -> Metamodels | None:
    """Metamodels of the responses for which they can be fitted."""
    targets, models, outliers = [], [], []
    for target in problem.targets:
        alone = replace(problem, targets=(target,))
        try:
            fitted = Metamodels.fit(alone, evaluations)
        except GrainfitError as error:
            if evaluations:
                notes.append(f"There is no metamodel of {target.name}: {error}")
        else:
            targets.append(target)
            models += fitted.models
            outliers += fitted.outliers
    if not targets:
        return None
    return Metamodels(replace(problem, targets=tuple(targets)), models, outliers)


def _reduced(metamodels: Metamodels) -> Metamodels:
    """Metamodels with only the most probable sets of hyperparameters, to limit the effort."""
    effort = sum(model.n**2 + _EFFORT_OF_ASKING for model in metamodels.models)
    components = max(_LARGEST_EFFORT // effort, _FEWEST_COMPONENTS)
    models: list[Kriging] = [model.reduced(components) for model in metamodels.models]
    return Metamodels(metamodels.problem, models, metamodels.outliers)


def _is_spread(evaluations: Sequence[Evaluation]) -> bool:
    return all(evaluation.proposal.stage == "design" for evaluation in evaluations)
