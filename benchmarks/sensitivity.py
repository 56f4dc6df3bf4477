"""Sobol' indices of few runs against the true ones: do their intervals hold them?

Of functions with known indices, with scatter: the share of true indices in the 95 % intervals, with
that of surfaces drawn from the metamodel alone; the largest error of a total index; and how many
metamodels are refused, of those with a Q2 below and above 0.5.

Usage: python benchmarks/sensitivity.py [--repeats N] [--workers N]
"""

from __future__ import annotations

import argparse
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.stats import qmc

from grainfit.analysis import sensitivity as module
from grainfit.analysis.response_surfaces import draw_surfaces
from grainfit.metamodels.kriging import POOR_Q2, Kriging
from grainfit.metamodels.metamodels import Metamodels
from grainfit.problem import Parameter, Problem, Target

Array = NDArray[np.float64]
DIMENSION, POINTS = 3, 512


@dataclass(frozen=True)
class Function:
    """A function of the unit cube with its first and total Sobol' indices."""

    values: Callable[[Array], Array]
    first: Array
    total: Array


def _ishigami(x: Array) -> Array:
    first, second, third = (np.pi * (2.0 * x - 1.0)).T
    return np.asarray(
        10.0 + np.sin(first) + 7.0 * np.sin(second) ** 2 + 0.1 * third**4 * np.sin(first)
    )


_WEIGHTS = np.array([0.0, 1.0, 4.5])


def _g(x: Array) -> Array:
    return np.asarray(np.prod((np.abs(4.0 * x - 2.0) + _WEIGHTS) / (1.0 + _WEIGHTS), axis=1))


_ALONE = 1.0 / (3.0 * (1.0 + _WEIGHTS) ** 2)
_ALL = np.prod(1.0 + _ALONE)
_LINEAR = np.array([9.0, 4.0, 1.0]) / 14.0
FUNCTIONS = {
    "linear": Function(lambda x: 10.0 + x @ np.array([3.0, 2.0, 1.0]), _LINEAR, _LINEAR),
    "Ishigami": Function(
        _ishigami, np.array([0.3139, 0.4424, 0.0]), np.array([0.5576, 0.4424, 0.2437])
    ),
    "Sobol' g": Function(_g, _ALONE / (_ALL - 1.0), _ALONE * _ALL / (1.0 + _ALONE) / (_ALL - 1.0)),
}
#: Function, number of runs, and standard deviation of their scatter.
CASES = (
    ("linear", 8, 0.5),
    ("linear", 20, 1.0),
    ("linear", 40, 0.5),
    ("Ishigami", 20, 0.0),
    ("Ishigami", 40, 0.0),
    ("Ishigami", 80, 0.0),
    ("Ishigami", 80, 1.0),
    ("Sobol' g", 20, 0.0),
    ("Sobol' g", 40, 0.3),
)


@dataclass(frozen=True)
class Outcome:
    """Shares of true indices that the intervals hold, the largest error, Q2, and the verdict."""

    held: float
    held_by_draws: float
    error: float
    q2: float
    refused: bool


def outcome(case: tuple[str, int, float], seed: int) -> Outcome:
    """Fit a metamodel to a design, and compare its indices with the true ones."""
    name, runs, scatter = case
    function = FUNCTIONS[name]
    random = np.random.default_rng(seed)
    points = qmc.LatinHypercube(DIMENSION, rng=random).random(runs)
    model = Kriging.fit(points, function.values(points) + random.normal(0.0, scatter, runs))
    parameters = [Parameter(f"x{number}", 0.0, 1.0) for number in range(DIMENSION)]
    metamodels = Metamodels(Problem(parameters, [Target("y", 10.0)]), [model])
    found = module.estimate_sensitivity(metamodels, seed=seed, points=POINTS)
    low = np.array([found.first_low[0], found.total_low[0]])
    high = np.array([found.first_high[0], found.total_high[0]])
    truth = np.array([function.first, function.total])
    drawn_low, drawn_high = _by_draws(model, seed)
    return Outcome(
        float(np.mean((low <= truth) & (truth <= high))),
        float(np.mean((drawn_low <= truth) & (truth <= drawn_high))),
        float(np.abs(found.total[0] - function.total).max()),
        model.leave_one_out().q2,
        not found.is_known(0),
    )


def _by_draws(model: Kriging, seed: int) -> tuple[Array, Array]:
    """Ends of the intervals from surfaces drawn from the metamodel alone."""
    random = np.random.default_rng(seed)
    asked = module._points(DIMENSION, POINTS, random)
    drawn = [
        module._of_surface(surface, DIMENSION, random.integers(POINTS, size=POINTS))[0]
        for surface in draw_surfaces(model, asked, 200, random)
    ]
    low, high = np.quantile(drawn, [0.025, 0.975], axis=0)
    return np.where(low < 0.01, 0.0, low), np.where(high > 0.99, 1.0, high)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--repeats", type=int, default=40)
    parser.add_argument("--workers", type=int, default=2)
    options = parser.parse_args()
    seeds = range(options.repeats)
    print(f"{'function':10}{'runs':>6}{'scatter':>9}{'Q2':>7}{'held':>7}{'by draws':>10}", end="")
    print(f"{'error':>8}{'refused, Q2 < 0.5':>20}{'above':>12}")
    with ProcessPoolExecutor(options.workers) as pool:
        for case in CASES:
            found = list(pool.map(outcome, [case] * len(seeds), seeds))
            low = [o.refused for o in found if o.q2 < POOR_Q2]
            above = [o.refused for o in found if o.q2 >= POOR_Q2]
            name, runs, scatter = case
            print(
                f"{name:10}{runs:6}{scatter:9.1f}{np.median([o.q2 for o in found]):7.2f}"
                f"{np.mean([o.held for o in found]):7.2f}"
                f"{np.mean([o.held_by_draws for o in found]):10.2f}"
                f"{max(o.error for o in found):8.2f}{f'{sum(low)} of {len(low)}':>20}"
                f"{f'{sum(above)} of {len(above)}':>12}",
                flush=True,
            )


if __name__ == "__main__":
    main()
