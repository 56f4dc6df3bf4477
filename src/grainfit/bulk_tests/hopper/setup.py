"""Geometry and procedure of a hopper: what follows from its options and is possible."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from functools import cached_property

from grainfit.bulk_tests.discharge.setup import DischargeSetup
from grainfit.bulk_tests.hopper import messages
from grainfit.bulk_tests.shared.filling import LOOSE, Filling, plan_filling
from grainfit.bulk_tests.shared.round_container import RoundContainer
from grainfit.bulk_tests.shared.slot_box import LOWEST_BED, SlotBox
from grainfit.errors import Fault

#: Height of the bed above the slope, and width of a round vessel, in Sauter diameters.
_ABOVE_SLOPE, _ROUND_WIDTH, _SLOT_WIDTH = 8.0, 14.0, 16.0
#: Density to estimate the volume of a mass while that of the material is not known, kg/m^3: the
#: time limit that follows from it is enough for particles of a third of it.
_SOME_DENSITY = 1000.0


class HopperSetup(DischargeSetup):
    """Geometry and procedure of a hopper."""

    #: What stays, and how long it takes, is known at rest alone.
    known_share = None

    @property
    def usual_width(self) -> float:
        """Default of the inner width of the vessel, m."""
        return self.usual("width", _ROUND_WIDTH if self.is_round else _SLOT_WIDTH)

    @property
    def usual_height(self) -> float | None:
        """Default of the height of the bed, m; None where its mass is given."""
        if self.fill_mass is not None:
            return None
        return self._empty.slope_top + self.usual("fill_height", _ABOVE_SLOPE)

    @cached_property
    def _empty(self) -> SlotBox | RoundContainer:
        """The vessel, before it is known how high it is filled."""
        return self.vessel(0.0)

    def vessel(self, height: float) -> SlotBox | RoundContainer:
        """Return the vessel, filled up to a height, m."""
        angle, stem = float(self.half_angle), float(self.stem_length)
        return replace(self.flat_container(height), half_angle=angle, stem_length=stem)

    @cached_property
    def container(self) -> SlotBox | RoundContainer:
        """The vessel."""
        return self.vessel(self.bed_height)

    @cached_property
    def bed_height(self) -> float:
        """Height of the bed before it settles, m; of a given mass, that at some density."""
        if self.fill_mass is None:
            return float(self.fill_height)
        return self.height_of(_SOME_DENSITY)

    def height_of(self, density: float) -> float:
        """Return the height up to which the mass that is filled in reaches, m.

        Parameters
        ----------
        density : float
            Of the particles, kg/m^3.
        """
        return self._empty.level(float(self.fill_mass) / (density * LOOSE))

    @property
    def half_box(self) -> float:
        """Half the width of the simulated space that the walls need, m."""
        container = self.container
        if isinstance(container, SlotBox):
            return self.half_width + container.slope_width(self.largest)
        return self.half_width

    @cached_property
    def filling(self) -> Filling:
        """Particles of the vessel, which fall from above its slope."""
        equivalent = self.container.volume(self.bed_height) / self.footprint.area
        planned = plan_filling(self.sizes, self.footprint, equivalent, self.gravity)
        return replace(planned, column_height=planned.column_height + self.container.slope_top)

    @property
    def density_bottom(self) -> float:
        """Height above which the bulk density of the bed is measured, m: over the slope."""
        return self.container.slope_top + self.sizes.sauter_diameter

    def fault_stages(self) -> Iterator[list[Fault]]:
        """Iterate over what is impossible: how it is filled, then the vessel and the particles."""
        if self.is_given("fill_mass") and self.is_given("fill_height"):
            yield [
                messages.FILLED_TWICE.fault(
                    "fill_mass", mass=self.fill_mass, height=self.fill_height
                )
            ]
        for stage in super().fault_stages():
            # How high a mass reaches follows from the material.
            is_by_mass = self.fill_mass is not None
            yield [fault for fault in stage if not (is_by_mass and fault.key == "fill_height")]

    def mass_faults(self, density: float) -> Iterator[Fault]:
        """Iterate over why a mass is too little of particles of a density, kg/m^3."""
        height, least = self.height_of(density), LOWEST_BED * self.largest
        if height < least:
            yield messages.LITTLE_MASS.fault(
                "fill_mass",
                mass=self.fill_mass,
                height=height,
                fewest=LOWEST_BED,
                largest=self.largest,
                least=self._empty.volume(least) * density * LOOSE,
            )
