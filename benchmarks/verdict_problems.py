"""Problems with known truth on which verdicts are judged: shapes of responses, kinds of noise.

Every problem is drawn from a seed: its target is the response of a random parameter set, or lies a
stated distance beyond the reach of the intervals. The truth of a noisy response is its mean over
seeds, with jams and outliers; that of Cauchy noise, which has no mean, is its centre.
"""

from __future__ import annotations

import math
import zlib
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.stats import t as student

from calibration_problems import CASES, Case, heap, true_parameters
from grainfit.problem import Parameter, Problem, Target

Array = NDArray[np.float64]
#: Expected responses in tolerances, shape (k,), at a point of the unit cube, shape (d,).
Surface = Callable[[Array], Array]
#: Scatter of the responses in tolerances, shape (k,), of a generator and a point.
Noise = Callable[[np.random.Generator, Array, int], Array]
#: Tolerance of every response; the values are around 100.
TOLERANCE = 2.0
BASE = 100.0
MARGIN = 0.1
#: Probability that every target is met, at which a calibration is calibrated.
CONFIDENCE = 0.95
#: Runs from which the scatter at the answer is computed, and the largest limit that is of use.
SCATTER_RUNS, LARGEST_LIMIT = 1000, 1000


@dataclass(frozen=True)
class KnownProblem:
    """One calibration whose truth is known.

    Parameters
    ----------
    problem : Problem
        Parameters, targets and measured curves.
    expected : callable
        True expected responses at given parameters: those of the targets, then the points of the
        curves.
    simulate : callable
        Responses of one run by name, at given parameters and seed.
    is_reachable : bool
        Whether some parameter set truly meets every target.
    truth : mapping of str to float, optional
        The parameters that gave the targets.
    identifiable : tuple of str
        Parameters that the targets determine.
    """

    problem: Problem
    expected: Callable[[Mapping[str, float]], Array]
    simulate: Callable[[dict[str, float], int], Mapping[str, Any]]
    is_reachable: bool = True
    truth: Mapping[str, float] | None = None
    identifiable: tuple[str, ...] = ()

    def tolerances_off(self, parameters: Mapping[str, float]) -> float:
        """Largest true deviation of an expected response, in units of its tolerance.

        Correlated targets are also met together: the root mean square of their decorrelated
        deviations counts as one more.
        """
        measured, tolerances = self._measured()
        off = (self.expected(parameters) - measured) / tolerances
        largest = float(np.max(np.abs(off)))
        if not self.problem.correlations:
            return largest
        together = self.problem.decorrelation @ off[: len(self.problem.targets)]
        return max(largest, float(np.sqrt(np.mean(together**2))))

    def statistical_limit(self) -> int | None:
        """Fewest runs that can establish that every target is met; None without an answer.

        The mean of n runs exactly on the targets, of which as many were spent on a trend as there
        are parameters and one, has Student's distribution with n - d - 1 degrees of freedom and the
        standard error scatter / sqrt(n). Of the points of a curve, which scatter together, the
        most scattering one counts. There are at least three runs beyond those of the trend.
        """
        if self.truth is None or not self.is_reachable:
            return None
        first = self.problem.dimension + 1
        scatter = self._scatter_at(self.truth)
        for runs in range(first + 3, LARGEST_LIMIT):
            with np.errstate(divide="ignore"):
                widths = math.sqrt(runs) / scatter
            if np.prod(2 * student.cdf(widths, runs - first) - 1) >= CONFIDENCE:
                return runs
        return None

    def _measured(self) -> tuple[Array, Array]:
        """Return the measured values and their tolerances, in the order of `expected`."""
        targets, curves = self.problem.targets, self.problem.curves
        values = [[target.value for target in targets], *(curve.values for curve in curves)]
        widths = [[target.tolerance for target in targets], *(c.tolerances for c in curves)]
        return np.concatenate(values), np.concatenate(widths)

    def _scatter_at(self, parameters: Mapping[str, float]) -> Array:
        """Return the scatter of single runs in tolerances, one for each target and each curve."""
        targets, curves = self.problem.targets, self.problem.curves
        runs = [self.simulate(dict(parameters), seed) for seed in range(SCATTER_RUNS)]
        scatter = [np.std([run[t.name] for run in runs]) / t.tolerance for t in targets]
        for curve in curves:
            points = np.std([run[curve.name].values for run in runs], axis=0)
            scatter.append(np.max(points / curve.tolerances))
        return np.array(scatter)


# Noise --------------------------------------------------------------------------------------


def gaussian(scatter: float) -> Noise:
    """Scatter that is normal and the same everywhere."""
    return lambda random, _point, count: scatter * random.standard_normal(count)


def growing(low: float, high: float) -> Noise:
    """Scatter that grows over the first interval."""

    def noise(random: np.random.Generator, point: Array, count: int) -> Array:
        return np.asarray((low + (high - low) * point[0]) * random.standard_normal(count))

    return noise


def with_outliers(noise: Noise, share: float, scatter: float) -> Noise:
    """Outliers of 5 to 10 standard deviations to both sides."""

    def noisy(random: np.random.Generator, point: Array, count: int) -> Array:
        values = noise(random, point, count)
        size = scatter * random.uniform(5.0, 10.0, count) * random.choice([-1.0, 1.0], count)
        return np.asarray(np.where(random.random(count) < share, values + size, values))

    return noisy


def two_modes(scatter: float, apart: float) -> Noise:
    """Two equally likely states of the bulk solid: their mean is expected."""

    def noise(random: np.random.Generator, _point: Array, count: int) -> Array:
        side = random.choice([-0.5, 0.5], count)
        return np.asarray(apart * side + scatter * random.standard_normal(count))

    return noise


def cauchy(scatter: float) -> Noise:
    """Cauchy noise: it has neither mean nor variance."""
    return lambda random, _point, count: np.clip(scatter * random.standard_cauchy(count), -1e3, 1e3)


# Surfaces -----------------------------------------------------------------------------------


def _linear(slopes: list[list[float]]) -> Surface:
    matrix = np.array(slopes)
    return lambda point: matrix @ (point - 0.5)


def _smooth(point: Array) -> Array:
    x, y = point
    return np.array(
        [12 * (x - 0.5) + 2 * np.sin(2 * y), 9 * np.tanh(1.5 * y) - 4 * x * y + 3 * x * x]
    )


def _ridge(point: Array) -> Array:
    x, y = point
    return np.array([20 * (x - 0.3) * (y - 0.2) + 6 * x])


def _banana(point: Array) -> Array:
    x, y = point
    return np.array([14 * (y - 1.2 * (x - 0.4) ** 2), 6 * x + 1.5 * y])


def _plateau(point: Array) -> Array:
    x, y = point
    return np.array([10 * np.tanh(3 * x) * np.tanh(3 * y), 8 * (1 - np.exp(-4 * x)) + 3 * y])


def _inactive(point: Array) -> Array:
    return np.array([9 * point[0] + 4 * point[1] ** 2, 7 * point[1] - 3 * point[0]])


def _basins(point: Array) -> Array:
    x, y = point
    return np.array([6 * np.sin(7 * x) + 2 * y, 5 * np.cos(5 * y) + 2 * x])


def _interactions(point: Array) -> Array:
    x, y, z = point
    return np.array(
        [8 * x * (0.5 + y) - 3 * z, 9 * np.sqrt(0.05 + y) * (1 - 0.5 * x), 7 * z * z + 4 * x * y]
    )


def _many(dimension: int) -> Surface:
    random = np.random.default_rng(dimension)
    slopes = random.normal(0.0, 6.0, (4, dimension))
    bend = random.normal(0.0, 2.0, (4, dimension))
    return lambda point: slopes @ (point - 0.5) + bend @ (point - 0.5) ** 2


def _drawn(
    name: str,
    dimension: int,
    surface: Surface,
    noise: Noise,
    *,
    edge: bool = False,
    beyond: float | None = None,
    mean_of_noise: Array | float = 0.0,
) -> Callable[[int], KnownProblem]:
    """A problem whose target is drawn from a seed.

    With ``edge`` the answer lies on bounds; with ``beyond`` the first target lies so many
    tolerances beyond the largest response of the intervals.
    """
    number = zlib.crc32(name.encode())

    def draw(seed: int) -> KnownProblem:
        random = np.random.default_rng([seed, number])
        place = random.uniform(MARGIN, 1 - MARGIN, dimension)
        if edge:
            place = np.where(random.random(dimension) < 0.7, place.round(), place)
        middle = np.atleast_1d(surface(place)) + mean_of_noise
        reach = middle
        if beyond is not None:
            cloud = random.random((20_000, dimension))
            highest = max(float(surface(point)[0]) for point in cloud)
            corners = [np.array(c, float) for c in np.ndindex(*(2,) * min(dimension, 10))]
            if len(corners[0]) == dimension:
                highest = max(highest, *(float(surface(point)[0]) for point in corners))
            reach = middle.copy()
            reach[0] = highest + 1.0 + beyond
        parameters = [Parameter(f"x{axis + 1}", 0.0, 1.0) for axis in range(dimension)]
        targets = [
            Target(f"y{k + 1}", BASE + TOLERANCE * float(value), tolerance=TOLERANCE)
            for k, value in enumerate(reach)
        ]

        def expected(values: Mapping[str, float]) -> Array:
            point = np.array([values[p.name] for p in parameters])
            return np.asarray(BASE + TOLERANCE * (np.atleast_1d(surface(point)) + mean_of_noise))

        def simulate(values: dict[str, float], run_seed: int) -> dict[str, float]:
            point = np.array([values[p.name] for p in parameters])
            drawn = noise(np.random.default_rng([run_seed, number]), point, len(targets))
            responses = BASE + TOLERANCE * (np.atleast_1d(surface(point)) + drawn)
            return {t.name: float(v) for t, v in zip(targets, responses, strict=True)}

        names = [p.name for p in parameters]
        truth = dict(zip(names, place.tolist(), strict=True)) if beyond is None else None
        return KnownProblem(Problem(parameters, targets), expected, simulate, beyond is None, truth)

    return draw


def _recorded(make: Callable[[int], Case], reachable: bool = True) -> Callable[[int], KnownProblem]:
    """A problem of `calibration_problems`."""

    def draw(seed: int) -> KnownProblem:
        case = make(seed)
        names = [target.name for target in case.problem.targets]

        def simulate(values: dict[str, float], run_seed: int) -> dict[str, float]:
            found = case.simulate(values, run_seed).tolist()
            return dict(zip(names, found, strict=True))

        truth = true_parameters(case.problem, seed) if reachable else None
        return KnownProblem(case.problem, case.expected, simulate, reachable, truth)

    return draw


def _jams(scatter: float, share: float, size: float) -> Noise:
    """Runs that jam: the first response falls by ``size``."""

    def noise(random: np.random.Generator, _point: Array, count: int) -> Array:
        values = scatter * random.standard_normal(count)
        values[0] -= size * (random.random() < share)
        return np.asarray(values)

    return noise


WELL_BEHAVED: dict[str, Callable[[int], KnownProblem]] = {
    "heap, +-33 %": _recorded(CASES["heap, +-33 %"]),
    "heap, +-66 %": _recorded(CASES["heap, +-66 %"]),
    "heap, four parameters": _recorded(CASES["heap, four parameters"]),
    "analytic, six parameters": _recorded(CASES["analytic, six parameters"]),
    "line": _drawn("line", 1, _linear([[10.0]]), gaussian(0.5)),
    "plane": _drawn("plane", 2, _linear([[9.0, 4.0], [-3.0, 8.0]]), gaussian(1.0)),
    "smooth": _drawn("smooth", 2, _smooth, gaussian(0.7)),
    "ridge": _drawn("ridge", 2, _ridge, gaussian(0.7)),
    "banana": _drawn("banana", 2, _banana, gaussian(0.3)),
    "plateau": _drawn("plateau", 2, _plateau, gaussian(0.5)),
    "edge": _drawn("edge", 2, _smooth, gaussian(0.5), edge=True),
    "inactive": _drawn("inactive", 5, _inactive, gaussian(0.7)),
    "basins": _drawn("basins", 2, _basins, gaussian(0.2)),
    "interactions": _drawn("interactions", 3, _interactions, gaussian(0.5)),
    "eight": _drawn("eight", 8, _many(8), gaussian(0.5)),
    "fourteen": _drawn("fourteen", 14, _many(14), gaussian(0.5)),
}
NOISE: dict[str, Callable[[int], KnownProblem]] = {
    "gaussian": _drawn("gaussian", 2, _smooth, gaussian(0.8)),
    "growing": _drawn("growing", 2, _smooth, growing(0.2, 2.5)),
    "outliers": _drawn("outliers", 2, _smooth, with_outliers(gaussian(0.5), 0.07, 0.5)),
    "growing, outliers": _drawn(
        "growing, outliers", 2, _smooth, with_outliers(growing(0.2, 1.5), 0.07, 0.8)
    ),
    "large scatter": _drawn("large scatter", 2, _smooth, gaussian(2.5)),
    "two modes": _drawn("two modes", 2, _smooth, two_modes(0.4, 3.0)),
    "cauchy": _drawn("cauchy", 2, _smooth, cauchy(0.4)),
    "jams": _drawn(
        "jams", 2, _smooth, _jams(0.5, 0.12, 12.0), mean_of_noise=np.array([-0.12 * 12.0, 0.0])
    ),
}
HOPELESS: dict[str, Callable[[int], KnownProblem]] = {
    "half a tolerance beyond": _drawn("half", 2, _smooth, gaussian(0.5), beyond=0.5),
    "two tolerances beyond": _drawn("two", 2, _smooth, gaussian(0.5), beyond=2.0),
    "scatter of ten tolerances": _drawn("ten", 2, _smooth, gaussian(10.0)),
    "heap, +-10 %, beyond": _recorded(lambda seed: _out_of_reach_heap(seed), reachable=False),
}


def _out_of_reach_heap(seed: int) -> Case:
    """The paper's +-10 % intervals, with an angle of repose that they do not reach."""
    case = heap(seed, 0.10)
    names = [parameter.name for parameter in case.problem.parameters]
    cube = np.random.default_rng([seed, 10]).random((2000, len(names)))
    values = np.array([list(case.problem.from_unit(point).values()) for point in cube])
    highest = float(case.truth(values)[:, 1].max())
    density, angle = case.problem.targets
    targets = [density, Target(angle.name, highest + 1.5 * angle.tolerance, tolerance=0.5)]
    return Case(Problem(case.problem.parameters, targets), case.truth, case.noise)


PROBLEMS = WELL_BEHAVED | NOISE | HOPELESS
