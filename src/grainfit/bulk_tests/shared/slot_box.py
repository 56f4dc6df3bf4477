"""A box that is periodic in y, filled with a bed, with a slot in its floor that a door closes.

The upper side of a flat floor without a stem is at z = 0, as the outlet of all others, and the slot
is at x = 0. All walls are blocks and prisms that are met from outside, so that the edges of the
slot are exact in every solver.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

from grainfit.bulk_tests.shared import messages
from grainfit.bulk_tests.shared.orifice import ARCHES, Orifice
from grainfit.bulk_tests.shared.vessel import FLAT, Vessel
from grainfit.bulk_tests.view import Outline
from grainfit.errors import Fault
from grainfit.materials.sizes import ParticleSizes
from grainfit.scenes.scene import Wall, natural_time
from grainfit.scenes.shapes import Block, Prism

#: Narrowest container and shortest period, in diameters of the largest particles: a shorter period
#: lets a particle touch its own neighbours on both sides.
_NARROWEST, _SHORTEST_PERIOD = 6.0, 4.0
#: Lowest bed, in diameters of the largest particles.
LOWEST_BED = 4.0
_LEAST = {
    "width": _NARROWEST,
    "depth": _SHORTEST_PERIOD,
    "fill_height": LOWEST_BED,
    "slot_width": ARCHES,
}
#: Thickness of the side walls, in diameters of the largest particles.
_SIDE = 2.0
#: Shortest time of the flow stage, over sqrt(d/g): before, the particles have hardly moved.
_SHORTEST_FLOW = 8.0
#: The bulk density is that between these heights, in diameters and as a share of the fill height:
#: the first layer is left out, and the surface.
_LOWEST, _HIGHEST = 1.0, 0.7
#: Beverloo's law for a slot, in natural units: volume of bulk per depth and time is C (W - k)^1.5.
_BEVERLOO_C, _BEVERLOO_K = 0.88, 1.64


def shortest_flow(sizes: ParticleSizes, gravity: float) -> float:
    """Return the time before which no flow is over, s, at a gravity, m/s^2."""
    return _SHORTEST_FLOW * natural_time(sizes, gravity)


def measured_heights(sizes: ParticleSizes, fill_height: float) -> tuple[float, float]:
    """Return the heights between which the bulk density of a bed is measured, m."""
    return _LOWEST * sizes.sauter_diameter, _HIGHEST * fill_height


def flow_time(sizes: ParticleSizes, area: float, slot: float, gravity: float) -> float:
    """Estimate how long a bed flows out of a slot by Beverloo's law, s.

    Parameters
    ----------
    sizes : ParticleSizes
        Particle size distribution.
    area : float
        Cross-section of the bed across the slot, m^2.
    slot : float
        Width of the slot, m.
    gravity : float
        m/s^2.

    References
    ----------
    Beverloo, Leniger & van de Velde (1961), Chem. Eng. Sci. 15, 260-269.
    """
    diameter = sizes.sauter_diameter
    opening = max(slot / diameter - _BEVERLOO_K, 0.5)
    rate = _BEVERLOO_C * math.sqrt(opening) ** 3
    return area / diameter**2 / rate * natural_time(sizes, gravity)


@dataclass(frozen=True)
class SlotBox(Vessel):
    """Geometry of a box with a slot in its floor; lengths in m.

    Parameters
    ----------
    width, depth : float
        Inner width along x, and period along y.
    fill_height : float
        Height of the bed before it settles.
    slot_width : float
        Width of the slot.
    thickness : float
        Thickness of a flat floor without a stem.
    half_angle : float
        Angle between the slopes and the vertical, degrees; 90 is a flat floor.
    stem_length : float
        Length of the upright walls between slot and slopes.
    """

    width: float
    depth: float
    fill_height: float
    slot_width: float
    thickness: float
    half_angle: float = FLAT
    stem_length: float = 0.0

    @property
    def half_outlet(self) -> float:
        """Half the width of the slot, m."""
        return self.slot_width / 2

    @property
    def half_width(self) -> float:
        """Half the inner width, m."""
        return self.width / 2

    @property
    def period(self) -> float:
        """Depth of the slice, m."""
        return self.depth

    @property
    def underside(self) -> float:
        """Height below which particles have left, m."""
        return -self.thickness if self.is_flat and not self.stem_length else 0.0

    @property
    def orifice(self) -> Orifice:
        """The slot."""
        return Orifice("slot_width", "a slot", self.slot_width)

    def walls(self, top: float, largest: float) -> dict[str, Wall]:
        """Return sides, floor and door of the box by name.

        Parameters
        ----------
        top : float
            Height of the side walls, m.
        largest : float
            Diameter of the largest particles, m.
        """
        inner, slot = self.half_width, self.half_outlet
        side, stem, slope_top = _SIDE * largest, self.stem_length, self.slope_top
        outer, low = inner + side, self.underside
        walls = {
            "left": self._block(-outer, -inner, low if self.is_flat else slope_top, top),
            "right": self._block(inner, outer, low if self.is_flat else slope_top, top),
        }
        if self.is_flat:
            walls["left_shelf"] = self._block(-outer, -slot, low, stem)
            walls["right_shelf"] = self._block(slot, outer, low, stem)
        else:
            walls["left_shelf"] = self._slope(-1, self.slope_width(largest))
            walls["right_shelf"] = self._slope(1, self.slope_width(largest))
            if stem:
                walls["left_stem"] = self._block(-slot - side, -slot, 0.0, stem)
                walls["right_stem"] = self._block(slot, slot + side, 0.0, stem)
        return {**walls, "door": self._block(-slot, slot, -self.thickness, 0.0)}

    def slope_width(self, largest: float) -> float:
        """Return the width of a slope along x, m: as thick as a side wall across; 0 without one."""
        return 0.0 if self.is_flat else _SIDE * largest / math.cos(math.radians(self.half_angle))

    def _block(self, left: float, right: float, low: float, high: float) -> Wall:
        return Wall(Block((left, 0.0, low), (right, self.depth, high)))

    def _slope(self, side: int, width: float) -> Wall:
        """Return the slope on a side, from the slot to the upright wall."""
        slot = side * self.half_outlet
        left, right = sorted((slot, slot + side * width))
        low, high = self.stem_length, self.slope_top
        shift = side * (self.half_width - self.half_outlet)
        return Wall(Prism((left, 0.0, low), (right, self.depth, high), shift))

    def outlines(self, top: float) -> list[Outline]:
        """Return the edges of the walls at both ends of the depth as polylines in space, m."""
        corners = self.section(top)
        if self.underside < 0:
            slot = self.half_outlet
            corners = [(self.half_width, self.underside), (slot, self.underside), *corners]
        lines: list[Outline] = [
            [(side * x, y, z) for x, z in reversed(corners)]
            for y in (0.0, self.depth)
            for side in (-1, 1)
        ]
        along = dict.fromkeys((x, z) for x, z in corners if 0 <= z <= self.slope_top)
        for side in (-1, 1):
            lines += [[(side * x, y, z) for y in (0.0, self.depth)] for x, z in along]
        return lines

    def faults(self, sizes: ParticleSizes) -> Iterator[Fault]:
        """Iterate over what is impossible about the box."""
        largest = max(sizes.diameters)
        if self.slot_width >= self.width:
            yield messages.SLOT_IS_WIDE.fault(
                "slot_width", slot_width=self.slot_width, width=self.width
            )
        yield from self.orifice.passing_faults(sizes)
        if self.depth < _SHORTEST_PERIOD * largest:
            yield messages.BOX_IS_SHORT.fault(
                "depth",
                depth=self.depth,
                fewest=_SHORTEST_PERIOD,
                largest=largest,
                least=_SHORTEST_PERIOD * largest,
            )
        yield from self.slope_faults()
        yield from container_faults(sizes, self.width, self.fill_height)


def default_length(sizes: ParticleSizes, name: str, diameters: float) -> float:
    """Return the default of a length of a container, m: at least what large particles need."""
    return max(diameters * sizes.sauter_diameter, _LEAST[name] * max(sizes.diameters))


def container_faults(sizes: ParticleSizes, width: float, fill_height: float) -> Iterator[Fault]:
    """Iterate over what is impossible about the size of a container.

    Parameters
    ----------
    sizes : ParticleSizes
        Particle size distribution.
    width, fill_height : float
        Options ``width`` and ``fill_height``, m.
    """
    largest = max(sizes.diameters)
    if width < _NARROWEST * largest:
        yield messages.CONTAINER_IS_NARROW.fault(
            "width", width=width, fewest=_NARROWEST, largest=largest, least=_NARROWEST * largest
        )
    if fill_height < LOWEST_BED * largest:
        yield messages.BED_IS_LOW.fault(
            "fill_height",
            fill_height=fill_height,
            fewest=LOWEST_BED,
            largest=largest,
            least=LOWEST_BED * largest,
        )
