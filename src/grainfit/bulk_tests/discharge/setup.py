"""Geometry and procedure of a discharge: every default resolved, impossible values rejected."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

from grainfit.bulk_tests.discharge.round_container import RoundContainer
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
from grainfit.scenes.packing import Footprint, Rectangle, Round
from grainfit.scenes.scene import natural_time

SLOT, ROUND = "slot", "round"
#: Default lengths, and default diameter of a round orifice, in Sauter diameters; the latter is not
#: smaller than so many of the largest particles.
_LENGTHS = {"width": 16, "depth": 5, "fill_height": 16, "slot_width": 5}
_ORIFICE, _LEAST_ORIFICE = 6, 5.0
#: The particles come to rest this long after the flow has ended, over sqrt(d/g).
_SETTLING = 15.0
#: Longest time of a stage over the expected one.
_PATIENCE = 4.0
#: Thickness of the floor of a box, in diameters.
_THICKNESS = 0.5


@dataclass(frozen=True)
class DischargeSetup:
    """Geometry and procedure of one discharge; lengths in m, times in s.

    Parameters
    ----------
    container : SlotBox or RoundContainer
        The container.
    footprint : Footprint
        Its cross-section.
    filling : Filling
        Its particles.
    density_bottom, density_top : float
        The bulk density is that of the bed between these heights.
    shortest_flow, flow_time : float
        Shortest and expected time until the particles are at rest again.
    settling_time_limit : float
        Longest time in which the particles may come to rest.
    """

    container: SlotBox | RoundContainer
    footprint: Footprint
    filling: Filling
    density_bottom: float
    density_top: float
    shortest_flow: float
    flow_time: float
    settling_time_limit: float

    @property
    def width(self) -> float:
        """Inner width or diameter of the container, m."""
        return 2 * self.half_width

    @property
    def fill_height(self) -> float:
        """Height of the bed before it settles, m."""
        return self.container.fill_height

    @property
    def slot_width(self) -> float | None:
        """Width of the slot, m; None with a round orifice."""
        return self.container.slot_width if isinstance(self.container, SlotBox) else None

    @property
    def depth(self) -> float | None:
        """Period of a slot, m; None with a round orifice."""
        return self.container.depth if isinstance(self.container, SlotBox) else None

    @property
    def orifice_diameter(self) -> float | None:
        """Diameter of a round orifice, m; None with a slot."""
        container = self.container
        return None if isinstance(container, SlotBox) else 2 * container.orifice_radius

    @property
    def underside(self) -> float:
        """Height below which particles have left the container, m."""
        return -self.container.thickness if isinstance(self.container, SlotBox) else 0.0

    @property
    def half_width(self) -> float:
        """Half the inner width of the container, m."""
        container = self.container
        return container.width / 2 if isinstance(container, SlotBox) else container.radius


def plan_setup(sizes: ParticleSizes, options: Mapping[str, Any]) -> DischargeSetup:
    """Resolve every default of a discharge.

    Parameters
    ----------
    sizes : ParticleSizes
        The length scale of all defaults is the Sauter diameter.
    options : mapping of str to float, str or None
        The options of `Discharge`, each within its limits; None stands for the default.

    Raises
    ------
    InputError
        The test is impossible; names every option at fault.
    """
    given = {name: value for name, value in options.items() if value is not None}
    faults = [*_misplaced(given)]
    if faults:
        raise InputError(faults)
    gravity = given["gravity"]
    container, footprint = _container(sizes, given)
    height = container.fill_height
    faults = [*container.faults(sizes)]
    if faults:
        raise InputError(faults)
    filling = plan_filling(sizes, footprint, height, gravity)
    natural = natural_time(sizes, gravity)
    area, opening = _equivalent_slot(container)
    flow = flow_time(sizes, area, opening, gravity) + _SETTLING * natural
    bottom, top = measured_heights(sizes, height)
    setup = DischargeSetup(
        container=container,
        footprint=footprint,
        filling=filling,
        density_bottom=bottom,
        density_top=top,
        shortest_flow=shortest_flow(sizes, gravity),
        flow_time=flow,
        settling_time_limit=given.get("settling_time_limit", _PATIENCE * flow),
    )
    lengths = {"width": setup.width, "depth": setup.depth, "fill_height": height}
    possible = {name: length for name, length in lengths.items() if length is not None}
    faults = [*count_faults(filling.particle_count, possible, count_is_given=False)]
    if faults:
        raise InputError(faults)
    return setup


def _misplaced(given: Mapping[str, Any]) -> Iterator[Fault]:
    """Iterate over options that belong to the other kind of orifice."""
    others = {SLOT: ("orifice_diameter",), ROUND: ("slot_width", "depth")}
    for name in others[given["orifice"]]:
        if name in given:
            other = ROUND if name == "orifice_diameter" else SLOT
            yield Fault(
                name,
                f"{given[name]:g} m belongs to an orifice that is {_article(other)}.",
                f'Leave it out, or set orifice = "{other}".',
            )


def _article(orifice: str) -> str:
    return "a slot" if orifice == SLOT else "round"


def _container(
    sizes: ParticleSizes, given: Mapping[str, Any]
) -> tuple[SlotBox | RoundContainer, Footprint]:
    real = sizes.real
    lengths = {**default_lengths(real, _LENGTHS), **given}
    width, height = lengths["width"], lengths["fill_height"]
    diameter = real.sauter_diameter
    if given["orifice"] == ROUND:
        least = _LEAST_ORIFICE * max(real.diameters)
        orifice = given.get("orifice_diameter", max(_ORIFICE * diameter, least))
        return RoundContainer(width / 2, height, orifice / 2), Round(width / 2)
    depth = lengths["depth"]
    box = SlotBox(width, depth, height, lengths["slot_width"], _THICKNESS * diameter)
    return box, Rectangle(width, depth)


def _equivalent_slot(container: SlotBox | RoundContainer) -> tuple[float, float]:
    """Cross-section of the bed across a slot, and width of the slot, with the same time of flow."""
    if isinstance(container, SlotBox):
        return container.width * container.fill_height, container.slot_width
    # A round orifice is as a slot that is as long as the diameter and 0.6 of it wide (both laws of
    # Beverloo, at orifices much larger than particles).
    volume = math.pi * container.radius**2 * container.fill_height
    return volume / (2 * container.orifice_radius), 1.2 * container.orifice_radius
