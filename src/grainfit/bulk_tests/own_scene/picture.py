"""Picture and view of the particles of a scene of the user: nothing is known of their shape."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from grainfit.bulk_tests.view import MeasuredDrawing, RunView
from grainfit.evaluation import Response
from grainfit.measurement.drawing import Drawing, draw
from grainfit.measurement.particles import Particles
from grainfit.measurement.sheet import OVERSAMPLING, sheet
from grainfit.measurement.side_view import SideView
from grainfit.measurement.silhouette import render_silhouette

_PANEL_WIDTH = 900 * OVERSAMPLING
#: Pixels of a silhouette over a particle diameter.
_PIXELS = 20
#: Most pixels of a silhouette from the middle to an end, and in its height.
_MOST_PIXELS = 3000


@dataclass(frozen=True)
class ParticlesView(RunView):
    """The particles at the end of a run.

    Parameters
    ----------
    particles : Particles
        Moved so that their middle is on the z axis and the lowest one touches z = 0.
    """

    particles: Particles

    @classmethod
    def of(cls, particles: Particles) -> ParticlesView:
        """Return the view of particles anywhere."""
        places, radii = particles.positions, particles.radii
        middle = (places.min(axis=0) + places.max(axis=0)) / 2
        middle[2] = float((places[:, 2] - radii).min())
        return cls(replace(particles, positions=places - middle))

    def drawing(self) -> Drawing:
        """Draw the silhouette, seen along y."""
        reach = self.particles.diameter + float(np.abs(self.particles.positions[:, 0]).max())
        top = float((self.particles.positions[:, 2] + self.particles.radii).max())
        # Pixels are larger where single particles are far away.
        pixel = max(self.particles.diameter / _PIXELS, max(reach, top) / _MOST_PIXELS)
        return draw(render_silhouette(self.particles, 0.0, reach, 1.02 * top, pixel))

    def measured_drawing(self, target: float | None) -> MeasuredDrawing:  # noqa: ARG002
        """Draw the silhouette: the measurement of the user cannot be drawn."""
        return MeasuredDrawing(self.drawing(), "as your own function measured it")


def draw_particles(
    path: Path, particles: Particles, name: str, responses: Mapping[str, Response]
) -> None:
    """Write a PNG of the particles at the end, seen along y, with the responses of a scene."""
    places, margin = particles.positions, particles.diameter
    (left, _, bottom), (right, _, top) = places.min(axis=0), places.max(axis=0)
    extent = (left - margin, bottom - margin, right + margin, top + margin)
    panel = SideView(particles, extent, ()).panel(_PANEL_WIDTH)
    words = ", ".join(
        f"{key} {response.value:.4g} ± {response.standard_error:.2g}"
        for key, response in responses.items()
    )
    title = f"{name}: {len(particles)} particles at the end, seen along y"
    sheet(title, words, [panel], _PANEL_WIDTH).save(path)
