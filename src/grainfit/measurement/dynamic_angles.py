"""Angles of a bed in a turning drum, averaged over whole avalanches: simulated or photographed."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Generic, Protocol, TypeVar

import numpy as np

from grainfit.arrays import Array
from grainfit.errors import NotMeasurableError
from grainfit.evaluation import Curve, Response
from grainfit.measurement import messages
from grainfit.measurement.angle_of_repose import Flank
from grainfit.measurement.avalanches import Avalanches, whole_avalanches

#: Parts of the surface to which lines are fitted, from the middle over half its length, uphill.
_PARTS: Mapping[str, tuple[float, float]] = {
    "surface_angle": (-0.6, 0.6),
    "upper_angle": (0.0, 0.7),
    "lower_angle": (-0.7, 0.0),
}
_FEWEST_COLUMNS = 3
#: The bed is not steady when its inclination drifts by so much, degrees, and by so many standard
#: errors.
_LARGEST_DRIFT, _DRIFT_ERRORS = 2.0, 3.0


@dataclass(frozen=True)
class Surface:
    """Free surface of the bed, averaged over frames, in a frame of reference turned with the bed.

    Parameters
    ----------
    along : ndarray of shape (n,)
        Coordinate along the mean inclination of the bed, uphill, m.
    heights : ndarray of shape (n,)
        Distance from the axis of the drum, upwards, m.
    inclination : float
        Inclination of the coordinate, degrees.
    """

    along: Array
    heights: Array
    inclination: float

    def line(self, low: float, high: float) -> tuple[float, float]:
        """Fit a line between two coordinates; return its inclination, degrees, and its offset, m.

        Raises
        ------
        NotMeasurableError
            There are too few particles there.
        """
        fitted = (self.along > low) & (self.along < high) & np.isfinite(self.heights)
        if fitted.sum() < _FEWEST_COLUMNS:
            raise NotMeasurableError(messages.SHORT_SURFACE())
        slope, offset = np.polyfit(self.along[fitted], self.heights[fitted], 1)
        return self.inclination + math.degrees(math.atan(slope)), float(offset)

    def places(self) -> list[tuple[float, float]]:
        """Return the points of the surface across and height, m, uphill."""
        turn = math.radians(self.inclination)
        found = np.isfinite(self.heights)
        along, above = self.along[found], self.heights[found]
        across = along * math.cos(turn) - above * math.sin(turn)
        height = along * math.sin(turn) + above * math.cos(turn)
        return [(float(y), float(z)) for y, z in zip(across, height, strict=True)]

    def curve(self) -> Curve:
        """Return the height of the surface over the place across the drum, both from its axis, m.

        Raises
        ------
        NotMeasurableError
            There are too few particles.
        """
        across, heights = np.array(self.places()).reshape(-1, 2).T
        # At its ends a steep surface may hang over: the curve is the part seen from above.
        seen = across > np.maximum.accumulate(np.concatenate([[-math.inf], across[:-1]]))
        if seen.sum() < _FEWEST_COLUMNS:
            raise NotMeasurableError(messages.SHORT_SURFACE())
        return Curve(across[seen].tolist(), heights[seen].tolist())

    def half_length(self, radius: float) -> float:
        """Return half the length of the surface within a drum of this radius, m."""
        middle = float(np.nanmedian(self.heights))
        return math.sqrt(max(radius**2 - middle**2, 0.0))


class Bed(Protocol):
    """A bed in a turning drum, over time."""

    @property
    def radius(self) -> float:
        """Radius of the drum, m."""
        ...

    @property
    def inclinations(self) -> Array:
        """Inclination of the line from the axis to the centre of mass in every frame, degrees."""
        ...

    def surface(self, inclination: float, chosen: slice = slice(None)) -> Surface:
        """Return the free surface, averaged over frames, in a frame of reference so inclined."""
        ...


AnyBed = TypeVar("AnyBed", bound=Bed)


@dataclass(frozen=True)
class DynamicAngles(Generic[AnyBed]):
    """Angles of a bed in a turning drum.

    Parameters
    ----------
    bed : Bed
        The bed over time.
    """

    bed: AnyBed

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

    @property
    def unsteadiness(self) -> float | None:
        """Change from the first to the second half, degrees, of a bed that is not steady."""
        drift = self.avalanches.drift(self.bed.inclinations)
        unsteady = abs(drift.value) > max(_LARGEST_DRIFT, _DRIFT_ERRORS * drift.standard_error)
        return drift.value if unsteady else None

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
        half = self.surface.half_length(self.bed.radius)
        return {name: (low * half, high * half) for name, (low, high) in _PARTS.items()}

    def _flank(self, low: float, high: float) -> Flank:
        angle, offset = self.surface.line(low, high)
        slope = math.tan(math.radians(angle - self.surface.inclination))
        along = np.array([low, high])
        start, end = Surface(along, offset + slope * along, self.surface.inclination).places()
        return Flank(angle, start, end)
