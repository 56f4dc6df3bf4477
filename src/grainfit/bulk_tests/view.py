"""View of a run of a bulk test in a report."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass

from grainfit.measurement.drawing import Drawing
from grainfit.measurement.particles import Particles


@dataclass(frozen=True)
class Shown:
    """Files and response of a bulk test that a report shows.

    Parameters
    ----------
    noun : str
        What the particles form at the end, such as ``"heap"``.
    response : str
        The response to show.
    particles : str
        File of the particles at the end.
    picture : str
        PNG file, kept when the particles are not.
    """

    noun: str
    response: str
    particles: str
    picture: str


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

    def rings(self) -> Sequence[tuple[float, float]]:
        """Return radius and height of the circles of the apparatus in the scene, m."""
        return ()
