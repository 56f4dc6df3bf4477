"""Geometry and procedure of a discharge: what follows from its options and is possible."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace
from functools import cached_property
from typing import ClassVar

from grainfit.bulk_tests.discharge import messages
from grainfit.bulk_tests.shared.filling import LOOSE, count_faults
from grainfit.bulk_tests.shared.flow_setup import FlowSetup
from grainfit.bulk_tests.shared.round_container import RoundContainer
from grainfit.bulk_tests.shared.slot_box import SlotBox, flow_time
from grainfit.bulk_tests.shared.slot_scene import Flow
from grainfit.bulk_tests.shared.vessel import Vessel
from grainfit.errors import Fault
from grainfit.scenes.packing import Footprint, Rectangle, Round

SLOT, ROUND = "slot", "round"
#: Ends of the flow: once it is measured, or once all is at rest.
MEASURED, AT_REST = "measured", "rest"
#: Share of the mass that flows out of a container until its flow is known: it is measured up to a
#: half.
_KNOWN = 0.55
#: Default diameter of a round orifice, in Sauter diameters; it is not smaller than so many of the
#: largest particles.
_ORIFICE, _LEAST_ORIFICE = 6, 5.0
#: Width over which outlets, round ones and slots, become no narrower, in Sauter diameters: of 11
#: runs with a round one of 6, one arched.
_OPEN_ORIFICE, _OPEN_SLOT = 8.0, 6.5
#: Beverloo's law: an outlet counts narrower by so many diameters.
_EMPTY_RIM = 1.5
#: The same of a round one with his own constants, and the least opening that flows, in diameters.
_BEVERLOO_C, _BEVERLOO_K, _LEAST_OPENING = 0.58, 1.4, 0.5
#: Options of the other kind of orifice.
_MISPLACED = {SLOT: ("orifice_diameter",), ROUND: ("slot_width", "depth")}
#: Thickness of the floor of a box, in diameters.
_THICKNESS = 0.5


class DischargeSetup(FlowSetup):
    """Geometry and procedure of a discharge."""

    settling: ClassVar[float] = 15.0
    patience: ClassVar[float] = 4.0

    @property
    def is_round(self) -> bool:
        """Whether the container is a cylinder with a round orifice."""
        return bool(self.orifice == ROUND)

    def of_slot(self, name: str, diameters: float) -> float | None:
        """Return the default of a length that only a container with a slot has, m."""
        return None if self.is_round else self.usual(name, diameters)

    @property
    def usual_orifice(self) -> float | None:
        """Default of the diameter of a round orifice, m."""
        least = _LEAST_ORIFICE * max(self.real.diameters)
        return max(_ORIFICE * self.d, least) if self.is_round else None

    @property
    def width(self) -> float:
        """Inner width or diameter of the container, m."""
        # The identity of a run has it as a number with a point, however it was given.
        return float(self.option("width"))

    @property
    def orifice_diameter(self) -> float | None:
        """Diameter of a round orifice, m; None with a slot."""
        given = self.option("orifice_diameter")
        return None if given is None else float(given)

    def outlet_at(self, scale: float) -> dict[str, float]:
        """Return the option of the outlet in a vessel that is so many times as large.

        Parameters
        ----------
        scale : float
            Size of the vessel over the present one.
        """
        name = "orifice_diameter" if self.is_round else "slot_width"
        open_ = self.d * (_OPEN_ORIFICE if self.is_round else _OPEN_SLOT)
        width = 2 * self.container.half_outlet
        return {name: min(width, max(open_, scale * width))}

    @property
    def outlet_flow(self) -> float:
        """Flow of the outlet by Beverloo's law, in natural units.

        Of a round outlet (D - 1.5)^2.5, of a slot its depth times (W - 1.5)^1.5, all over d.
        """
        container = self.container
        effective = 2 * container.half_outlet / self.d - _EMPTY_RIM
        if container.period is None:
            return float(effective**2.5)
        return float(container.period / self.d * effective**1.5)

    @property
    def half_width(self) -> float:
        """Half the inner width of the container, m."""
        return self.width / 2

    @property
    def half_box(self) -> float:
        """Half the width of the simulated space that the walls need, m."""
        return self.half_width

    @cached_property
    def container(self) -> SlotBox | RoundContainer:
        """The container."""
        return self.flat_container(self.bed_height)

    def flat_container(self, height: float) -> SlotBox | RoundContainer:
        """Return the container with a flat floor, filled up to a height, m."""
        if self.orifice_diameter is not None:
            return RoundContainer(self.half_width, height, self.orifice_diameter / 2)
        return SlotBox(self.width, self.depth, height, self.slot_width, _THICKNESS * self.d)

    @property
    def footprint(self) -> Footprint:
        """Cross-section of the container."""
        return Round(self.half_width) if self.is_round else Rectangle(self.width, self.depth)

    @property
    def flow(self) -> Flow:
        """Times of the flow, and its end."""
        return replace(super().flow, share=self.known_share)

    @property
    def known_share(self) -> float | None:
        """Share of the mass with which the flow ends; None where it ends at rest."""
        return _KNOWN if self.flow_until == MEASURED else None

    @property
    def time_to_end(self) -> float:
        """Expected time from the opening of the orifice to the end of the run, s."""
        emptying = self.volume / self.beverloo_flow
        if self.known_share is not None:
            return self.known_share * emptying
        return emptying + self.settling_time

    @property
    def underside(self) -> float:
        """Height below which particles have left the container, m."""
        return self.container.underside

    @property
    def beverloo_flow(self) -> float:
        """Volume of particles that flows out in a second by Beverloo's law, m^3/s.

        That of a round orifice is 0.58 sqrt(g) (D - 1.4 d)^2.5 of a loose bed.

        References
        ----------
        Beverloo, Leniger & van de Velde (1961), Chem. Eng. Sci. 15, 260-269.
        """
        if self.orifice_diameter is None:
            return super().beverloo_flow
        opening = max(self.orifice_diameter / self.d - _BEVERLOO_K, _LEAST_OPENING) * self.d
        return float(_BEVERLOO_C * LOOSE * math.sqrt(self.gravity) * opening**2.5)

    @cached_property
    def beverloo_time(self) -> float:
        """Time in which all particles flow out, s, by which time limits are set.

        That of a round orifice is longer than `beverloo_flow` has it: limits are part of what
        identifies a run.
        """
        area, opening = _equivalent_slot(self.container, self.bed_height)
        return flow_time(self.sizes, area, opening, self.gravity)

    def fault_stages(self) -> Iterator[list[Fault]]:
        """Iterate over what is impossible: options, the container, the number of particles."""
        yield [*self._misplaced()]
        yield [*self.container.faults(self.sizes)]
        lengths = {"width": self.width, "depth": self.depth, "fill_height": self.fill_height}
        possible = {name: length for name, length in lengths.items() if length is not None}
        yield [*count_faults(self.filling.particle_count, possible)]

    def _misplaced(self) -> Iterator[Fault]:
        """Iterate over options that belong to the other kind of orifice."""
        for name in filter(self.is_given, _MISPLACED[self.orifice]):
            other = SLOT if self.is_round else ROUND
            yield messages.OTHER_ORIFICE.fault(
                name, value=self.option(name), other_kind=_article(other), other=other
            )


def _article(orifice: str) -> str:
    return "a slot" if orifice == SLOT else "round"


def _equivalent_slot(container: Vessel, height: float) -> tuple[float, float]:
    """Cross-section of the bed across a slot, and width of the slot, with the same time of flow."""
    filled = container.filled(height)
    if container.period is not None:
        return filled, 2 * container.half_outlet
    # A round orifice is as a slot that is as long as the diameter and 0.6 of it wide (both laws of
    # Beverloo, at orifices much larger than particles).
    return filled / (2 * container.half_outlet), 1.2 * container.half_outlet
