"""View of a heap in a report: its silhouette, its flanks, and the plate below it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from grainfit.bulk_tests.view import MeasuredDrawing, Outline, RunView, circle
from grainfit.errors import NotMeasurableError
from grainfit.measurement.angle_of_repose import View, angle_of_repose, heap_silhouette
from grainfit.measurement.drawing import Drawing, draw
from grainfit.measurement.particles import Particles


@dataclass(frozen=True)
class HeapView(RunView):
    """The heap of one run.

    Parameters
    ----------
    particles : Particles
        Those on the plate.
    plate_radius, rim_height : float
        Of the plate, m.
    ground : float
        Height from which the flanks are measured, m.
    views : int
        Silhouettes on which the angle of repose is measured.
    """

    particles: Particles
    plate_radius: float
    rim_height: float
    ground: float
    views: int

    def drawing(self) -> Drawing:
        """Draw the silhouette from one side."""
        return draw(heap_silhouette(self.particles, 0.0, self.plate_radius))

    def measured_drawing(self, target: float | None) -> MeasuredDrawing:
        """Draw the silhouette from the side where the flanks are as they are on average."""
        try:
            angle = angle_of_repose(self.particles, self.ground, self.plate_radius, self.views)
        except NotMeasurableError:
            return MeasuredDrawing(self.drawing(), "")
        view = min(angle.views, key=lambda view: _unlike(view, angle.value))
        silhouette = heap_silhouette(self.particles, view.azimuth, self.plate_radius)
        flanks = sum((v.left is not None) + (v.right is not None) for v in angle.views)
        words = f"mean of {flanks} fitted flanks from all sides"
        return MeasuredDrawing(draw(silhouette, view, target), words)

    def outlines(self) -> Sequence[Outline]:
        """Return the edge of the plate, and that of its rim."""
        rim = [circle(self.plate_radius, self.rim_height)] if self.rim_height > 0 else []
        return [circle(self.plate_radius, 0.0), *rim]


def _unlike(view: View, angle: float) -> float:
    """Distance of a view's flanks from an angle; infinite when a flank is missing."""
    if view.left is None or view.right is None:
        return np.inf
    return abs(view.left.angle - angle) + abs(view.right.angle - angle)
