"""Geometry and procedure of a funnel test: what follows from its options, and is possible."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace
from functools import cached_property

from grainfit.bulk_tests.funnel import messages
from grainfit.bulk_tests.setup import Setup
from grainfit.bulk_tests.shared.filling import Filling, count_faults, plan_filling
from grainfit.bulk_tests.shared.orifice import Orifice
from grainfit.bulk_tests.shared.plate import ON_DISC, cone_radius, expected_foot
from grainfit.errors import Fault
from grainfit.materials.sizes import ParticleSizes
from grainfit.scenes.packing import Round
from grainfit.scenes.scene import natural_time

#: Defaults in Sauter diameters: the poured volume gives 1,500 particles.
_VOLUME, _OUTLET = 1350.0, 5.0
#: Width of the default outlet, in the largest particles.
_LEAST_OUTLET = 4.0
#: Cube of the default radius of the funnel over the poured volume: cone and a little of the tube
#: above it are full at half an angle of 30 degrees.
_FULL = 2.6
#: When it is empty, the default funnel is two diameters above a heap of this angle, degrees. Beads
#: that fall from there all the time flatten the top of the heap, and it has no cone.
_STEEP = 40.0
#: The default plate carries a heap of this angle and two diameters more, degrees.
_FLAT = 12.0
#: Angle up to which the default volume covers a disc, degrees, and what is poured over the volume
#: of that cone.
_COVERED, _SURPLUS = 40.0, 1.3
#: Fewest particles; lowest outlet at the beginning by default and at all, in largest particles.
_FEWEST, _LOWEST_OUTLET, _LEAST_GAP = 200, 4.0, 1.5
#: Beverloo's law of a round orifice: volume of bulk per time, in natural units, is C (D - k)^2.5.
_BEVERLOO_C, _BEVERLOO_K = 0.58, 1.5
#: The heap comes to rest this long after the flow, over sqrt(d/g); the first look at it is after
#: this share of the flow.
_SETTLING, _FIRST_LOOK = 25.0, 0.5
_PATIENCE = 4.0


def cone_volume(radius: float, angle: float) -> float:
    """Return the volume of a cone of a base radius, m, and an inclination, degrees, in m^3."""
    return math.pi / 3 * radius**3 * math.tan(math.radians(angle))


def cone_height(volume: float, angle: float) -> float:
    """Return the height of a cone of a volume, m^3, and an inclination, degrees, in m."""
    return math.tan(math.radians(angle)) * cone_radius(volume, angle)


class FunnelSetup(Setup):
    """Geometry and procedure of a funnel test; heights are above the plate."""

    @property
    def usual_volume(self) -> float:
        """Default of the poured volume, m^3."""
        usual = _VOLUME * self.d**3
        if self.is_disc and self.is_given("plate_radius"):
            usual = _SURPLUS * cone_volume(self.plate_radius, _COVERED)
        return float(usual)

    @property
    def usual_outlet(self) -> float:
        """Default of the diameter of the outlet, m."""
        return max(_OUTLET * self.d, _LEAST_OUTLET * max(self.real.diameters))

    @property
    def usual_radius(self) -> float:
        """Default of the inner radius of the funnel, m."""
        return max((self.poured_volume / _FULL) ** (1 / 3), 0.75 * self.outlet_diameter)

    @property
    def usual_height(self) -> float:
        """Default of the height of the outlet at the beginning, m."""
        at_rest = self.is_given("raise_speed") and self.raise_speed == 0
        return self._height_in_the_end if at_rest else self._lowest_outlet

    @property
    def usual_raise(self) -> float:
        """Default of the speed of the funnel, m/s: no usual heap reaches the outlet."""
        way = max(0.0, self._height_in_the_end - self.funnel_height)
        return way / self._flow_time(self.real)

    @property
    def _lowest_outlet(self) -> float:
        return _LOWEST_OUTLET * max(self.real.diameters)

    @property
    def _height_in_the_end(self) -> float:
        """Height of an outlet that no usual heap reaches, m."""
        apex = self.plate_radius * math.tan(math.radians(_STEEP)) if self.is_disc else math.inf
        height = min(cone_height(self.heap_volume, _STEEP), apex) + 2 * self.d
        return max(height, self._lowest_outlet)

    @property
    def usual_plate(self) -> float:
        """Default of the radius of plate or disc, m."""
        volume = self.poured_volume
        if self.is_disc:
            return cone_radius(volume / _SURPLUS, _COVERED)
        return expected_foot(volume, _FLAT, self.d) + 2 * self.d

    @property
    def is_disc(self) -> bool:
        """Whether the heap covers a disc, off which the surplus falls."""
        return bool(self.base == ON_DISC)

    @property
    def heap_volume(self) -> float:
        """Bulk volume of the heap, m^3: all that is poured."""
        return float(self.poured_volume)

    @property
    def outlet(self) -> Orifice:
        """The outlet of the funnel."""
        return Orifice("outlet_diameter", "an outlet", float(self.outlet_diameter))

    @property
    def cone_bottom(self) -> float:
        """Height of the lower end of the cone before the funnel is raised, m."""
        return float(self.funnel_height + self.stem_length)

    @property
    def cone_top(self) -> float:
        """Height of the upper end of the cone before the funnel is raised, m."""
        widening = self.funnel_radius - self.outlet_diameter / 2
        return float(self.cone_bottom + widening / math.tan(math.radians(self.half_angle)))

    @cached_property
    def filling(self) -> Filling:
        """Particles that are poured: they fall through the cone, too."""
        footprint = Round(float(self.funnel_radius))
        height = self.poured_volume / footprint.area
        filling = plan_filling(self.sizes, footprint, height, self.gravity)
        fall = self.cone_top - self.funnel_height
        return replace(filling, column_height=filling.column_height + fall)

    @property
    def flow_time(self) -> float:
        """Time in which the funnel empties, s."""
        return self._flow_time(self.sizes)

    def _flow_time(self, sizes: ParticleSizes) -> float:
        """Return the time in which the funnel empties by Beverloo's law, s.

        References
        ----------
        Beverloo, Leniger & van de Velde (1961), Chem. Eng. Sci. 15, 260-269.
        """
        diameter = sizes.sauter_diameter
        opening = max(self.outlet_diameter / diameter - _BEVERLOO_K, 0.5)
        rate = _BEVERLOO_C * math.pow(opening, 2.5)
        volume = self.poured_volume / diameter**3
        return float(volume / rate * natural_time(sizes, self.gravity))

    @property
    def shortest_flow(self) -> float:
        """Time before which the heap is not complete, s."""
        fall = math.sqrt(2 * self.funnel_height / self.gravity)
        return float(fall + _FIRST_LOOK * self.flow_time)

    @property
    def pour_time(self) -> float:
        """Expected time from the opening of the funnel until the heap is at rest, s."""
        return self.flow_time + _SETTLING * natural_time(self.sizes, self.gravity)

    @property
    def usual_limit(self) -> float:
        """Default of the longest time in which the particles may come to rest, s."""
        return _PATIENCE * max(self.pour_time, self.filling.fill_time)

    @property
    def highest_raise(self) -> float:
        """Longest way of the funnel, m."""
        return float(self.raise_speed * (self.shortest_flow + self.settling_time_limit))

    def fault_stages(self) -> Iterator[list[Fault]]:
        """Iterate over what is impossible: the funnel, the heap, the number of particles."""
        yield [*self._funnel_faults()]
        yield [*self._heap_faults()]
        volume = {"poured_volume": float(self.poured_volume)}
        yield [*count_faults(self.filling.particle_count, volume, unit="m^3")]

    def _funnel_faults(self) -> Iterator[Fault]:
        largest = self.largest
        yield from self.outlet.passing_faults(self.sizes)
        least = self.outlet_diameter / 2 + largest / 2
        if self.funnel_radius < least:
            yield messages.FUNNEL_IS_NARROW.fault(
                "funnel_radius",
                radius=self.funnel_radius,
                outlet=self.outlet_diameter,
                least=least,
            )
        if self.funnel_height < _LEAST_GAP * largest:
            yield messages.OUTLET_IS_LOW.fault(
                "funnel_height",
                height=self.funnel_height,
                fewest=_LEAST_GAP,
                largest=largest,
                least=_LEAST_GAP * largest,
            )

    def _heap_faults(self) -> Iterator[Fault]:
        count, volume = self.filling.particle_count, float(self.poured_volume)
        if count < _FEWEST:
            yield messages.LITTLE_IS_POURED.fault(
                "poured_volume", volume=volume, count=count, least=volume * _FEWEST / count
            )
        flattest = cone_volume(self.plate_radius, _FLAT)
        if self.is_disc and volume < flattest:
            yield messages.DISC_IS_LARGE.fault(
                "plate_radius",
                volume=volume,
                radius=self.plate_radius,
                angle=_FLAT,
                least=flattest,
            )
