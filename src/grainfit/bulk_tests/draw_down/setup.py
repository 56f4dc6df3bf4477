"""Geometry and procedure of a draw-down: what follows from its options and is possible."""

from __future__ import annotations

from collections.abc import Iterator
from functools import cached_property

from grainfit.bulk_tests.draw_down import messages
from grainfit.bulk_tests.setup import Setup
from grainfit.bulk_tests.shared.filling import Filling, count_faults, plan_filling
from grainfit.bulk_tests.shared.slot_box import (
    SlotBox,
    default_length,
    flow_time,
    measured_heights,
    shortest_flow,
)
from grainfit.bulk_tests.shared.slot_scene import Flow
from grainfit.errors import Fault
from grainfit.scenes.packing import Rectangle
from grainfit.scenes.scene import natural_time

#: The particles come to rest this long after the flow has ended, over sqrt(d/g).
_SETTLING = 25.0
#: Longest time of a stage over the expected one.
_PATIENCE = 3.0
#: Distance that the apex of the heap must keep from the shelf, in diameters.
CLEARANCE = 2.0


class DrawDownSetup(Setup):
    """Geometry and procedure of a draw-down."""

    def usual(self, name: str, diameters: float) -> float:
        """Return the default of a length of the upper box, m."""
        return default_length(self.real, name, diameters)

    @property
    def usual_distance(self) -> float:
        """Default of the distance between shelf and floor, m."""
        return max(14 * self.d, (CLEARANCE + 3) * max(self.real.diameters))

    @property
    def usual_half_width(self) -> float:
        """Default of half the width of the lower floor, m."""
        return max(30 * self.d, 1.2 * self.width)

    @cached_property
    def box(self) -> SlotBox:
        """The upper box, whose floor is the shelf with the slot."""
        return SlotBox(
            width=self.width,
            depth=self.depth,
            fill_height=self.fill_height,
            slot_width=self.slot_width,
            thickness=self.shelf_thickness,
        )

    @property
    def footprint(self) -> Rectangle:
        """Cross-section of the upper box."""
        return Rectangle(self.width, self.depth)

    @cached_property
    def filling(self) -> Filling:
        """Particles of the upper box."""
        return plan_filling(self.sizes, self.footprint, self.fill_height, self.gravity)

    @property
    def density_heights(self) -> tuple[float, float]:
        """Heights between which the bulk density of the bed is measured, m."""
        return measured_heights(self.sizes, self.fill_height)

    @property
    def underside(self) -> float:
        """Height of the underside of the shelf, m; negative."""
        return -self.box.thickness

    @property
    def floor(self) -> float:
        """Height of the lower floor, m; negative."""
        return float(self.underside - self.floor_distance)

    @property
    def flow(self) -> Flow:
        """Times of the flow."""
        return Flow(shortest_flow(self.sizes, self.gravity), self.settling_time_limit)

    @cached_property
    def beverloo_time(self) -> float:
        """Time in which all particles flow out by Beverloo's law, s."""
        area = self.width * self.fill_height
        return flow_time(self.sizes, area, self.slot_width, self.gravity)

    @cached_property
    def flow_time(self) -> float:
        """Expected time until the particles are at rest again, s."""
        return self.beverloo_time + _SETTLING * natural_time(self.sizes, self.gravity)

    @property
    def usual_limit(self) -> float:
        """Default of the longest time in which the particles may come to rest, s."""
        return _PATIENCE * self.flow_time

    def fault_stages(self) -> Iterator[list[Fault]]:
        """Iterate over what is impossible: the upper box, then the floor and the particles."""
        yield [*self.box.faults(self.sizes)]
        boxes = {name: self.option(name) for name in ("width", "depth", "fill_height")}
        yield [*self._floor_faults(), *count_faults(self.filling.particle_count, boxes)]

    def _floor_faults(self) -> Iterator[Fault]:
        distance, needed = self.floor_distance, (CLEARANCE + 3) * self.largest
        if distance < needed:
            yield messages.NO_ROOM_FOR_HEAP.fault(
                "floor_distance", distance=distance, clearance=CLEARANCE, needed=needed
            )
        if self.floor_half_width <= self.width / 2:
            yield messages.FLOOR_IS_NARROW.fault(
                "floor_half_width",
                floor_half_width=self.floor_half_width,
                width=self.width,
                least=1.25 * self.width,
            )
