"""Sizes of designs and searches within a budget of runs."""

from __future__ import annotations

import math

from grainfit.errors import InputError
from grainfit.problem import Problem
from grainfit.strategies import messages
from grainfit.strategies.base import Search, Strategy


def start_search(
    strategy: Strategy,
    problem: Problem,
    tests: int,
    seed: int,
    max_runs: int | None,
    verification_runs: int,
    scatter: float | None = None,
) -> Search:
    """Start the search of a calibration within a budget of DEM runs.

    Parameters
    ----------
    strategy : Strategy
        Chooses the runs.
    problem : Problem
        Problem to calibrate.
    tests : int
        DEM runs per parameter set.
    seed : int
        Decides the design and all insertion seeds.
    max_runs : int or None
        Largest number of DEM runs, verification included.
    verification_runs : int
        Runs of a verification; the budget keeps room for one.
    scatter : float, optional
        Scatter of single evaluations in tolerances, where it is known before any run: the largest
        of all targets.

    Raises
    ------
    InputError
        The design is too small, the budget is too small for the design and the verification, or
        the problem weighs something that the strategy does not take into account.
    """
    strategy.check_rayleigh_weight(problem.rayleigh_weight)
    strategy.check_relatives("relatives" if problem.relatives else "")
    if max_runs is None:
        return _with_scatter(strategy.start(problem, seed), scatter)
    smallest = (strategy.fewest_evaluations(problem) + verification_runs) * tests
    if max_runs < smallest:
        raise InputError(
            messages.BUDGET_TOO_SMALL.fault("max_runs", runs=max_runs, fewest=smallest)
        )
    search = strategy.start(problem, seed, max_runs // tests - verification_runs)
    return _with_scatter(search, scatter)


def _with_scatter(search: Search, scatter: float | None) -> Search:
    if scatter is not None:
        search.expected_scatter = scatter
    return search


def runs_with_scatter(ratio: float, dimension: int) -> int:
    """Return the number of runs that problems with such a scatter usually take in all.

    A mean of n runs has to be known to a tolerance over 2.24 standard errors (97.5 %), and the
    slopes take a run each (`benchmarks/scatter_forecast.py`).

    Parameters
    ----------
    ratio : float
        Standard deviation of single runs, in tolerances.
    dimension : int
        Number of free parameters.
    """
    return int(min(1.1 * (2.24 * ratio) ** 2 + dimension + 4, 1e6))


def scatter_with_runs(runs: int, dimension: int) -> float:
    """Return the scatter, in tolerances, that takes a number of runs: see `runs_with_scatter`."""
    return math.sqrt((runs - dimension - 4) / 1.1) / 2.24


def smallest_design(dimension: int, wanted: int | None = None) -> int:
    """Return the wanted size of the design, or the smallest possible one by default.

    Raises
    ------
    InputError
        The wanted design is too small to fit metamodels.
    """
    smallest = dimension + 3
    if wanted is not None and wanted < smallest:
        raise InputError(
            messages.DESIGN_TOO_SMALL.fault(
                "design_runs", runs=wanted, dimension=dimension, fewest=smallest
            )
        )
    return wanted or smallest


def design_size(dimension: int, wanted: int | None, usual: int, max_evaluations: int | None) -> int:
    """Return the size of a design within a budget.

    Parameters
    ----------
    dimension : int
        Number of free parameters.
    wanted : int, optional
        Size given by the user.
    usual : int
        Default size of the strategy.
    max_evaluations : int, optional
        The budget. A tight one keeps a third for the runs after the design.

    Raises
    ------
    InputError
        The wanted design is too small for metamodels or too large for the budget.
    """
    smallest = smallest_design(dimension, wanted)
    if max_evaluations is None:
        return wanted or usual
    if max_evaluations < smallest:
        raise InputError(
            messages.DESIGN_OVER_BUDGET.fault(
                "max_evaluations", runs=max_evaluations, fewest=smallest
            )
        )
    return wanted or min(usual, max(smallest, (2 * max_evaluations) // 3))
