"""The bed of a turning drum over time: its inclination, its surface, and how the drum drags it.

Seen along the axis of the drum: *across* is y, *height* is z, and the bed rises towards positive y.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property
from typing import Self

import numpy as np

from grainfit.arrays import Array
from grainfit.bulk_tests.drum import messages
from grainfit.bulk_tests.drum.setup import DrumSetup
from grainfit.errors import NotMeasurableError, RunFailedError
from grainfit.measurement.dynamic_angles import Surface
from grainfit.measurement.grid import require_grid
from grainfit.measurement.particles import Frame, Particles

#: Cells in which the solid fraction is averaged, in diameters: along the surface, and across it.
_CELL, _LAYER = 0.5, 0.25
#: Layers over which it is smoothed. The surface is where it falls below half that of a bed.
_SMOOTHED, _HALF = 3, 0.29
#: Particles this near to the wall and this deep below the surface, in diameters, move with the
#: wall unless the bed slides.
_OUTER, _DEEP = 1.5, 2.0
#: Particles at this angle from the middle of the bed and more are above its ends, degrees.
_ABOVE = 120.0
_FEWEST_FRAMES = 8


@dataclass(frozen=True)
class TurningBed:
    """Particles of a bed at equal intervals while the drum turns.

    Parameters
    ----------
    setup : DrumSetup
        Geometry and speed.
    last : Particles
        The bed at the end.
    times : ndarray of shape (t,)
        Simulated time of every frame, s.
    across, heights : ndarray of shape (t, n)
        Places of the particles, m.
    """

    setup: DrumSetup
    last: Particles
    times: Array
    across: Array
    heights: Array

    @classmethod
    def of(cls, frames: Iterable[Frame], setup: DrumSetup, time_step: float) -> Self:
        """Read the bed from the frames of a run.

        Parameters
        ----------
        frames : iterable of Frame
            In order.
        setup : DrumSetup
            Geometry and speed.
        time_step : float
            s.

        Raises
        ------
        RunFailedError
            Particles were lost on the way.
        NotMeasurableError
            There are too few frames, or they are damaged.
        """
        read = list(frames)
        counts = {len(frame.particles) for frame in read}
        if len(read) < _FEWEST_FRAMES or counts == {0}:
            raise NotMeasurableError(messages.FEW_FRAMES(count=len(read), fewest=_FEWEST_FRAMES))
        if len(counts) > 1:
            raise RunFailedError(messages.PARTICLES_LOST(first=max(counts), last=min(counts)))
        places = np.array([frame.particles.positions for frame in read])
        times = time_step * np.array([frame.step for frame in read])
        return cls(setup, read[-1].particles, times, places[:, :, 1], places[:, :, 2])

    @property
    def diameter(self) -> float:
        """Median particle diameter, m."""
        return self.last.diameter

    @property
    def radius(self) -> float:
        """Radius of the drum, m."""
        return float(self.setup.drum_radius)

    @property
    def turns(self) -> float:
        """Turns of the drum from the first frame to the last."""
        return float(self.times[-1] - self.times[0]) / self.setup.turn_time

    @cached_property
    def inclinations(self) -> Array:
        """Inclination of the line from the axis to the centre of mass in every frame, degrees.

        It is the inclination of a plane surface.
        """
        masses = self.last.masses
        across, height = self.across @ masses, self.heights @ masses
        found: Array = np.degrees(np.arctan2(across, -height))
        return found

    def surface(self, inclination: float, chosen: slice = slice(None)) -> Surface:
        """Return the free surface, averaged over frames.

        Parameters
        ----------
        inclination : float
            Mean inclination of the bed, degrees.
        chosen : slice
            Frames.
        """
        angle, radius, d = math.radians(inclination), self.setup.drum_radius, self.diameter
        across, heights = self.across[chosen], self.heights[chosen]
        along = across * math.cos(angle) + heights * math.sin(angle)
        above = heights * math.cos(angle) - across * math.sin(angle)
        require_grid(
            "surface of the bed", 2 * radius / (_CELL * d), 2 * (radius + d) / (_LAYER * d)
        )
        cells = 2 * math.ceil(radius / (_CELL * d))
        layers = 2 * math.ceil((radius + d) / (_LAYER * d))
        edges = np.linspace(-cells, cells, cells + 1) * _CELL * d / 2
        levels = np.linspace(-layers, layers, layers + 1) * _LAYER * d / 2
        volumes = np.broadcast_to(self.last.volumes, along.shape)
        filled, *_ = np.histogram2d(
            along.ravel(), above.ravel(), bins=(edges, levels), weights=volumes.ravel()
        )
        cell = _CELL * d * _LAYER * d * self.setup.drum_length * len(along)
        middles = (levels[1:] + levels[:-1]) / 2
        tops = [_top(column / cell, middles) for column in filled]
        return Surface((edges[1:] + edges[:-1]) / 2, np.array(tops), inclination)

    @cached_property
    def _azimuths(self) -> Array:
        """Angle of every particle from the lowest point of the drum, the way it turns, rad."""
        azimuths: Array = np.arctan2(self.across, -self.heights)
        return azimuths

    def slip(self, surface: Surface) -> float:
        """Return the share of the drum's speed by which the outermost layer lags behind it.

        It is averaged over the particles at the wall that are deep below the surface.
        """
        angle = math.radians(surface.inclination)
        above = self.heights * math.cos(angle) - self.across * math.sin(angle)
        deep = above < float(np.nanmedian(surface.heights)) - _DEEP * self.diameter
        distance = np.hypot(self.across, self.heights)
        outer = deep & (distance > self.setup.drum_radius - _OUTER * self.diameter)
        turned = np.diff(self._azimuths, axis=0)
        turned = (turned + math.pi) % (2 * math.pi) - math.pi
        passed = turned / (self.setup.rotational_speed * np.diff(self.times)[:, None])
        counted = outer[:-1] & outer[1:]
        if not counted.any():
            raise NotMeasurableError(messages.NONE_AT_WALL())
        return 1 - float(passed[counted].mean())

    def share_above(self, inclination: float) -> float:
        """Return the mean share of the particles that are above the ends of the bed."""
        apart = np.degrees(self._azimuths) - inclination
        apart = (apart + 180) % 360 - 180
        return float((np.abs(apart) > _ABOVE).mean())


def _top(fractions: Array, middles: Array) -> float:
    """Height at which the solid fraction of a column falls below half that of a bed, m."""
    smooth = np.convolve(fractions, np.ones(_SMOOTHED) / _SMOOTHED, "same")
    filled = np.flatnonzero(smooth > _HALF)
    if not len(filled):
        return math.nan
    last = int(filled[-1])
    if last + 1 == len(smooth):
        return float(middles[last])
    share = (smooth[last] - _HALF) / (smooth[last] - smooth[last + 1])
    return float(middles[last] + share * (middles[last + 1] - middles[last]))
