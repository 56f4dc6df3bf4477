"""View of a run of a bulk test in a report."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import ClassVar, Protocol, Self, runtime_checkable

import numpy as np

from grainfit.arrays import Array
from grainfit.evaluation import Curve, Measured
from grainfit.measurement.angle_of_repose import Flank
from grainfit.measurement.drawing import Drawing
from grainfit.measurement.particles import Particles
from grainfit.scenes.run_output import RunOutput

#: A polyline in space, m.
Outline = Sequence[tuple[float, float, float]]
_CORNERS = 60


@dataclass(frozen=True)
class Shown:
    """Files and response of a bulk test that a report shows.

    Parameters
    ----------
    noun : str
        What the particles form at the end, such as ``"heap"``.
    response : str
        The response to show; empty for the first one of a run.
    particles : str
        File of the particles at the end.
    picture : str
        PNG file, kept when the particles are not.
    """

    noun: str
    response: str
    particles: str
    picture: str

    def of(self, responses: Collection[str]) -> Self | None:
        """Return what is shown of a run with these responses; None of one that has none."""
        if self.response:
            return self
        return replace(self, response=next(iter(responses))) if responses else None


@dataclass(frozen=True)
class SeenOutline:
    """Outline of what stands before a camera: a heap on its plate, or the surface in a drum.

    Parameters
    ----------
    x, heights : ndarray of shape (n,)
        Across and upwards from the foot of a heap's axis, or from the axis of a drum, m; x
        increases.
    drum_radius : float
        Inner radius of a drum, m; 0 of a heap.
    """

    x: Array
    heights: Array
    drum_radius: float = 0.0

    @classmethod
    def of_profile(cls, profile: Measured | None) -> Self | None:
        """Return a heap by the mean height of its sides over the distance from its axis."""
        if not isinstance(profile, Curve):
            return None
        x, heights = np.asarray(profile.coordinates), np.asarray(profile.values)
        across = np.r_[-x[::-1], x[x > 0]]
        both = np.r_[heights[::-1], heights[x > 0]]
        # Down to the first point on the plate, on both sides.
        above = np.flatnonzero(both > 0)
        shown = slice(max(0, above[0] - 1), above[-1] + 2) if len(above) else slice(None)
        return cls(across[shown], both[shown])


@dataclass(frozen=True)
class MeasuredDrawing:
    """A drawing with the measurement on it.

    Parameters
    ----------
    drawing : Drawing
        From the side.
    words : str
        How the response was measured, such as ``"mean of 24 fitted flanks from all sides"``; empty
        when nothing could be measured.
    """

    drawing: Drawing
    words: str


class RunView(ABC):
    """The end of one run, to be drawn."""

    #: The particles at the end.
    particles: Particles

    @abstractmethod
    def drawing(self) -> Drawing:
        """Draw the particles from one side."""

    @abstractmethod
    def measured_drawing(self, target: float | None) -> MeasuredDrawing:
        """Draw what was measured beside its target, as far as it could be measured."""

    def before_camera(self) -> Drawing | None:
        """Draw what a camera sees, about the origin of a `SeenOutline`; None without lengths."""
        drawing = replace(self.measured_drawing(None).drawing, fitted=())
        return None if drawing.pixel_size is None else drawing

    def outlines(self) -> Sequence[Outline]:
        """Return the edges of the apparatus, drawn about the z axis and from z = 0 upwards, m."""
        return ()


def circle(radius: float, z: float) -> Outline:
    """Return a horizontal circle about the z axis as an outline, m."""
    angles = [2 * math.pi * number / _CORNERS for number in range(_CORNERS + 1)]
    return [(radius * math.cos(angle), radius * math.sin(angle), z) for angle in angles]


def moved(outlines: Sequence[Outline], y: float, z: float) -> list[Outline]:
    """Return outlines moved along y and z, m."""
    return [[(a, b + y, c + z) for a, b, c in outline] for outline in outlines]


def raised(flank: Flank, height: float) -> Flank:
    """Return a flank that is higher by this height, m."""
    (x1, z1), (x2, z2) = flank.start, flank.end
    return Flank(flank.angle, (x1, z1 + height), (x2, z2 + height))


@runtime_checkable
class CanBeShown(Protocol):
    """A test whose runs a report shows."""

    #: Files and response to show.
    shown: ClassVar[Shown]

    def view(self, run: RunOutput) -> RunView:
        """Read the end of a run, to be drawn.

        Raises
        ------
        NotMeasurableError, OSError
            It is not there, or damaged.
        """


@runtime_checkable
class CanBePhotographed(Protocol):
    """A test whose runs a report shows beside photographs of it."""

    def seen_outline(self, responses: Mapping[str, Measured]) -> SeenOutline | None:
        """Return the outline of a run by its responses; None of one that has none."""


def shown(test: object) -> Shown | None:
    """Return what a report shows of the runs of a test, or of its class; None if nothing."""
    return test.shown if isinstance(test, CanBeShown) else None
