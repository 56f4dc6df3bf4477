"""Angles of a turning bed, averaged over whole avalanches, and whether they mean anything."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from grainfit.bulk_tests.drum.bed import Surface, TurningBed
from grainfit.errors import RunFailedError
from grainfit.evaluation import Response
from grainfit.measurement.angle_of_repose import Flank
from grainfit.measurement.avalanches import Avalanches, whole_avalanches

#: Parts of the surface to which lines are fitted, from the middle over half its length, uphill.
_PARTS: Mapping[str, tuple[float, float]] = {
    "surface_angle": (-0.6, 0.6),
    "upper_angle": (0.0, 0.7),
    "lower_angle": (-0.7, 0.0),
}
#: Largest share of the drum's speed by which the bed may lag behind it.
LARGEST_SLIP = 0.2
#: Largest share of particles above the ends of the bed.
_LARGEST_SHARE_ABOVE = 0.02
#: The bed is not steady when its inclination drifts by so much, degrees, and by so many standard
#: errors.
_LARGEST_DRIFT, _DRIFT_ERRORS = 2.0, 3.0


@dataclass(frozen=True)
class DrumAngles:
    """Angles of a bed in a turning drum.

    Parameters
    ----------
    bed : TurningBed
        The bed over time.
    """

    bed: TurningBed

    @cached_property
    def avalanches(self) -> Avalanches:
        """Whole avalanches of the inclination.

        Raises
        ------
        NotMeasurableError
            There are too few.
        """
        return whole_avalanches(self.bed.inclinations)

    @cached_property
    def mean(self) -> float:
        """Mean inclination of the bed by its centre of mass, degrees."""
        return float(self.bed.inclinations.mean())

    @cached_property
    def surface(self) -> Surface:
        """Mean free surface."""
        return self.bed.surface(self.mean)

    @cached_property
    def slip(self) -> float:
        """Share of the drum's speed by which the bed lags behind it."""
        return self.bed.slip(self.surface)

    def responses(self) -> dict[str, Response]:
        """Return all angles with their standard errors, degrees.

        Raises
        ------
        NotMeasurableError
            There are too few whole avalanches, or the surface cannot be fitted.
        """
        avalanches = self.avalanches
        means = avalanches.means(self.bed.inclinations)
        found = {"dynamic_angle": Response(self.mean, avalanches.standard_error(means))}
        surfaces = [self.bed.surface(self.mean, part) for part in avalanches.parts]
        for name, ends in self._parts().items():
            each = np.array([surface.line(*ends)[0] for surface in surfaces])
            value = self.surface.line(*ends)[0]
            found[name] = Response(value, avalanches.standard_error(each))
        return found

    def flanks(self) -> dict[str, Flank]:
        """Return lines at the angles along the surface, by response, across and height, m."""
        fitted = {name: self._flank(*ends) for name, ends in self._parts().items()}
        return {"dynamic_angle": self._through_middle(), **fitted}

    def _through_middle(self) -> Flank:
        """Return a line at the dynamic angle through the middle of the surface."""
        low, high = self._parts()["surface_angle"]
        _, offset = self.surface.line(low, high)
        flat = Surface(np.array([low, high]), np.full(2, offset), self.surface.inclination)
        start, end = flat.places()
        return Flank(self.surface.inclination, start, end)

    def _parts(self) -> dict[str, tuple[float, float]]:
        half = self.surface.half_length(self.bed.setup.drum_radius)
        return {name: (low * half, high * half) for name, (low, high) in _PARTS.items()}

    def _flank(self, low: float, high: float) -> Flank:
        angle, offset = self.surface.line(low, high)
        slope = math.tan(math.radians(angle - self.surface.inclination))
        along = np.array([low, high])
        start, end = Surface(along, offset + slope * along, self.surface.inclination).places()
        return Flank(angle, start, end)

    def require_valid(self) -> None:
        """Raise `RunFailedError` unless the bed flows steadily and turns with its drum."""
        above = self.bed.share_above(self.mean)
        if above > _LARGEST_SHARE_ABOVE:
            raise RunFailedError(
                f"the drum carries the particles round: {100 * above:.0f} % of them are above the "
                "ends of the bed, which has no surface then; use a lower rotational_speed"
            )
        if self.slip > LARGEST_SLIP:
            raise RunFailedError(
                f"the bed slides in the drum: its outermost layer is {100 * self.slip:.0f} % "
                f"slower than the wall, and {100 * LARGEST_SLIP:.0f} % are allowed; line the drum "
                "(lining = true), or use a larger friction between particles and wall"
            )
        drift = self.avalanches.drift(self.bed.inclinations)
        if abs(drift.value) > max(_LARGEST_DRIFT, _DRIFT_ERRORS * drift.standard_error):
            raise RunFailedError(
                f"the bed is not steady: its inclination changes by {drift.value:.1f} degrees from "
                "the first to the second half of the averaged turns; use larger discarded_turns"
            )
