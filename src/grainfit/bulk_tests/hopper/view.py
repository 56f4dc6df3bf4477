"""Pictures of a hopper: what stays in it, or what was filled in, and the mass in it over time."""

from __future__ import annotations

from dataclasses import dataclass

from grainfit.bulk_tests.discharge.view import DischargeView
from grainfit.measurement.particles import Particles


@dataclass(frozen=True)
class HopperView(DischargeView):
    """The end of one discharge of a hopper.

    Parameters
    ----------
    bed : Particles
        All particles before the outlet was opened. They are drawn if the hopper has run empty.
    """

    bed: Particles

    @property
    def drawn(self) -> Particles:
        """Particles at the end, or at the beginning if none are left."""
        return self.bed if self._is_empty else self.end

    @property
    def drawn_when(self) -> str:
        """When it was as it is drawn, if not at the end: the end of a sentence."""
        return "; it has run empty, and is drawn as it was filled" if self._is_empty else ""

    @property
    def _is_empty(self) -> bool:
        return not (self.end.positions[:, 2] > 0).any()

    @property
    def _height(self) -> float:
        """Height of the bed at the beginning, m: it follows from the mass that was filled in."""
        return float((self.bed.positions[:, 2] + self.bed.radii).max())
