"""View of a bed in an upright pot: silhouette, side view, and the pot's circles."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from grainfit.bulk_tests.view import MeasuredDrawing, Outline, RunView, circle
from grainfit.measurement.angle_of_repose import heap_silhouette
from grainfit.measurement.drawing import Drawing, draw
from grainfit.measurement.particles import Particles
from grainfit.measurement.sheet import OVERSAMPLING, sheet
from grainfit.measurement.side_view import SideView

_PANEL_WIDTH = 560 * OVERSAMPLING


@dataclass(frozen=True)
class PotView(RunView):
    """A bed at rest in a pot about the z axis, whose floor is at z = 0.

    Parameters
    ----------
    particles : Particles
        The bed.
    radius : float
        Inner radius of the pot, m.
    lid : float
        Height of a piston on the bed, or of the bed's surface, m.
    words : str
        How the response was measured; neither a density nor a modulus can be seen on the bed.
    """

    particles: Particles
    radius: float
    lid: float
    words: str

    def drawing(self) -> Drawing:
        """Draw the silhouette of the bed."""
        return draw(heap_silhouette(self.particles, 0.0, self.radius))

    def measured_drawing(self, target: float | None) -> MeasuredDrawing:  # noqa: ARG002
        """Draw the bed beside the words for its measurement."""
        return MeasuredDrawing(self.drawing(), self.words)

    def outlines(self) -> Sequence[Outline]:
        """Return the circles of floor and lid."""
        return [circle(self.radius, z) for z in (0.0, self.lid)]

    def side_view(self, has_piston: bool = False) -> SideView:
        """Return the half of the bed behind the axis, with sections of the pot."""
        diameter = self.particles.diameter
        thick, top = diameter / 2, self.lid + diameter
        outer = self.radius + thick
        walls = [
            (-outer, -thick, -self.radius, top),
            (self.radius, -thick, outer, top),
            (-outer, -thick, outer, 0.0),
        ]
        if has_piston:
            walls.append((-self.radius, self.lid, self.radius, self.lid + thick))
        behind = self.particles.select(self.particles.positions[:, 1] > 0)
        return SideView(behind, (-outer - thick, -diameter, outer + thick, top), walls)

    def draw(self, path: Path, title: str, subtitle: str) -> None:
        """Write a PNG of the half of the bed behind the axis."""
        panel = self.side_view().panel(_PANEL_WIDTH)
        sheet(title, subtitle, [panel], _PANEL_WIDTH).save(path)


def highest_point(bed: Particles) -> float:
    """Return the height of the highest particle's top, m."""
    return float((bed.positions[:, 2] + bed.radii).max())
