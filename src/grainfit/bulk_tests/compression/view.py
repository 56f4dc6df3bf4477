"""View of a compression test in a report: the loaded bed between floor and piston."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from grainfit.bulk_tests.view import MeasuredDrawing, Outline, RunView, circle
from grainfit.measurement.angle_of_repose import heap_silhouette
from grainfit.measurement.drawing import Drawing, draw
from grainfit.measurement.particles import Particles


@dataclass(frozen=True)
class CompressionView(RunView):
    """The loaded bed of one run.

    Parameters
    ----------
    particles : Particles
        Those in the pot.
    pot_radius : float
        m.
    piston_height : float
        Height of the piston above the floor, m.
    """

    particles: Particles
    pot_radius: float
    piston_height: float

    def drawing(self) -> Drawing:
        """Draw the silhouette of the bed."""
        return draw(heap_silhouette(self.particles, 0.0, self.pot_radius))

    def measured_drawing(self, target: float | None) -> MeasuredDrawing:  # noqa: ARG002
        """Draw the bed; moduli cannot be seen on it."""
        words = "slope of stress over strain, from 50 to 98 % of the stress"
        return MeasuredDrawing(self.drawing(), words)

    def outlines(self) -> Sequence[Outline]:
        """Return the circles of floor and piston."""
        return [circle(self.pot_radius, z) for z in (0.0, self.piston_height)]
