"""Geometry and procedure of a draw-down: every default resolved, impossible values rejected."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

from grainfit.bulk_tests.shared.filling import Filling, count_faults, plan_filling
from grainfit.bulk_tests.shared.slot_box import (
    SlotBox,
    default_lengths,
    flow_time,
    measured_heights,
    shortest_flow,
)
from grainfit.errors import Fault, InputError
from grainfit.materials.sizes import ParticleSizes
from grainfit.scenes.packing import Rectangle
from grainfit.scenes.scene import natural_time

#: Default lengths of the upper box, in Sauter diameters.
_LENGTHS = {"width": 24, "depth": 8, "fill_height": 10, "slot_width": 5}
#: The particles come to rest this long after the flow has ended, over sqrt(d/g).
_SETTLING = 25.0
#: Longest time of a stage over the expected one.
_PATIENCE = 3.0
#: Distance that the apex of the heap must keep from the shelf, in diameters.
CLEARANCE = 2.0


@dataclass(frozen=True)
class DrawDownSetup:
    """Geometry and procedure of one draw-down; lengths in m, times in s.

    Parameters
    ----------
    box : SlotBox
        The upper box, whose floor is the shelf with the slot.
    filling : Filling
        Its particles.
    floor_distance : float
        Distance from the underside of the shelf to the lower floor.
    floor_half_width : float
        Half the width of the lower floor, whose edges are free.
    density_bottom, density_top : float
        The bulk density is that of the bed between these heights.
    shortest_flow, flow_time : float
        Shortest and expected time until the particles are at rest again.
    settling_time_limit : float
        Longest time in which the particles may come to rest.
    """

    box: SlotBox
    filling: Filling
    floor_distance: float
    floor_half_width: float
    density_bottom: float
    density_top: float
    shortest_flow: float
    flow_time: float
    settling_time_limit: float

    @property
    def width(self) -> float:
        """Inner width of the upper box, m."""
        return self.box.width

    @property
    def depth(self) -> float:
        """Period of the slice, m."""
        return self.box.depth

    @property
    def fill_height(self) -> float:
        """Height of the bed before it settles, m."""
        return self.box.fill_height

    @property
    def slot_width(self) -> float:
        """Width of the slot, m."""
        return self.box.slot_width

    @property
    def shelf_thickness(self) -> float:
        """Thickness of the shelf, m."""
        return self.box.thickness

    @property
    def floor(self) -> float:
        """Height of the lower floor, m; negative."""
        return self.underside - self.floor_distance

    @property
    def footprint(self) -> Rectangle:
        """Cross-section of the upper box."""
        return Rectangle(self.box.width, self.box.depth)

    @property
    def underside(self) -> float:
        """Height of the underside of the shelf, m; negative."""
        return -self.box.thickness


def plan_setup(sizes: ParticleSizes, options: Mapping[str, float | None]) -> DrawDownSetup:
    """Resolve every default of a draw-down.

    Parameters
    ----------
    sizes : ParticleSizes
        The length scale of all defaults is the Sauter diameter.
    options : mapping of str to float or None
        The options of `DrawDown`, each within its limits; None stands for the default.

    Raises
    ------
    InputError
        The test is impossible; names every option at fault.
    """
    given = {name: value for name, value in options.items() if value is not None}
    real, gravity = sizes.real, given["gravity"]
    diameter = real.sauter_diameter
    lengths = {**default_lengths(real, _LENGTHS), **given}
    box = SlotBox(
        width=lengths["width"],
        depth=lengths["depth"],
        fill_height=lengths["fill_height"],
        slot_width=lengths["slot_width"],
        thickness=given.get("shelf_thickness", diameter / 2),
    )
    impossible = [*box.faults(sizes)]
    if impossible:
        raise InputError(impossible)
    filling = plan_filling(sizes, Rectangle(box.width, box.depth), box.fill_height, gravity)
    natural = natural_time(sizes, gravity)
    area = box.width * box.fill_height
    flow = flow_time(sizes, area, box.slot_width, gravity) + _SETTLING * natural
    bottom, top = measured_heights(sizes, box.fill_height)
    setup = DrawDownSetup(
        box=box,
        filling=filling,
        floor_distance=given.get("floor_distance", max(14 * diameter, _least_distance(real))),
        floor_half_width=given.get("floor_half_width", max(30 * diameter, 1.2 * box.width)),
        density_bottom=bottom,
        density_top=top,
        shortest_flow=shortest_flow(sizes, gravity),
        flow_time=flow,
        settling_time_limit=given.get("settling_time_limit", _PATIENCE * flow),
    )
    boxes = {"width": box.width, "depth": box.depth, "fill_height": box.fill_height}
    too_many = count_faults(filling.particle_count, boxes, count_is_given=False)
    faults = [*_faults(setup, sizes), *too_many]
    if faults:
        raise InputError(faults)
    return setup


def _least_distance(sizes: ParticleSizes) -> float:
    """Return the smallest distance between shelf and floor, m."""
    return (CLEARANCE + 3) * max(sizes.diameters)


def _faults(setup: DrawDownSetup, sizes: ParticleSizes) -> Iterator[Fault]:
    distance, needed = setup.floor_distance, _least_distance(sizes)
    if distance < needed:
        yield Fault(
            "floor_distance",
            f"a floor {distance:g} m below the shelf leaves no room for a heap whose apex is "
            f"{CLEARANCE:g} diameters below it.",
            f"Use at least {needed:g} m; 14 diameters are enough for most materials.",
        )
    if setup.floor_half_width <= setup.box.width / 2:
        yield Fault(
            "floor_half_width",
            f"a floor of half width {setup.floor_half_width:g} m is not wider than the box of "
            f"{setup.box.width:g} m.",
            f"Use at least {1.25 * setup.box.width:g} m.",
        )
