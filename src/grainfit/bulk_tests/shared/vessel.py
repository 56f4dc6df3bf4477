"""A vessel with an outlet at z = 0: a stem, a slope or a flat floor, and upright walls above."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Iterator
from itertools import pairwise

from grainfit.bulk_tests.shared import messages
from grainfit.bulk_tests.shared.orifice import Orifice
from grainfit.bulk_tests.view import Outline
from grainfit.errors import Fault
from grainfit.materials.sizes import ParticleSizes
from grainfit.scenes.scene import Wall

#: Half angle of a flat floor, and those of the flattest and the steepest slope, degrees.
FLAT, FLATTEST, STEEPEST = 90.0, 80.0, 5.0
#: Halvings of the interval in which a level is.
_HALVINGS = 60


class Vessel(ABC):
    """Section of a vessel that is round, or a slice of periodic depth; lengths in m.

    Attributes
    ----------
    half_angle : float
        Angle between slope and vertical, degrees; 90 is a flat floor.
    stem_length : float
        Length of the upright stem between outlet and slope; 0 is none.
    """

    half_angle: float
    stem_length: float

    @property
    @abstractmethod
    def half_outlet(self) -> float:
        """Half the inner width of the outlet, or its radius."""

    @property
    @abstractmethod
    def half_width(self) -> float:
        """Half the inner width above the slope, or the radius."""

    @property
    @abstractmethod
    def period(self) -> float | None:
        """Depth of the slice; None of a round vessel."""

    @property
    @abstractmethod
    def underside(self) -> float:
        """Height below which particles have left."""

    @property
    @abstractmethod
    def orifice(self) -> Orifice:
        """The outlet, in diameters of the particles."""

    @property
    def is_flat(self) -> bool:
        """Whether the floor is flat."""
        return self.half_angle == FLAT

    @property
    def slope_top(self) -> float:
        """Height at which slope or floor end at the upright walls."""
        if self.is_flat:
            return self.stem_length
        run = max(self.half_width - self.half_outlet, 0.0)
        return self.stem_length + run / math.tan(math.radians(self.half_angle))

    def section(self, top: float) -> list[tuple[float, float]]:
        """Return half the width and the height of every corner of the inner wall, upwards."""
        outlet, inner = self.half_outlet, self.half_width
        stem = (outlet, self.stem_length)
        return list(dict.fromkeys([(outlet, 0.0), stem, (inner, self.slope_top), (inner, top)]))

    def filled(self, height: float) -> float:
        """Return the volume up to a height above the outlet, m^3; of a slice per depth, m^2."""
        corners = self.section(max(height, self.slope_top))
        return sum(self._between(*pair, height) for pair in pairwise(corners))

    def volume(self, height: float) -> float:
        """Return the volume up to a height above the outlet, m^3."""
        return self.filled(height) * (self.period or 1.0)

    def level(self, volume: float) -> float:
        """Return the height up to which a volume, m^3, fills the vessel."""
        upright = volume / (self._area(self.half_width) * (self.period or 1.0))
        low, high = 0.0, self.slope_top + upright
        for _ in range(_HALVINGS):
            middle = (low + high) / 2
            low, high = (middle, high) if self.volume(middle) < volume else (low, middle)
        return high

    def _area(self, half: float) -> float:
        return math.pi * half**2 if self.period is None else 2 * half

    def _between(
        self, lower: tuple[float, float], upper: tuple[float, float], height: float
    ) -> float:
        """Return what is filled between two corners of the section and below a height."""
        (low, start), (high, end) = lower, upper
        if min(height, end) <= start:
            return 0.0
        rise = min(height, end) - start
        if low == high:
            # Exactly: the time limit of a run, which is part of its identity, follows from it.
            return self._area(low) * rise
        first, last = self._area(low), self._area(low + (high - low) * rise / (end - start))
        middle = math.sqrt(first * last) if self.period is None else (first + last) / 2
        return (first + middle + last) / 3 * rise

    @abstractmethod
    def walls(self, top: float, largest: float) -> dict[str, Wall]:
        """Return the walls by name, up to a height; with the diameter of the largest particles."""

    @abstractmethod
    def outlines(self, top: float) -> list[Outline]:
        """Return the edges up to a height as polylines in space."""

    @abstractmethod
    def faults(self, sizes: ParticleSizes) -> Iterator[Fault]:
        """Iterate over what is impossible about the vessel."""

    def slope_faults(self) -> Iterator[Fault]:
        """Iterate over why a slope is no slope."""
        if not self.is_flat and self.half_angle > FLATTEST:
            yield messages.SLOPE_IS_FLAT.fault(
                "half_angle", half_angle=self.half_angle, flattest=FLATTEST, flat=FLAT
            )
