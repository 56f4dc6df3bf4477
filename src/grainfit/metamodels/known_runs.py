"""Choose the known runs that metamodels learn from: near the intervals, and not too many.

Runs are chosen by their parameters, never by their responses: those that hit the targets best do
so partly by chance, and would make the scatter look small and the answer right.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping, Sequence

import numpy as np

from grainfit.arrays import Array
from grainfit.errors import GrainfitError
from grainfit.evaluation import Evaluation
from grainfit.metamodels.curve_reduction import Reduction
from grainfit.metamodels.metamodels import Metamodels
from grainfit.metamodels.unit_cube import spread_points
from grainfit.problem import Parameter, Problem

#: Largest number of runs: the effort of metamodels grows with its cube.
MOST_RUNS = 150
#: Distance beyond a bound up to which runs are used, as a share of the interval. `python
#: benchmarks/reuse.py --neighbours` compares values.
LARGEST_DISTANCE = 0.5

_RUNS_OF_FIRST_GUESS = 40
_POINTS_OF_FIRST_GUESS = 1024


def distance_outside(problem: Problem, values: Mapping[str, float]) -> float:
    """Return how far beyond the bounds a parameter set lies, as a share of the interval.

    0 within all intervals, else the distance beyond the bound that it exceeds most. Parameters
    without a value do not count.
    """
    return max(
        (
            _beyond(parameter, values[parameter.name])
            for parameter in problem.parameters
            if parameter.name in values
        ),
        default=0.0,
    )


def _beyond(parameter: Parameter, value: float) -> float:
    if parameter.contains(value):
        return 0.0
    if parameter.scale == "log" and value <= 0.0:
        return math.inf
    position = parameter.to_unit(value)
    return max(-position, position - 1.0, 0.0)


def nearest_runs(
    problem: Problem,
    evaluations: Sequence[Evaluation],
    near: Mapping[str, float] | None = None,
    *,
    seed: int = 1,
    most: int = MOST_RUNS,
) -> list[Evaluation]:
    """Choose a limited number of runs, in their order.

    Those within the intervals come first. If they are too many, half of the chosen ones are the
    nearest to one place, and the others are spread over the rest; if they are too few, those
    nearest to the intervals are added.

    Parameters
    ----------
    problem : Problem
        The problem, with intervals and targets.
    evaluations : sequence of Evaluation
        Runs that have all parameters of the problem.
    near : mapping of str to float, optional
        The place; by default the one that looks best by metamodels of a few runs.
    seed : int
        Decides the search for that place.
    most : int
        Largest number of runs.
    """
    if len(evaluations) <= most:
        return list(evaluations)
    distances = [distance_outside(problem, e.proposal.parameters) for e in evaluations]
    inside = [index for index, distance in enumerate(distances) if distance == 0.0]
    if len(inside) > most:
        chosen = _of_those_inside(problem, [evaluations[i] for i in inside], near, seed, most)
        kept = [inside[index] for index in chosen]
    else:
        kept = np.argsort(distances, kind="stable")[:most].tolist()
    return [evaluations[index] for index in sorted(kept)]


def _of_those_inside(
    problem: Problem,
    evaluations: list[Evaluation],
    near: Mapping[str, float] | None,
    seed: int,
    most: int,
) -> list[int]:
    points = np.array([problem.to_unit(e.proposal.parameters) for e in evaluations])
    centre = problem.to_unit(near) if near else _first_guess(problem, evaluations, seed)
    return nearest_and_spread(((points - centre) ** 2).sum(axis=1), most)


def nearest_and_spread(distances: Array, most: int) -> list[int]:
    """Choose places of a limited number: half have the least distances, the others are spread.

    Parameters
    ----------
    distances : ndarray, shape (n,)
        More than ``most``.
    most : int
        How many are chosen.
    """
    ranked = np.argsort(distances, kind="stable")
    nearest, others = np.split(ranked, [most // 2])
    left = most - len(nearest)
    return [*nearest.tolist(), *others[np.arange(left) * len(others) // left].tolist()]


def _first_guess(problem: Problem, evaluations: list[Evaluation], seed: int) -> Array:
    """Best point by metamodels of a few runs; the middle of the cube without metamodels."""
    few = evaluations[:: -(-len(evaluations) // _RUNS_OF_FIRST_GUESS)]
    metamodels, _ = fit_where_possible(problem, few)
    if metamodels is None:
        return np.full(problem.dimension, 0.5)
    random = np.random.default_rng(seed)
    points = spread_points(_POINTS_OF_FIRST_GUESS, problem.dimension, random)
    return np.asarray(points[metamodels.misfit(points).argmin()])


def fit_where_possible(
    problem: Problem, evaluations: Sequence[Evaluation]
) -> tuple[Metamodels | None, dict[str, str]]:
    """Fit metamodels of the responses that enough runs yielded.

    Returns
    -------
    metamodels : Metamodels or None
        Their problem may have fewer targets; None when there is none.
    missing : dict of str to str
        The other targets by name, and why they have no metamodel.
    """
    missing: dict[str, str] = {}
    fits: dict[str, Metamodels] = {}
    for name in problem.responses:
        try:
            fits[name] = Metamodels.fit(_only(problem, [name]), evaluations)
        except GrainfitError as error:
            missing[name] = str(error)
    if not fits:
        return None, missing
    known = _only(problem, fits)
    bases = [basis for fitted in fits.values() for basis in fitted.reduction.bases]
    reduction = Reduction(known, tuple(bases))
    models = [model for fitted in fits.values() for model in fitted.models]
    outliers = [found for fitted in fits.values() for found in fitted.outliers]
    return Metamodels(reduction.problem, models, outliers, reduction), missing


def _only(problem: Problem, names: Collection[str]) -> Problem:
    """Return the problem with some of its responses."""
    return problem.with_targets(
        [target for target in problem.targets if target.name in names],
        [curve for curve in problem.curves if curve.name in names],
    )
