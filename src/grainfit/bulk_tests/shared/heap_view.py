"""A heap on a round plate: what is measured of it, and its view in a report."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np

from grainfit.bulk_tests.shared import messages
from grainfit.bulk_tests.view import MeasuredDrawing, Outline, RunView, circle
from grainfit.errors import NotMeasurableError, RunFailedError
from grainfit.evaluation import Measured
from grainfit.measurement.angle_of_repose import (
    AngleOfRepose,
    View,
    angle_of_repose,
    heap_silhouette,
    heap_silhouettes,
    on_plate,
)
from grainfit.measurement.drawing import Drawing, draw
from grainfit.measurement.heap_picture import draw_heap
from grainfit.measurement.heap_size import base_radius, heap_height, heap_profile, reaches_edge
from grainfit.measurement.messages import NO_HEAP, NOT_ON_PLATE
from grainfit.measurement.particles import Particles
from grainfit.measurement.silhouette import Silhouette

#: Share of the particles of a heap that are within its base radius, for readers.
_OUTER = 0.97


@dataclass(frozen=True)
class HeapView(RunView):
    """The heap of one run, on a plate at z = 0.

    Parameters
    ----------
    end : Particles
        Those at the end of the run; the others fell off the plate.
    plate_radius, rim_height : float
        Of the plate, m.
    ground : float
        Height from which the flanks are measured, m.
    views : int
        Silhouettes on which the angle of repose is measured.
    """

    end: Particles
    plate_radius: float
    rim_height: float
    ground: float
    views: int

    @cached_property
    def particles(self) -> Particles:  # type: ignore[override]
        """Particles on the plate.

        Raises
        ------
        NotMeasurableError
            There are none.
        """
        heap = on_plate(self.end, self.plate_radius)
        if not len(heap):
            raise NotMeasurableError(NOT_ON_PLATE(count=len(self.end)))
        return heap

    @cached_property
    def silhouettes(self) -> list[Silhouette]:
        """The heap from all sides."""
        return heap_silhouettes(self.particles, self.plate_radius, self.views)

    @property
    def is_at_edge(self) -> bool:
        """Whether the plate, not the material, decides how wide the heap is."""
        return reaches_edge(
            self.silhouettes, self.ground, self.particles.diameter, self.plate_radius
        )

    def measure(self, picture: Path, at_edge: str = "") -> dict[str, Measured]:
        """Measure angle of repose, base radius, height and profile; leave a picture.

        Parameters
        ----------
        picture : Path
            PNG file.
        at_edge : str
            Why a heap that reaches the edge of the plate has none of them; empty if it has.

        Raises
        ------
        NotMeasurableError
            There is no heap with flanks all around, and why.
        """
        try:
            if at_edge and self.is_at_edge:
                self.picture(picture, at_edge)
                return {}
            angle = self._angle()
        except NotMeasurableError as error:
            self.picture(picture, str(error))
            if NO_HEAP.is_in(str(error)):
                raise NotMeasurableError(messages.NO_HEAP_ON_PLATE(reason=error)) from None
            raise
        self.picture(picture, angle)
        diameter = self.particles.diameter
        return {
            "angle_of_repose": angle.response,
            "base_radius": base_radius(self.silhouettes, self.ground, diameter),
            "heap_height": heap_height(self.silhouettes, diameter),
            "profile": heap_profile(self.silhouettes, diameter, self.plate_radius),
        }

    def require_covered(self) -> None:
        """Raise `RunFailedError` if the heap does not cover its plate."""
        if self.is_at_edge:
            return
        diameter, places = self.particles.diameter, self.particles.positions
        base = float(np.quantile(np.hypot(places[:, 0], places[:, 1]), _OUTER))
        raise RunFailedError(
            messages.NOT_COVERED(base=base / diameter, disc=self.plate_radius / diameter)
        )

    def picture(self, path: Path, measured: AngleOfRepose | str) -> None:
        """Write a PNG of the heap with what was measured, or the reason why nothing was."""
        draw_heap(path, self.end, self.plate_radius, self.ground, measured)

    def _angle(self) -> AngleOfRepose:
        heap = self.particles
        return angle_of_repose(heap, self.ground, self.plate_radius, self.views, self.silhouettes)

    def drawing(self) -> Drawing:
        """Draw the silhouette from one side."""
        return draw(heap_silhouette(self.particles, 0.0, self.plate_radius))

    def measured_drawing(self, target: float | None) -> MeasuredDrawing:
        """Draw the silhouette from the side where the flanks are as they are on average."""
        try:
            angle = self._angle()
        except NotMeasurableError:
            return MeasuredDrawing(self.drawing(), "")
        seen = zip(angle.views, self.silhouettes, strict=True)
        view, silhouette = min(seen, key=lambda pair: _unlike(pair[0], angle.value))
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
