"""What follows from the options of a test whose bed flows out of an orifice."""

from __future__ import annotations

from functools import cached_property
from typing import ClassVar

from grainfit.bulk_tests.setup import Setup
from grainfit.bulk_tests.shared.filling import Filling, plan_filling
from grainfit.bulk_tests.shared.slot_box import default_length, measured_heights, shortest_flow
from grainfit.bulk_tests.shared.slot_scene import Flow
from grainfit.scenes.packing import Footprint, mean_particle_volume
from grainfit.scenes.scene import natural_time


class FlowSetup(Setup):
    """Geometry and procedure of a bed that flows out of an orifice."""

    #: The particles come to rest this long after the flow has ended, over sqrt(d/g).
    settling: ClassVar[float]
    #: Longest time of a stage over the expected one.
    patience: ClassVar[float]

    def usual(self, name: str, diameters: float) -> float:
        """Return the default of a length of the container, m."""
        return default_length(self.real, name, diameters)

    @property
    def footprint(self) -> Footprint:
        """Cross-section of the container."""
        raise NotImplementedError

    @property
    def beverloo_time(self) -> float:
        """Time in which all particles flow out by Beverloo's law, s."""
        raise NotImplementedError

    @property
    def volume(self) -> float:
        """Volume of all particles, m^3."""
        return float(self.filling.particle_count * mean_particle_volume(self.sizes))

    @property
    def beverloo_flow(self) -> float:
        """Volume of particles that flows out in a second by Beverloo's law, m^3/s."""
        return self.volume / self.beverloo_time

    @property
    def bed_height(self) -> float:
        """Height of the bed before it settles, m."""
        return float(self.fill_height)

    @cached_property
    def filling(self) -> Filling:
        """Particles of the container."""
        return plan_filling(self.sizes, self.footprint, self.bed_height, self.gravity)

    @property
    def density_heights(self) -> tuple[float, float]:
        """Heights between which the bulk density of the bed is measured, m."""
        return measured_heights(self.sizes, self.bed_height)

    @property
    def flow(self) -> Flow:
        """Times of the flow."""
        return Flow(shortest_flow(self.sizes, self.gravity), self.settling_time_limit)

    @cached_property
    def flow_time(self) -> float:
        """Expected time until the particles are at rest again, s."""
        return self.beverloo_time + self.settling_time

    @property
    def settling_time(self) -> float:
        """Expected time from the end of the flow until the particles are at rest, s."""
        return self.settling * natural_time(self.sizes, self.gravity)

    @property
    def usual_limit(self) -> float:
        """Default of the longest time in which the particles may come to rest, s."""
        return self.patience * self.flow_time
