"""View of a triaxial test in a report: the bed in its box, and stress and volume over strain."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from grainfit.bulk_tests.triaxial.curve import Compression
from grainfit.bulk_tests.triaxial.setup import TriaxialSetup
from grainfit.bulk_tests.view import MeasuredDrawing, Outline, RunView
from grainfit.measurement.drawing import CurveScale, Drawing
from grainfit.measurement.line_panel import PlottedLine, line_panel
from grainfit.measurement.particles import Particles
from grainfit.measurement.sheet import INK, OVERSAMPLING, sheet
from grainfit.measurement.side_view import SideView

_PANEL_WIDTH = 420 * OVERSAMPLING
_PLOT_SIZE = _PANEL_WIDTH, 420 * OVERSAMPLING
#: Blue and vermilion are distinct in any kind of colour blindness (Okabe & Ito).
_STRESS, _VOLUME = "#0072b2", "#d55e00"


@dataclass(frozen=True)
class TriaxialView(RunView):
    """A compressed bed, and its curves.

    Parameters
    ----------
    particles : Particles
        The bed at the end, with the middle of the lower wall at the origin.
    compression : Compression
        Stresses and strains.
    setup : TriaxialSetup
        Geometry and procedure.
    """

    particles: Particles
    compression: Compression
    setup: TriaxialSetup

    @classmethod
    def of(cls, bed: Particles, compression: Compression, setup: TriaxialSetup) -> TriaxialView:
        """Return the view of the bed at the end of a run."""
        width, depth, _ = compression.last_lengths
        middle = np.array([width / 2, depth / 2, 0.0])
        middle[:2] -= setup.first_width / 2
        return cls(replace(bed, positions=bed.positions - middle), compression, setup)

    def drawing(self) -> Drawing:
        """Draw deviatoric stress over axial strain."""
        return self._scale.drawing([self._curve])

    def measured_drawing(self, target: float | None) -> MeasuredDrawing:
        """Draw deviatoric stress over axial strain, with that of the critical state."""
        strain, averaged = float(self.setup.axial_strain), float(self.setup.averaged_strain)
        angles = [self.compression.last_angle(strain, averaged), target]
        fitted, wanted = (
            [self._scale.line((strain - averaged, q), (strain, q))] if q else []
            for q in (self._deviatoric(angle) for angle in angles)
        )
        words = f"mean of the axial strain from {strain - averaged:.3g} to {strain:.3g}; drawn: "
        words += "deviatoric stress over axial strain"
        return MeasuredDrawing(self._scale.drawing([self._curve], fitted, wanted), words)

    def _deviatoric(self, angle: float | None) -> float | None:
        """Deviatoric stress of a friction angle, Pa."""
        if angle is None:
            return None
        sine = math.sin(math.radians(angle))
        return float(2 * sine / (1 - sine) * self.setup.confining_stress)

    @property
    def _curve(self) -> tuple[np.ndarray, np.ndarray]:
        return self.compression.curves(float(self.setup.axial_strain))["deviatoric_stress"]

    @property
    def _scale(self) -> CurveScale:
        return CurveScale(float(self.setup.axial_strain), float(self._curve[1].max()))

    def outlines(self) -> Sequence[Outline]:
        """Return the edges of the box."""
        width, depth, height = self.compression.last_lengths
        x, y = width / 2, depth / 2
        corners = [(-x, -y), (x, -y), (x, y), (-x, y), (-x, -y)]
        upright = [[(a, b, 0.0), (a, b, height)] for a, b in corners[:4]]
        return [*([(a, b, z) for a, b in corners] for z in (0.0, height)), *upright]

    def draw(self, path: Path, title: str) -> None:
        """Write a PNG of the bed, of stresses, and of the volumetric strain."""
        width, _, height = self.compression.last_lengths
        thick = self.particles.diameter / 2
        walls = [
            (-width / 2 - thick, -thick, -width / 2, height + thick),
            (width / 2, -thick, width / 2 + thick, height + thick),
            (-width / 2, -thick, width / 2, 0.0),
            (-width / 2, height, width / 2, height + thick),
        ]
        reach = width / 2 + 2 * thick
        extent = (-reach, -2 * thick, reach, height + 2 * thick)
        behind = self.particles.select(self.particles.positions[:, 1] > 0)
        strain = float(self.setup.axial_strain)
        curves = self.compression.curves(strain)
        lateral = self.compression.smooth(self.compression.lateral, 0.005) / 1000
        shown = self.compression.strains <= strain
        strains = 100 * self.compression.strains[shown]
        at, stress = curves["deviatoric_stress"]
        panels = [
            SideView(behind, extent, walls).panel(_PANEL_WIDTH),
            line_panel(
                [
                    PlottedLine(100 * at, stress / 1000, "deviatoric", _STRESS, 4),
                    PlottedLine(strains, lateral[shown], "on the side walls", INK),
                ],
                "axial strain, %",
                "stress, kPa",
                _PLOT_SIZE,
            ),
            line_panel(
                [PlottedLine(100 * at, 100 * curves["volumetric_strain"][1], "", _VOLUME, 4)],
                "axial strain, %",
                "volumetric strain, % (compression)",
                _PLOT_SIZE,
            ),
        ]
        subtitle = (
            "left, half of the bed at the end; middle, axial less lateral stress, and the stress "
            "on the side walls; right, the volumetric strain"
        )
        sheet(title, subtitle, panels, _PANEL_WIDTH).save(path)
