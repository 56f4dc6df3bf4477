"""Geometry and procedure of a draw-down: what follows from its options and is possible."""

from __future__ import annotations

from collections.abc import Iterator
from functools import cached_property
from typing import ClassVar

from grainfit.bulk_tests.draw_down import messages
from grainfit.bulk_tests.shared.filling import count_faults
from grainfit.bulk_tests.shared.flow_setup import FlowSetup
from grainfit.bulk_tests.shared.slot_box import SlotBox, flow_time
from grainfit.errors import Fault
from grainfit.scenes.packing import Rectangle

#: Distance that the apex of the heap must keep from the shelf, in diameters.
CLEARANCE = 2.0


class DrawDownSetup(FlowSetup):
    """Geometry and procedure of a draw-down."""

    settling: ClassVar[float] = 25.0
    patience: ClassVar[float] = 3.0

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

    @property
    def underside(self) -> float:
        """Height of the underside of the shelf, m; negative."""
        return -self.box.thickness

    @property
    def floor(self) -> float:
        """Height of the lower floor, m; negative."""
        return float(self.underside - self.floor_distance)

    @cached_property
    def beverloo_time(self) -> float:
        """Time in which all particles flow out by Beverloo's law, s."""
        area = self.width * self.fill_height
        return flow_time(self.sizes, area, self.slot_width, self.gravity)

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
