"""Answer of a search: parameters, predictions, how far they can be trusted; plain data."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from math import isfinite

import numpy as np
from numpy.typing import NDArray

from grainfit.errors import RunFailedError
from grainfit.evaluation import Evaluation
from grainfit.metamodels.curve_reduction import ComponentTarget, Reduction
from grainfit.metamodels.kriging import Kriging
from grainfit.metamodels.metamodels import Metamodels
from grainfit.metamodels.outliers import Outliers
from grainfit.metamodels.two_states import has_two_states
from grainfit.one_line import OneLine
from grainfit.problem import Problem, Target
from grainfit.result import MetamodelQuality
from grainfit.strategies import messages
from grainfit.strategies.run_costs import RunCosts
from grainfit.verdict.options import VERDICT
from grainfit.verdict.out_of_reach import OutOfReach


@dataclass(frozen=True)
class Answer(OneLine):
    """The parameter set that a search has found, and what the metamodels predict for it.

    Parameters
    ----------
    parameters : mapping of str to float
        Values of the free parameters.
    predicted, standard_errors : mapping of str to float
        Expected response and its standard error, by name of the target.
    probability_all_met : float
        Probability, by the metamodels, that all expected responses are within their tolerances.
    probabilities : mapping of str to float
        The same for each target alone, by its name.
    probability_without_outliers : float
        Probability that all targets are met by runs that are no outliers.
    outliers : mapping of str to Outliers
        Outlying runs, by name of the target; without those that have none.
    runs : mapping of str to int
        Number of runs that belong together, by name of the target.
    runs_needed : int
        Estimated number of further runs at these parameters that would make it certain enough, if
        the expected responses are right.
    runs_by_worth : tuple of str
        Tests whose runs at these parameters would make it certain enough soonest, in order; at
        least one, and empty for a single test.
    out_of_reach : tuple of OutOfReach
        Targets that no parameter set within the intervals meets.
    quality : mapping of str to MetamodelQuality
        By name of the target.
    without_trend : tuple of str
        Targets whose runs are too few to tell a trend from chance: what the metamodel takes for
        scatter may be a trend.
    reduction : Reduction, optional
        Reduction of the measured curves, whose components are among the targets; None when there
        are no curves.
    """

    parameters: Mapping[str, float]
    predicted: Mapping[str, float]
    standard_errors: Mapping[str, float]
    probability_all_met: float
    probabilities: Mapping[str, float] = field(default_factory=dict)
    probability_without_outliers: float = 1.0
    outliers: Mapping[str, Outliers] = field(default_factory=dict)
    runs: Mapping[str, int] = field(default_factory=dict)
    runs_needed: int = 0
    runs_by_worth: tuple[str, ...] = ()
    out_of_reach: tuple[OutOfReach, ...] = ()
    quality: Mapping[str, MetamodelQuality] = field(default_factory=dict)
    without_trend: tuple[str, ...] = ()
    reduction: Reduction | None = None

    def reduced(
        self, problem: Problem, evaluations: Sequence[Evaluation]
    ) -> tuple[Problem, list[Evaluation]]:
        """Return a problem and its runs with components, which the answer has, for curves."""
        if self.reduction is None:
            return problem, list(evaluations)
        return self.reduction.problem, self.reduction.evaluations(evaluations)


def make_answer(
    metamodels: Metamodels,
    parameters: Mapping[str, float],
    out_of_reach: Sequence[OutOfReach],
    *,
    spread: bool = True,
    confidence: float = VERDICT.confidence,
    costs: RunCosts | None = None,
) -> Answer:
    """Make an answer from a parameter set and the metamodels' predictions for it.

    ``spread`` is True if the runs are spread by a design, see `Kriging.warnings`; ``confidence`` is
    the demanded probability that every target is met; ``costs`` are those of the runs of several
    tests.
    """
    point: NDArray[np.float64] = metamodels.problem.to_unit(parameters)
    means, variances = metamodels.predict(point)
    names = [target.name for target in metamodels.problem.targets]
    return Answer(
        parameters=dict(parameters),
        predicted=dict(zip(names, means[0].tolist(), strict=True)),
        standard_errors=dict(zip(names, np.sqrt(variances[0]).tolist(), strict=True)),
        probability_all_met=float(metamodels.probability_all_met(point)[0]),
        probabilities=dict(zip(names, metamodels.probabilities(point)[0].tolist(), strict=True)),
        probability_without_outliers=float(metamodels.probability_without_outliers(point)[0]),
        outliers={
            name: found
            for name, found in zip(names, metamodels.outliers, strict=True)
            if found.indices
        },
        runs={name: model.n for name, model in zip(names, metamodels.models, strict=True)},
        runs_needed=metamodels.runs_needed(point, confidence),
        runs_by_worth=_runs_by_worth(metamodels, point, confidence, costs),
        out_of_reach=tuple(out_of_reach),
        quality=_quality_at(metamodels, point, spread),
        without_trend=tuple(
            name
            for name, model in zip(names, metamodels.models, strict=True)
            if not model.tells_scatter
        ),
        reduction=metamodels.reduction if metamodels.reduction.bases else None,
    )


def _runs_by_worth(
    metamodels: Metamodels,
    point: NDArray[np.float64],
    confidence: float,
    costs: RunCosts | None,
) -> tuple[str, ...]:
    problem = metamodels.problem
    if not problem.tests:
        return ()
    costs = costs or RunCosts(problem, ())
    seconds = {s.name: float(costs.seconds(s, point[None])[0]) for s in problem.scopes}
    return metamodels.runs_by_worth(point, confidence, seconds, VERDICT.most_planned)


def metamodel_quality(
    metamodels: Metamodels, *, spread: bool = True
) -> dict[str, MetamodelQuality]:
    """Return how far the metamodels can be trusted, by name of the target.

    ``spread`` is True if the runs are spread by a design, see `Kriging.warnings`.
    """
    parts = metamodels.reduction.parts
    return {
        target.name: replace(_quality(target, model, spread), part=parts.get(target.name, ""))
        for target, model in zip(metamodels.problem.targets, metamodels.models, strict=True)
    }


def _quality_at(
    metamodels: Metamodels, point: NDArray[np.float64], spread: bool
) -> dict[str, MetamodelQuality]:
    """Return the quality of the metamodels, with the noise at a point."""
    found = metamodel_quality(metamodels, spread=spread)
    noise = metamodels.noise_at(point).tolist()
    return {
        name: replace(known, noise=local)
        for (name, known), local in zip(found.items(), noise, strict=True)
    }


def _quality(target: Target, model: Kriging, spread: bool) -> MetamodelQuality:
    check = model.leave_one_out()
    # Small components of curves are mostly scatter, and nobody has to mind.
    is_minor = isinstance(target, ComponentTarget) and not target.is_leading
    return MetamodelQuality(
        q2=float(check.q2) if isfinite(check.q2) else None,
        coverage=float(check.coverage),
        noise=float(model.noise_standard_deviation),
        warnings=() if is_minor else tuple(model.warnings(spread=spread)),
        noise_range=_noise_range(model),
        has_two_states=has_two_states(model.standardised_residuals()),
    )


def _noise_range(model: Kriging) -> tuple[float, float] | None:
    if model.scatter is None:
        return None
    noise = model.noise_standard_deviation * np.sqrt(model.scatter_ratios(model.points))
    return float(noise.min()), float(noise.max())


def answer_from_runs(
    problem: Problem,
    evaluations: Sequence[Evaluation],
    parameters: Mapping[str, float] | None = None,
) -> Answer:
    """Make the answer of a search that has no custom rule for it.

    Parameters
    ----------
    problem : Problem
        Free parameters and targets.
    evaluations : sequence of Evaluation
        All runs; Kriging metamodels are fitted to them.
    parameters : mapping of str to float, optional
        The parameter set to describe; by default the simulated one with the smallest expected
        misfit.

    Raises
    ------
    RunFailedError
        Too few runs have succeeded to fit metamodels.
    """
    metamodels = Metamodels.fit(problem, evaluations)
    names = set(problem.responses)
    tried = [e.proposal.parameters for e in evaluations if names <= e.response_names]
    if not tried:
        raise RunFailedError(messages.NO_ANSWER())
    points = np.array([problem.to_unit(values) for values in tried])
    best = int(np.argmin(metamodels.misfit(points)))
    costs = RunCosts(problem, evaluations)
    return make_answer(metamodels, parameters or tried[best], (), costs=costs)
