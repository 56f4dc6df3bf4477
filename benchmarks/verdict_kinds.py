"""Kinds of responses on which verdicts are judged: smooth ones, noise, cliffs, jams, no answer.

Surface, noise and answer of every problem are drawn from a seed, see `drawn_problems.py`.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
from scipy.stats import norm

from drawn_problems import CURVE_POINTS, Drawn, Random, problem_of
from grainfit.errors import RunFailedError
from verdict_problems import (
    MARGIN,
    Array,
    KnownProblem,
    Noise,
    Surface,
    gaussian,
    with_outliers,
)

#: Distance of an answer from a threshold, a stripe, or a region of jams or failures.
CLEARANCE = 0.05

# Parts of problems --------------------------------------------------------------------------


def _place(random: Random, dimension: int = 2) -> Array:
    return random.uniform(MARGIN, 1 - MARGIN, dimension)


def _place_where(random: Random, holds: Callable[[Array], bool]) -> Array:
    place = _place(random)
    while not holds(place):
        place = _place(random)
    return place


def _factors(random: Random, count: int) -> Array:
    """Factors by which problems of one kind differ, with their signs."""
    return random.uniform(0.8, 1.25, count) * random.choice([-1.0, 1.0], count)


def _hill(random: Random) -> Surface:
    """A smooth surface of two responses of two parameters."""
    first, second = _factors(random, 2)
    phase = random.uniform(0.0, 2.0)

    def surface(point: Array) -> Array:
        x, y = point
        return np.array(
            [
                first * (10 * (x - 0.5) + 2 * np.sin(2 * y + phase)),
                second * (8 * np.tanh(1.5 * y) - 3 * x * y + 2 * x * x),
            ]
        )

    return surface


def _with_noise(surface: Surface, noise: Noise) -> Callable[[Random, Array], Array]:
    def run(random: Random, point: Array) -> Array:
        expected = surface(point)
        return np.asarray(expected + noise(random, point, len(expected)))

    return run


def _noisy(surface: Surface, answer: Array, noise: Noise | None, **options: Any) -> Drawn:
    return Drawn(surface, answer, _with_noise(surface, noise) if noise else None, **options)


def _hilly(noise: Noise) -> Callable[[Random], Drawn]:
    return lambda random: _noisy(_hill(random), _place(random), noise)


# Smooth -------------------------------------------------------------------------------------


def _frictions(random: Random) -> Drawn:
    """Sliding against rolling friction: the angle has their product, and little separates them."""
    first, second = _factors(random, 2)

    def surface(point: Array) -> Array:
        sliding, rolling = point
        product = (0.15 + sliding) * (0.1 + rolling)
        return np.array([first * 14 * np.tanh(1.6 * product), second * (3 * sliding - 2 * rolling)])

    return _noisy(surface, _place(random), gaussian(0.5))


def _exact_line(random: Random) -> Drawn:
    factor = _factors(random, 1)

    def surface(point: Array) -> Array:
        return np.asarray(12 * factor * (point + 0.25 * np.sin(3 * point)))

    return _noisy(surface, _place(random, 1), None)


def _three_decades(random: Random) -> Drawn:
    first, second = _factors(random, 2)

    def surface(point: Array) -> Array:
        x, y = point
        return np.array([first * (11 * np.tanh(1.5 * x) + 3 * y), second * (8 * y - 3 * x)])

    scales = [(1e5, 1e8), (0.01, 1.0)]
    return _noisy(surface, _place(random), gaussian(0.6), scales=scales)


def _bent(random: Random, responses: int, dimension: int) -> Surface:
    slopes = random.normal(0.0, 6.0, (responses, dimension))
    bend = random.normal(0.0, 2.0, (responses, dimension))
    return lambda point: slopes @ (point - 0.5) + bend @ (point - 0.5) ** 2


def _eight_over_decades(random: Random) -> Drawn:
    scales = [(1.0, 10.0**decades) for decades in random.uniform(1.0, 3.0, 8)]
    return _noisy(
        _bent(random, 4, 8), _place(random, 8), gaussian(0.5), scales=scales, identifiable=False
    )


def _correlated(scatter: float, correlation: float) -> Noise:
    """Scatter that the responses of a run share in part."""

    def noise(random: Random, _point: Array, count: int) -> Array:
        shared, own = random.standard_normal(), random.standard_normal(count)
        return np.asarray(
            scatter * (np.sqrt(correlation) * shared + np.sqrt(1 - correlation) * own)
        )

    return noise


def _six_correlated(random: Random) -> Drawn:
    return _noisy(_bent(random, 6, 3), _place(random, 3), _correlated(0.6, 0.7), correlation=0.7)


def _corner(random: Random) -> Drawn:
    return _noisy(_hill(random), random.integers(0, 2, 2).astype(float), gaussian(0.5))


def _failures(random: Random) -> Drawn:
    """Runs fail in a corner of about a quarter of the box."""
    surface, limit = _hill(random), random.uniform(1.2, 1.4)
    noisy = _with_noise(surface, gaussian(0.6))

    def run(generator: Random, point: Array) -> Array:
        if point.sum() > limit:
            raise RunFailedError("The particles leave the box.")
        return noisy(generator, point)

    answer = _place_where(random, lambda place: place.sum() < limit - 2 * CLEARANCE)
    return Drawn(surface, answer, run)


def _curve_and_scalar(random: Random) -> Drawn:
    first, second = _factors(random, 2)
    along = np.linspace(0.0, 1.0, CURVE_POINTS)

    def surface(point: Array) -> Array:
        x, y = point
        curve = second * (9 * y * along + 8 * x * (1 - np.exp(-3 * along)))
        return np.concatenate([[first * (8 * x - 3 * y)], curve])

    def noise(generator: Random, _point: Array, count: int) -> Array:
        scalar, level, slope = generator.standard_normal(3)
        rough = 0.05 * generator.standard_normal(count - 1)
        return np.concatenate([[0.5 * scalar], 0.3 * level + 0.4 * slope * along + rough])

    return _noisy(surface, _place(random), noise, has_curve=True)


# Noise --------------------------------------------------------------------------------------


def _student(scale: float) -> Noise:
    return lambda random, _point, count: scale * random.standard_t(3, count)


def _skewed(scatter: float, shape: float) -> Noise:
    """Lognormal scatter, shifted so that its mean is zero."""
    mean = np.exp(shape**2 / 2)
    deviation = mean * np.sqrt(np.exp(shape**2) - 1)

    def noise(random: Random, _point: Array, count: int) -> Array:
        return np.asarray((random.lognormal(0.0, shape, count) - mean) * scatter / deviation)

    return noise


def _scatter_of(size: Callable[[Array], float]) -> Noise:
    return lambda random, point, count: size(point) * random.standard_normal(count)


def _stripe(random: Random) -> Drawn:
    """Scatter of three tolerances in a stripe across the box, beside the answer."""
    middle, half = random.uniform(0.25, 0.75), 0.1
    noise = _scatter_of(lambda point: 3.0 if abs(point[0] - middle) < half else 0.3)
    answer = _place_where(random, lambda place: abs(place[0] - middle) > half + CLEARANCE)
    return _noisy(_hill(random), answer, noise)


def _half_exact(random: Random) -> Drawn:
    noise = _scatter_of(lambda point: 0.8 * float(point[0] > 0.5))
    return _noisy(_hill(random), _place(random), noise)


def _quantised(random: Random) -> Drawn:
    """Values in steps of one tolerance, as a count of particles has, and little scatter."""
    surface, scatter, reach = _hill(random), 0.25, 4

    def expected(point: Array) -> Array:
        values = surface(point)
        steps = np.round(values)[:, None] + np.arange(-reach, reach + 1)
        off = steps - values[:, None]
        chances = norm.cdf((off + 0.5) / scatter) - norm.cdf((off - 0.5) / scatter)
        return np.asarray((steps * chances).sum(axis=1))

    noisy = _with_noise(surface, gaussian(scatter))
    return Drawn(expected, _place(random), lambda generator, point: noisy(generator, point).round())


# Cliffs -------------------------------------------------------------------------------------


def _threshold(noise: Noise | None, tilt: float = 0.0) -> Callable[[Random], Drawn]:
    """The first response drops by six tolerances where x1, or a sum of both, exceeds a limit."""

    def draw(random: Random) -> Drawn:
        hill, limit = _hill(random), random.uniform(0.35, 0.65) + 0.5 * tilt
        side = random.choice([-1.0, 1.0]) * CLEARANCE

        def surface(point: Array) -> Array:
            return hill(point) - np.array([6.0 * (point[0] + tilt * point[1] > limit), 0.0])

        y = float(random.uniform(MARGIN, 1 - MARGIN))
        if not tilt:
            return _noisy(surface, np.array([limit + side, y]), noise)
        answer = _place_where(random, lambda at: abs(at[0] + tilt * at[1] - limit) > CLEARANCE)
        return _noisy(surface, answer, noise)

    return draw


def _onset(noise: Noise | None) -> Callable[[Random], Drawn]:
    """The first response is almost flat, then rises by a tolerance in 1/60 of the interval."""

    def draw(random: Random) -> Drawn:
        limit = random.uniform(0.5, 0.7)
        first, second = _factors(random, 2)

        def surface(point: Array) -> Array:
            x, y = point
            return np.array([first * (60 * max(0.0, x - limit) + x + y), second * (8 * y - 2 * x)])

        answer = np.array([limit + random.uniform(CLEARANCE, 0.2), random.uniform(MARGIN, 0.9)])
        return _noisy(surface, answer, noise)

    return draw


def _step(random: Random) -> Drawn:
    """One parameter: a step of six tolerances, and a slope of five."""
    factor, limit = _factors(random, 1), random.uniform(0.25, 0.75)

    def surface(point: Array) -> Array:
        return np.asarray(factor * (5 * point + 6 * (point > limit)))

    side = random.choice([-1.0, 1.0]) * random.uniform(0.01, 0.1)
    return _noisy(surface, np.array([limit + side]), gaussian(0.5))


# Jams ---------------------------------------------------------------------------------------


def _jamming(
    share: float, size: float, jams_at: Callable[[Array], bool], *, is_clear: bool
) -> Callable[[Random], Drawn]:
    """Runs jam with a probability in a region: the first response falls by ``size``."""

    def draw(random: Random) -> Drawn:
        hill = _hill(random)
        noisy = _with_noise(hill, gaussian(0.5))

        def expected(point: Array) -> Array:
            return hill(point) - np.array([share * size * jams_at(point), 0.0])

        def run(generator: Random, point: Array) -> Array:
            jams = jams_at(point) and generator.random() < share
            return noisy(generator, point) - np.array([size * jams, 0.0])

        def is_free(place: Array) -> bool:
            return not is_clear or not jams_at(place + CLEARANCE)

        return Drawn(expected, _place_where(random, is_free), run)

    return draw


# Without an answer --------------------------------------------------------------------------


def _conflict(random: Random) -> Drawn:
    """Two responses that go together, with targets that are four tolerances apart."""
    factor = _factors(random, 1)[0]

    def surface(point: Array) -> Array:
        x, y = point
        first = factor * (7 * x + 5 * y)
        return np.array([first, 0.9 * first + 0.4 * np.sin(3 * (x - y))])

    shift = [0.0, 4.0 * random.choice([-1.0, 1.0])]
    return _noisy(surface, _place(random), gaussian(0.5), shift=shift, is_reachable=False)


def _beyond_a_cliff(random: Random) -> Drawn:
    """The target is in the middle of what a threshold leaves out."""
    second, limit = _factors(random, 1)[0], random.uniform(0.35, 0.65)

    def surface(point: Array) -> Array:
        x, y = point
        return np.array([3 * x + y + 7 * (x > limit), second * (8 * y - 2 * x)])

    y = float(random.uniform(MARGIN, 1 - MARGIN))
    return _noisy(
        surface, np.array([limit, y]), gaussian(0.5), shift=[3.5, 0.0], is_reachable=False
    )


def _edge_of_the_tolerance(random: Random) -> Drawn:
    """The target is exactly one tolerance beyond the largest response, which is in a corner."""
    slopes = random.uniform(0.8, 1.25, 4)

    def surface(point: Array) -> Array:
        x, y = point
        return np.array([slopes[0] * 8 * x + slopes[1] * 5 * y, slopes[2] * 6 * y - slopes[3] * x])

    return _noisy(
        surface,
        np.ones(2),
        gaussian(0.5),
        has_errors=False,
        shift=[1.0, 0.0],
        identifiable=False,
    )


def _kinds(
    draws: Mapping[str, Callable[[Random], Drawn]],
) -> dict[str, Callable[[int], KnownProblem]]:
    return {name: problem_of(name, draw) for name, draw in draws.items()}


SMOOTH = _kinds(
    {
        "two frictions": _frictions,
        "exact line": _exact_line,
        "three decades": _three_decades,
        "eight over decades": _eight_over_decades,
        "six correlated": _six_correlated,
        "narrow tolerance": _hilly(gaussian(1.5)),
        "corner": _corner,
        "failures": _failures,
        "curve and scalar": _curve_and_scalar,
    }
)
NOISY = _kinds(
    {
        "student": _hilly(_student(0.4)),
        "skewed": _hilly(_skewed(0.7, 0.8)),
        "some outliers": _hilly(with_outliers(gaussian(0.5), 0.07, 0.5)),
        "noisy stripe": _stripe,
        "half exact": _half_exact,
        "quantised": _quantised,
    }
)
CLIFFS = _kinds(
    {
        "threshold": _threshold(gaussian(0.5)),
        "exact threshold": _threshold(None),
        "onset": _onset(gaussian(0.5)),
        "exact onset": _onset(None),
        "step": _step,
        "oblique threshold": _threshold(gaussian(0.5), tilt=0.5),
    }
)
JAMMING = _kinds(
    {
        "jams in a corner": _jamming(
            0.5, 10.0, lambda point: bool(min(point) > 0.55), is_clear=True
        ),
        "jams in half": _jamming(0.3, 5.0, lambda point: bool(point[0] > 0.5), is_clear=False),
    }
)
NO_ANSWER = _kinds({"conflict": _conflict, "beyond a cliff": _beyond_a_cliff})
#: An answer exists, but more runs than the budget has are needed to establish it.
BEYOND_BUDGET = _kinds({"scatter of four tolerances": _hilly(gaussian(4.0))})
#: The best deviation that can be reached is exactly one tolerance.
EDGE = _kinds({"edge of the tolerance": _edge_of_the_tolerance})
KINDS = SMOOTH | NOISY | CLIFFS | JAMMING | NO_ANSWER | BEYOND_BUDGET | EDGE
