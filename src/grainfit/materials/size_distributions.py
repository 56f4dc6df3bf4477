"""Continuous distributions of particle sizes by mass.

A distribution is known by its passing Q(d), the share of the mass that is finer than d, and by its
partial moments, the integrals of d^k dQ, in closed form.

References
----------
ISO 9276-2:2014, Representation of results of particle size analysis, part 2: moments.
ISO 9276-5:2005, part 5: methods of calculation with a logarithmic normal distribution.
Hatch & Choate, J. Franklin Institute 207 (1929) 369-387: moments of the log-normal distribution.
Rosin & Rammler, J. Institute of Fuel 7 (1933) 29-36.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from bisect import bisect_left
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from itertools import pairwise
from statistics import NormalDist
from typing import Any, ClassVar

from grainfit.errors import Fault, InputError
from grainfit.formatting import millimetres, percent
from grainfit.materials import messages
from grainfit.materials.sizes import LARGEST_DIAMETER, SMALLEST_DIAMETER
from grainfit.one_line import OneLine
from grainfit.options.fields import Amount, option, option_keys, read_options
from grainfit.options.kinds import Quantity
from grainfit.validation import number_list_faults, plain_tuple

DIAMETER = Quantity("m", lowest=SMALLEST_DIAMETER, highest=LARGEST_DIAMETER)
#: Rounding of percentages in sieve curves.
ROUNDING = 1e-9
_STANDARD_NORMAL = NormalDist()
#: 90 % quantile of the standard normal distribution.
_Z90 = _STANDARD_NORMAL.inv_cdf(0.9)


class SizeDistribution(OneLine, ABC):
    """A continuous distribution of particle sizes by mass."""

    #: Name in the calibration file.
    key: ClassVar[str]

    @abstractmethod
    def passing(self, diameter: float) -> float:
        """Return the share of the mass that is finer than a diameter; the diameter may be inf."""

    @abstractmethod
    def quantile(self, share: float) -> float:
        """Return the diameter below which a share of the mass is, m; inf for all of it."""

    @abstractmethod
    def moment(self, order: int, low: float, high: float) -> float:
        """Return the integral of d^order over the mass between two diameters, m^order."""

    @abstractmethod
    def __str__(self) -> str: ...

    @property
    def known_between(self) -> tuple[float, float]:
        """Diameters between which the passing is known, m."""
        return 0.0, math.inf


@dataclass(frozen=True)
class LogNormal(SizeDistribution):
    """Log-normal distribution by mass, by its median and spread or by two quantiles.

    Parameters
    ----------
    median : float or str
        Diameter that half of the mass is finer than, m.
    geometric_standard_deviation : float
        d84 / d50, above 1.
    d10, d90 : float or str
        Instead of both: diameters that 10 % and 90 % of the mass are finer than, m.

    Raises
    ------
    InputError
        The parameters are impossible, or too many or too few.

    Examples
    --------
    >>> round(LogNormal(d10="2 mm", d90="4.5 mm").quantile(0.5), 6)
    0.003
    """

    key: ClassVar[str] = "log_normal"

    median: Amount | None = option(
        DIAMETER, "Diameter that half of the mass is finer than (d50).", example='"3 mm"'
    )
    geometric_standard_deviation: float | None = option(
        Quantity("", lowest=1.001, highest=10), "Spread: d84 over d50.", example="1.4"
    )
    d10: Amount | None = option(
        DIAMETER,
        "Instead of median and spread, with d90: diameter that 10 % of the mass are finer than.",
        example='"2 mm"',
    )
    d90: Amount | None = option(
        DIAMETER, "Diameter that 90 % of the mass are finer than.", example='"4.5 mm"'
    )
    #: Median by mass, m.
    centre: float = field(init=False, repr=False, compare=False)
    #: Standard deviation of the natural logarithm of the diameter.
    spread: float = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        resolve_options(self)
        given = {key.name for key in option_keys(LogNormal) if getattr(self, key.name) is not None}
        if given not in ({"median", "geometric_standard_deviation"}, {"d10", "d90"}):
            there = ", ".join(sorted(given)) or "nothing"
            raise InputError(messages.NO_LOG_NORMAL.fault("", given=there))
        centre, spread = self.median, self.geometric_standard_deviation
        if centre is None or spread is None:
            d10, d90 = float(self.d10 or 0), float(self.d90 or 0)
            if 1.001 * d10 >= d90:
                low, high = millimetres(d10), millimetres(d90)
                raise InputError(messages.PERCENTILES_SWAPPED.fault("d10", low=low, high=high))
            centre, spread = math.sqrt(d10 * d90), (d90 / d10) ** (1 / (2 * _Z90))
        object.__setattr__(self, "centre", float(centre))
        object.__setattr__(self, "spread", math.log(spread))

    def passing(self, diameter: float) -> float:
        """Return the share of the mass that is finer than a diameter."""
        return _normal_between(-math.inf, self._score(diameter))

    def quantile(self, share: float) -> float:
        """Return the diameter below which a share of the mass is, m."""
        if not 0 < share < 1:
            return 0.0 if share <= 0 else math.inf
        return self.centre * math.exp(self.spread * _STANDARD_NORMAL.inv_cdf(share))

    def moment(self, order: int, low: float, high: float) -> float:
        """Return the integral of d^order over the mass between two diameters: Hatch & Choate."""
        shift = order * self.spread
        share = _normal_between(self._score(low) - shift, self._score(high) - shift)
        return math.pow(self.centre, order) * math.exp(shift**2 / 2) * share

    def _score(self, diameter: float) -> float:
        if diameter <= 0 or math.isinf(diameter):
            return -math.inf if diameter <= 0 else math.inf
        return math.log(diameter / self.centre) / self.spread

    def __str__(self) -> str:
        return (
            f"log-normal, median {millimetres(self.centre)}, geometric standard deviation "
            f"{math.exp(self.spread):.4g}"
        )


@dataclass(frozen=True)
class RosinRammler(SizeDistribution):
    """Rosin-Rammler (Weibull) distribution by mass: passing 1 - exp(-(d / d63)^n).

    Parameters
    ----------
    d63 : float or str
        Characteristic size, that 63.2 % of the mass are finer than, m.
    exponent : float
        n: the larger, the narrower.

    Examples
    --------
    >>> round(RosinRammler(d63="3 mm", exponent=3).passing(0.003), 3)
    0.632
    """

    key: ClassVar[str] = "rosin_rammler"

    d63: Amount = option(
        DIAMETER, "Characteristic size: 63.2 % of the mass are finer.", example='"3 mm"'
    )
    exponent: float = option(
        Quantity("", lowest=0.3, highest=50), "Exponent n: the larger, the narrower.", example="3"
    )

    def __post_init__(self) -> None:
        resolve_options(self)
        InputError.raise_for(
            messages.MISSING.fault(key.name, name=key.name, example=key.example)
            for key in option_keys(RosinRammler)
            if getattr(self, key.name) is None
        )

    def passing(self, diameter: float) -> float:
        """Return the share of the mass that is finer than a diameter."""
        return -math.expm1(-self._reduced(diameter))

    def quantile(self, share: float) -> float:
        """Return the diameter below which a share of the mass is, m."""
        if not 0 < share < 1:
            return 0.0 if share <= 0 else math.inf
        return float(self.d63) * math.pow(-math.log1p(-share), 1 / self.exponent)

    def moment(self, order: int, low: float, high: float) -> float:
        """Return the integral of d^order over the mass between two diameters.

        It is d63^k times the difference of two incomplete gamma functions of 1 + k / n; infinite
        from zero on where 1 + k / n is not above 0.
        """
        power = 1 + order / self.exponent
        ends = self._reduced(low), self._reduced(high)
        if ends[0] == 0 and power <= 0:
            return math.inf
        between = _upper_gamma(power, ends[0]) - _upper_gamma(power, ends[1])
        return math.pow(float(self.d63), order) * between

    def _reduced(self, diameter: float) -> float:
        try:
            return math.pow(diameter / float(self.d63), self.exponent)
        except OverflowError:
            return math.inf

    def __str__(self) -> str:
        return f"Rosin-Rammler, d63 {millimetres(float(self.d63))}, exponent {self.exponent:.4g}"


@dataclass(frozen=True)
class SieveCurve(SizeDistribution):
    """Cumulative passing of sieves; between two sieves the mass is even over log(diameter).

    Parameters
    ----------
    openings : sequence of float
        Openings of the sieves, increasing, m.
    passing_shares : sequence of float
        Share of the mass that passes each, from 0 to 1.

    Raises
    ------
    InputError
        The points are no curve of cumulative passing.
    """

    key: ClassVar[str] = "sieve_curve"

    openings: tuple[float, ...]
    passing_shares: tuple[float, ...]

    def __post_init__(self) -> None:
        for key in ("openings", "passing_shares"):
            given = plain_tuple(getattr(self, key))
            InputError.raise_for(number_list_faults(key, given))
            object.__setattr__(self, key, tuple(map(float, given)))
        found = point_faults(self.openings, self.passing_shares)
        InputError.raise_for(replace(fault, key=f"point {i + 1}") for i, fault in found)

    @property
    def known_between(self) -> tuple[float, float]:
        """The finest and the coarsest opening, m."""
        return self.openings[0], self.openings[-1]

    def passing(self, diameter: float) -> float:
        """Return the share of the mass that is finer than a diameter."""
        at = bisect_left(self.openings, diameter)
        if at == 0 or at == len(self.openings):
            return self.passing_shares[0 if at == 0 else -1]
        low, high = self.openings[at - 1 : at + 1]
        first, last = self.passing_shares[at - 1 : at + 1]
        return first + (last - first) * math.log(diameter / low) / math.log(high / low)

    def quantile(self, share: float) -> float:
        """Return the diameter below which a share of the mass is, m."""
        at = bisect_left(self.passing_shares, share)
        if at == 0 or at == len(self.openings):
            return self.openings[0 if at == 0 else -1]
        low, high = self.openings[at - 1 : at + 1]
        first, last = self.passing_shares[at - 1 : at + 1]
        return float(low * (high / low) ** ((share - first) / (last - first)))

    def moment(self, order: int, low: float, high: float) -> float:
        """Return the integral of d^order over the mass between two diameters."""
        total = 0.0
        points = zip(self.openings, self.passing_shares, strict=True)
        for (a, first), (b, last) in pairwise(points):
            start, end = max(a, low), min(b, high)
            if start < end:
                density = (last - first) / math.log(b / a)
                total += density * _integral_of_power(order, start, end)
        return total

    def __str__(self) -> str:
        return f"sieve curve of {len(self.openings)} openings"


def point_faults(openings: Sequence[float], shares: Sequence[float]) -> Iterator[tuple[int, Fault]]:
    """Yield the position and the fault of each impossible point of a sieve curve.

    Parameters
    ----------
    openings, shares : sequence of float
        Openings, m, and the shares of the mass that pass, in the order of the openings.
    """
    if len(openings) < 2 or len(openings) != len(shares):
        yield 0, messages.NUMBER_OF_SIEVES.fault("", openings=len(openings), shares=len(shares))
        return
    for i, opening in enumerate(openings):
        if not SMALLEST_DIAMETER <= opening <= LARGEST_DIAMETER:
            limits = DIAMETER.limits()
            yield i, messages.IMPOSSIBLE_OPENING.fault("", opening=opening, limits=limits)
        elif not -ROUNDING <= shares[i] <= 1 + ROUNDING:
            yield i, messages.IMPOSSIBLE_PASSING.fault("", share=percent(shares[i]))
        elif i and opening <= openings[i - 1]:
            yield i, messages.NOT_SORTED.fault("")
        elif i and shares[i] < shares[i - 1]:
            yield (
                i,
                messages.FALLING_PASSING.fault(
                    "",
                    share=percent(shares[i]),
                    opening=millimetres(opening),
                    share_below=percent(shares[i - 1]),
                    opening_below=millimetres(openings[i - 1]),
                ),
            )


def resolve_options(given: Any) -> None:
    """Replace the options of a frozen dataclass by their values in SI units."""
    keys = option_keys(type(given))
    for name, value in read_options(keys, {k.name: getattr(given, k.name) for k in keys}).items():
        object.__setattr__(given, name, value)


def _normal_between(low: float, high: float) -> float:
    """Return the probability of a standard normal variable between two values, tails included."""
    if low > 0:
        low, high = -high, -low
    return (math.erfc(-high / math.sqrt(2)) - math.erfc(-low / math.sqrt(2))) / 2


def _upper_gamma(power: float, start: float) -> float:
    """Return the upper incomplete gamma function, of a power that may be below zero."""
    # SciPy takes a second to import.
    from scipy.special import exp1, gamma, gammaincc

    if math.isinf(start):
        return 0.0
    if power > 0:
        return float(gamma(power) * gammaincc(power, start))
    if abs(power) < 1e-8:
        return float(exp1(start))
    return (_upper_gamma(power + 1, start) - math.pow(start, power) * math.exp(-start)) / power


def _integral_of_power(order: int, low: float, high: float) -> float:
    """Return the integral of d^order over log(d)."""
    if order == 0:
        return math.log(high / low)
    return (math.pow(high, order) - math.pow(low, order)) / order
