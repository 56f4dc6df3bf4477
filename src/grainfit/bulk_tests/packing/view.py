"""Pictures of a packing: the half of the bed behind the axis, and where it is measured."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from grainfit.bulk_tests.packing.setup import PackingSetup
from grainfit.bulk_tests.view import MeasuredDrawing, Outline, RunView, circle
from grainfit.evaluation import Response
from grainfit.measurement.angle_of_repose import heap_silhouette
from grainfit.measurement.drawing import Drawing, draw
from grainfit.measurement.particles import Particles
from grainfit.measurement.sheet import OVERSAMPLING, sheet
from grainfit.measurement.side_view import SideView

_PANEL_WIDTH = 560 * OVERSAMPLING


@dataclass(frozen=True)
class PackingView(RunView):
    """The bed of one run.

    Parameters
    ----------
    particles : Particles
        The bed.
    setup : PackingSetup
        Geometry of the test.
    """

    particles: Particles
    setup: PackingSetup

    def picture(self, path: Path, measured: Response | str) -> None:
        """Write a PNG of the bed.

        Parameters
        ----------
        path : Path
            File to write; ends in ``.png``.
        measured : Response or str
            The bulk density, or the reason why there is none.
        """
        setup, diameter = self.setup, self.particles.diameter
        if isinstance(measured, str):
            title, subtitle = "Bulk density: not measurable", measured
        else:
            title = f"Bulk density {measured.value:.0f} ± {measured.standard_error:.0f} kg/m³"
            subtitle = (
                f"± standard error; between {1000 * setup.bulk_density_bottom:.3g} and "
                f"{1000 * setup.bulk_density_top:.3g} mm; the half behind the axis is shown"
            )
        radius, thick, top = setup.container_radius, diameter / 2, self._top + diameter
        outer = radius + thick
        walls = [
            (-outer, -thick, -radius, top),
            (radius, -thick, outer, top),
            (-outer, -thick, outer, 0.0),
        ]
        behind = self.particles.select(self.particles.positions[:, 1] > 0)
        view = SideView(behind, (-outer - thick, -diameter, outer + thick, top), walls)
        sheet(title, subtitle, [view.panel(_PANEL_WIDTH)], _PANEL_WIDTH).save(path)

    @property
    def _top(self) -> float:
        return float((self.particles.positions[:, 2] + self.particles.radii).max())

    def drawing(self) -> Drawing:
        """Draw the silhouette of the bed."""
        return draw(heap_silhouette(self.particles, 0.0, self.setup.container_radius))

    def measured_drawing(self, target: float | None) -> MeasuredDrawing:  # noqa: ARG002
        """Draw the bed; a density cannot be seen on it."""
        setup = self.setup
        words = (
            f"mass over volume between {1000 * setup.bulk_density_bottom:.3g} and "
            f"{1000 * setup.bulk_density_top:.3g} mm"
        )
        return MeasuredDrawing(self.drawing(), words)

    def outlines(self) -> Sequence[Outline]:
        """Return the circles of the floor and of the bed's top."""
        return [circle(self.setup.container_radius, z) for z in (0.0, self._top)]
