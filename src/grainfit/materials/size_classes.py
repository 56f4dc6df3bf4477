"""Division of a distribution of particle sizes into a few diameters.

A class is a bin of the distribution, of equal mass for all classes, and its diameter is the Sauter
diameter of the bin: 1 / d is the mean of 1 / d over the mass. So mass and specific surface,
6 / (density d32), are exact with any number of classes. `docs/developers/evidence.md` shows what
the other moments lose, and `docs/developers/decisions.md` why it is not a Gauss quadrature.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import pairwise

from grainfit.errors import Fault, InputError
from grainfit.formatting import counted, in_a_row, millimetres, percent
from grainfit.materials import messages
from grainfit.materials.size_distributions import (
    DIAMETER,
    ROUNDING,
    SizeDistribution,
    resolve_options,
)
from grainfit.materials.sizes import LARGEST_DIAMETER, SMALLEST_DIAMETER, ParticleSizes
from grainfit.options.fields import Amount, option
from grainfit.options.kinds import Whole

#: Number of classes by default, and at most: each is an atom type in some solvers.
CLASSES, MOST_CLASSES = 5, 20
#: Least share of the mass that a truncation may leave.
_LEAST_LEFT = 0.01
_FAR_ENDS = {"smallest": "finest", "largest": "coarsest"}


@dataclass(frozen=True)
class Truncation:
    """Choice of classes: how many, and between which diameters.

    Parameters
    ----------
    classes : int
        Number of classes, each of the same mass.
    smallest, largest : float, str, optional
        Diameters between which the distribution is kept, m.
    """

    classes: int = option(
        Whole(1, MOST_CLASSES),
        "Number of diameters that stand for the distribution, each of the same mass.",
        example=f"{CLASSES}",
        default=CLASSES,
    )
    smallest: Amount | None = option(
        DIAMETER,
        "What is finer is left out.",
        example='"1.6 mm"',
        default_text="nothing is left out",
    )
    largest: Amount | None = option(
        DIAMETER,
        "What is coarser is left out.",
        example='"7 mm"',
        default_text="nothing is left out",
    )

    def __post_init__(self) -> None:
        resolve_options(self)
        low, high = self.limits
        if low >= high:
            ends = {"low": millimetres(low), "high": millimetres(high)}
            raise InputError(messages.LIMITS_SWAPPED.fault("smallest", **ends))

    @property
    def limits(self) -> tuple[float, float]:
        """Diameters between which the distribution is kept, m."""
        low = 0.0 if self.smallest is None else float(self.smallest)
        return low, math.inf if self.largest is None else float(self.largest)


def divide_into_classes(
    distribution: SizeDistribution,
    classes: int = CLASSES,
    *,
    smallest: Amount | None = None,
    largest: Amount | None = None,
) -> ParticleSizes:
    """Return a few diameters of equal mass that stand for a distribution.

    Mass and specific surface, and so the Sauter diameter, are those of the distribution.

    Parameters
    ----------
    distribution : SizeDistribution
        `LogNormal`, `RosinRammler` or `SieveCurve`.
    classes : int
        Number of diameters.
    smallest, largest : float or str, optional
        What is finer or coarser is left out, m or with a unit.

    Raises
    ------
    InputError
        The limits leave less than 1 % of the mass, or the classes are no particle sizes.

    Examples
    --------
    >>> from grainfit.materials.size_distributions import LogNormal
    >>> beads = LogNormal(median="3 mm", geometric_standard_deviation=1.4)
    >>> [round(1000 * diameter, 2) for diameter in divide_into_classes(beads, 3).diameters]
    [2.04, 2.99, 4.27]
    """
    return divide(distribution, Truncation(classes=classes, smallest=smallest, largest=largest))


def divide(distribution: SizeDistribution, truncation: Truncation) -> ParticleSizes:
    """Return the classes of a distribution, see `divide_into_classes`."""
    InputError.raise_for(_open_ends(distribution, truncation))
    division = Division(distribution, truncation)
    if division.mass < _LEAST_LEFT:
        key = "largest" if truncation.smallest is None else "smallest"
        left = percent(division.mass)
        raise InputError(messages.NOTHING_LEFT.fault(key, left=left, distribution=distribution))
    share = division.mass / truncation.classes
    # 0 where the surface of the finest class is infinite.
    diameters = [share / distribution.moment(-1, *ends) for ends in pairwise(division.edges())]
    for key, diameter in (("smallest", diameters[0]), ("largest", diameters[-1])):
        if not SMALLEST_DIAMETER <= diameter <= LARGEST_DIAMETER:
            end = {"distribution": distribution, "end": _FAR_ENDS[key], "key": key}
            if diameter == 0:
                raise InputError(messages.INFINITE_SURFACE.fault(key, **end))
            raise InputError(messages.IMPOSSIBLE_CLASS.fault(key, diameter=diameter, **end))
    fractions = (1 / len(diameters),) * len(diameters)
    return ParticleSizes(tuple(diameters), fractions, origin=division)


def _open_ends(distribution: SizeDistribution, truncation: Truncation) -> Iterator[Fault]:
    """Yield a fault for each end at which nothing says how fine or coarse the particles are."""
    (low, high), (finest, coarsest) = truncation.limits, distribution.known_between
    finer, coarser = distribution.passing(finest), 1 - distribution.passing(coarsest)
    if finer > ROUNDING and low < finest:
        yield messages.OPEN_FINE_END.fault(
            "", share=percent(finer), opening=millimetres(finest), limit=1000 * finest
        )
    if coarser > ROUNDING and high > coarsest:
        yield messages.OPEN_COARSE_END.fault(
            "", share=percent(1 - coarser), opening=millimetres(coarsest), limit=1000 * coarsest
        )


@dataclass(frozen=True)
class Division:
    """Origin of particle sizes: the distribution that was divided, and how.

    Parameters
    ----------
    distribution : SizeDistribution
        Continuous distribution.
    truncation : Truncation
        Number of classes, and limits.
    """

    distribution: SizeDistribution
    truncation: Truncation

    @property
    def kept(self) -> tuple[float, float]:
        """Shares of the mass that are finer than the limits."""
        low, high = self.truncation.limits
        return self.distribution.passing(low), self.distribution.passing(high)

    @property
    def mass(self) -> float:
        """Share of the mass between the limits."""
        return self.kept[1] - self.kept[0]

    @property
    def is_cut_below(self) -> bool:
        """Whether the finest particles are left out already."""
        return self.kept[0] > ROUNDING

    def edges(self) -> list[float]:
        """Return the diameters between the classes, those of the ends included, m."""
        (low, high), count = self.truncation.limits, self.truncation.classes
        shares = [self.kept[0] + self.mass * i / count for i in range(1, count)]
        return [low, *map(self.distribution.quantile, shares), high]

    def describe(self, sizes: ParticleSizes) -> Iterator[str]:
        """Yield the distribution in words, what the classes change, and what is left out."""
        sizes = sizes.real
        count = self.truncation.classes
        shown = ", ".join(f"{1000 * diameter:.3g}" for diameter in sizes.diameters)
        yield (
            f"Particle sizes: {self.distribution}, as {counted(count, 'diameter')} of "
            f"{percent(1 / count)} of the mass: {shown} mm. Sauter diameter "
            f"{millimetres(sizes.sauter_diameter)}."
        )
        yield f"  These classes keep mass and surface, and change {self._changes(sizes)}."
        left_out = [
            f"the {word} {percent(share)}"
            for word, share in (("finest", self.kept[0]), ("coarsest", 1 - self.kept[1]))
            if share > ROUNDING
        ]
        if left_out:
            yield f"  {in_a_row(left_out).capitalize()} of the mass are left out."

    def _changes(self, sizes: ParticleSizes) -> str:
        words = []
        for name, order in (("the mean diameter by mass", 1), ("the number of particles", -3)):
            mean = self.distribution.moment(order, *self.truncation.limits) / self.mass
            change = f"by {100 * (sizes.mass_moment(order) / mean - 1):+.1f} %"
            words.append(f"{name} {change if math.isfinite(mean) else 'from infinity'}")
        return " and ".join(words)

    def without_finest(self, share: float) -> tuple[float, ParticleSizes]:
        """Return the classes without the finest share of the mass, and the limit, m.

        The limit has the three digits that are shown.
        """
        limit = float(f"{self.distribution.quantile(self.kept[0] + share * self.mass):.3g}")
        truncation = replace(self.truncation, smallest=limit)
        return limit, divide(self.distribution, truncation)
