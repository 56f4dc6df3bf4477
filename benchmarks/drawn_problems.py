"""Problems with known truth whose surface, noise and answer are drawn from a seed.

The measured values have errors of their stated uncertainty, so that 95 % intervals of parameters
should hold the truth in 95 %. The truth of a response is its mean over seeds, jams and rounding
included.
"""

from __future__ import annotations

import zlib
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

import grainfit
from grainfit.problem import CurveTarget, Parameter, Problem, Target
from verdict_problems import BASE, TOLERANCE, Array, KnownProblem, Surface

Random = np.random.Generator
#: Standard uncertainty of a measured value, in tolerances, and the largest error that is drawn.
UNCERTAINTY, LARGEST_ERROR = 0.25, 0.9
#: Points of a measured curve, and the part of their errors that is independent.
CURVE_POINTS, INDEPENDENT = 12, 0.03


@dataclass(frozen=True)
class Drawn:
    """A problem as it is drawn, in tolerances over the unit cube.

    Parameters
    ----------
    expected : callable
        Mean responses over seeds at a point.
    answer : ndarray, shape (d,)
        The point that gave the targets.
    run : callable, optional
        Responses of one run: of a generator and a point. None for a model without noise.
    scales : sequence of (float, float)
        Intervals of the parameters on a logarithmic scale; empty for 0 to 1 on a linear one.
    identifiable : bool
        Whether the targets determine the parameters.
    correlation : float
        Correlation of the errors of all measured values.
    has_errors : bool
        Whether the measured values differ from the responses of the answer.
    shift : sequence of float, optional
        Distance of the targets from these responses, which puts them out of reach.
    is_reachable : bool
        Whether some point truly meets every target.
    has_curve : bool
        Whether the last responses are the points of a curve.
    """

    expected: Surface
    answer: Array
    run: Callable[[Random, Array], Array] | None = None
    scales: Sequence[tuple[float, float]] = ()
    identifiable: bool = True
    correlation: float = 0.0
    has_errors: bool = True
    shift: Sequence[float] | None = None
    is_reachable: bool = True
    has_curve: bool = False


def problem_of(name: str, draw: Callable[[Random], Drawn]) -> Callable[[int], KnownProblem]:
    """Return a function that draws the problem of a seed."""
    number = zlib.crc32(name.encode())
    return lambda seed: _known(draw(np.random.default_rng([seed, number])), seed, number)


def _known(drawn: Drawn, seed: int, number: int) -> KnownProblem:
    names = [f"x{axis + 1}" for axis in range(len(drawn.answer))]
    if drawn.scales:
        ends = zip(names, drawn.scales, strict=True)
        parameters = [Parameter(name, *interval, scale="log") for name, interval in ends]
    else:
        parameters = [Parameter(name, 0.0, 1.0) for name in names]
    problem = _measured(drawn, parameters, np.random.default_rng([seed, number, 1]))

    def in_units(responses: Array) -> dict[str, Any]:
        values = (BASE + TOLERANCE * responses).tolist()
        found: dict[str, Any] = {t.name: values.pop(0) for t in problem.targets}
        return found | {c.name: grainfit.Curve(c.coordinates, values) for c in problem.curves}

    def expected(parameters: Mapping[str, float]) -> Array:
        return np.asarray(BASE + TOLERANCE * drawn.expected(problem.to_unit(parameters)))

    def simulate(parameters: dict[str, float], run_seed: int) -> dict[str, Any]:
        assert drawn.run is not None
        random = np.random.default_rng([run_seed, number])
        return in_units(drawn.run(random, problem.to_unit(parameters)))

    def simulate_without_noise(parameters: dict[str, float], _seed: int) -> dict[str, Any]:
        return in_units(drawn.expected(problem.to_unit(parameters)))

    return KnownProblem(
        problem,
        expected,
        simulate if drawn.run else simulate_without_noise,
        drawn.is_reachable,
        problem.from_unit(drawn.answer) if drawn.is_reachable else None,
        tuple(names) if drawn.identifiable else (),
    )


def _measured(drawn: Drawn, parameters: Sequence[Parameter], random: Random) -> Problem:
    """Return the problem with measured values: responses of the answer, with errors."""
    values = drawn.expected(drawn.answer)
    count = len(values) - CURVE_POINTS * drawn.has_curve
    if drawn.has_errors:
        shared = np.sqrt(drawn.correlation) * random.standard_normal()
        own = np.sqrt(1 - drawn.correlation) * random.standard_normal(count)
        errors = np.clip(UNCERTAINTY * (shared + own), -LARGEST_ERROR, LARGEST_ERROR)
        common = UNCERTAINTY * random.standard_normal()
        points = common + INDEPENDENT * random.standard_normal(len(values) - count)
        values = values + np.concatenate([errors, points])
    if drawn.shift is not None:
        values = values + np.array(drawn.shift)
    numbers = BASE + TOLERANCE * values
    targets = [
        Target(f"y{k + 1}", value, uncertainty=TOLERANCE * UNCERTAINTY, tolerance=TOLERANCE)
        for k, value in enumerate(numbers[:count].tolist())
    ]
    curves = [_curve(numbers[count:])] if drawn.has_curve else []
    pairs = [
        (a.name, b.name, drawn.correlation) for k, a in enumerate(targets) for b in targets[:k]
    ]
    return Problem(
        parameters, targets, correlations=pairs if drawn.correlation else (), curves=curves
    )


def _curve(values: Array) -> CurveTarget:
    return CurveTarget(
        "curve",
        np.linspace(0.0, 1.0, CURVE_POINTS).tolist(),
        values.tolist(),
        TOLERANCE * INDEPENDENT,
        systematic=TOLERANCE * UNCERTAINTY,
        tolerance=TOLERANCE,
    )
