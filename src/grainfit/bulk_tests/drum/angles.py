"""Angles of a turning bed, and whether they mean anything."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

from grainfit.bulk_tests.drum import messages
from grainfit.bulk_tests.drum.bed import TurningBed
from grainfit.errors import RunFailedError
from grainfit.measurement.dynamic_angles import DynamicAngles

#: Largest share of the drum's speed by which the bed may lag behind it.
LARGEST_SLIP = 0.2
#: Largest share of particles above the ends of the bed.
_LARGEST_SHARE_ABOVE = 0.02


@dataclass(frozen=True)
class DrumAngles(DynamicAngles[TurningBed]):
    """Angles of a simulated bed."""

    @cached_property
    def slip(self) -> float:
        """Share of the drum's speed by which the bed lags behind it."""
        return self.bed.slip(self.surface)

    def require_valid(self) -> None:
        """Raise `RunFailedError` unless the bed flows steadily and turns with its drum."""
        above = self.bed.share_above(self.mean)
        if above > _LARGEST_SHARE_ABOVE:
            raise RunFailedError(messages.CARRIED_ROUND(percent=100 * above))
        if self.slip > LARGEST_SLIP:
            raise RunFailedError(
                messages.BED_SLIDES(percent=100 * self.slip, allowed=100 * LARGEST_SLIP)
            )
        change = self.unsteadiness
        if change is not None:
            raise RunFailedError(messages.NOT_STEADY(change=change))
