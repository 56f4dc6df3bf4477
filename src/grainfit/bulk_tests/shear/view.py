"""A sheared bed: the view of a report, and the picture of a run with its stress ratio."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from PIL import Image

from grainfit.bulk_tests.shear.flow import Frame, Profile, Record
from grainfit.bulk_tests.view import MeasuredDrawing, Outline, RunView
from grainfit.evaluation import Response
from grainfit.measurement.drawing import CurveScale, Drawing
from grainfit.measurement.line_panel import PlottedLine, line_panel
from grainfit.measurement.particles import Particles
from grainfit.measurement.sheet import FLANK, OVERSAMPLING, sheet
from grainfit.measurement.side_view import SideView

_PANEL_WIDTH = 560 * OVERSAMPLING
_RATIO_SIZE = _PANEL_WIDTH, 420 * OVERSAMPLING
#: Records of so many are averaged, or the curve would be a cloud.
_SMOOTHED = 10


@dataclass(frozen=True)
class ShearView(RunView):
    """A sheared bed between its plates.

    Parameters
    ----------
    particles : Particles
        The bed, with the middle of the lower plate at the origin.
    frame : Frame
        The snapshot as it is, with the plates.
    profile : Profile
        Mean velocities.
    length, depth : float
        Periods, m.
    """

    particles: Particles
    frame: Frame
    profile: Profile
    length: float
    depth: float

    @classmethod
    def of(cls, frame: Frame, profile: Profile, length: float, depth: float) -> ShearView:
        """Return the view of a snapshot."""
        bed = frame.bed
        middle = [length / 2, depth / 2, frame.plates[0]]
        centred = replace(bed, positions=bed.positions - middle)
        return cls(centred, frame, profile, length, depth)

    def drawing(self) -> Drawing:
        """Draw the velocity profile: the upper plate moves by the width of the drawing."""
        scale = CurveScale(1.0, 1.0)
        # The area between the profile and the left side, where the velocity is zero.
        velocities, heights = zip(*self._curve, (0.0, 1.0), strict=True)
        walls = [scale.line((0.0, height), (1.0, height)) for height in (0.0, 1.0)]
        return scale.drawing([(velocities, heights)], walls=walls)

    def measured_drawing(self, target: float | None) -> MeasuredDrawing:  # noqa: ARG002
        """Draw the velocity profile beside the words for the measurement of the angle."""
        words = "mean shear stress over normal stress on both plates; drawn: the velocity profile"
        return MeasuredDrawing(self.drawing(), words)

    @property
    def _curve(self) -> list[tuple[float, float]]:
        """Velocities over that of the upper plate, and heights over the gap."""
        profile = self.profile
        inner = zip(profile.velocities, profile.heights / profile.gap, strict=True)
        return [(0.0, 0.0), *((float(v), float(z)) for v, z in inner), (1.0, 1.0)]

    def outlines(self) -> Sequence[Outline]:
        """Return the rectangles of the plates."""
        low, high = self.frame.plates
        x, y = self.length / 2, self.depth / 2
        corners = [(-x, -y), (x, -y), (x, y), (-x, y), (-x, -y)]
        return [[(a, b, z) for a, b in corners] for z in (0.0, high - low)]

    def side_view(self) -> SideView:
        """Return bed and plates from the side, with the velocity profile across them."""
        frame = self.frame
        low, high = frame.plates
        reach = 1.2 * max(frame.lower.diameter, frame.bed.diameter)
        curve = [(v * self.length, low + z * (high - low)) for v, z in self._curve]
        extent = (-reach / 2, low - reach, self.length + reach / 2, high + reach)
        return SideView(frame.bed, extent, (), glued=(frame.lower, frame.upper), curves=(curve,))


def draw_shear(
    path: Path, view: ShearView, records: Sequence[Record], transient: int, angle: Response
) -> None:
    """Write a PNG of the bed, and of shear stress over normal stress against strain.

    The first records are the transient, which is thrown away.
    """
    title = f"Angle of internal friction {angle.value:.1f} ± {angle.standard_error:.1f}°"
    subtitle = (
        "± standard error; left, the bed with its plates (grey) and the velocity from 0 to that of "
        "the upper plate; right, shear stress over normal stress against shear strain, and its "
        "mean after the transient"
    )
    panels = [
        view.side_view().panel(_PANEL_WIDTH),
        _ratio_panel(records, transient, view.profile.gap, math.tan(math.radians(angle.value))),
    ]
    sheet(title, subtitle, panels, _PANEL_WIDTH).save(path)


def _ratio_panel(records: Sequence[Record], transient: int, gap: float, mean: float) -> Image.Image:
    start = records[0].travels[0]
    strains = np.concatenate([(r.travels - start) / gap for r in records])
    averaged = float(records[transient].travels[0] - start) / gap
    normal = np.mean([r.normal_stresses.mean() for r in records[transient:]])
    ratios = np.concatenate([r.shear_stresses for r in records]) / normal
    used = len(ratios) - len(ratios) % _SMOOTHED
    strains, ratios = (
        values[:used].reshape(-1, _SMOOTHED).mean(axis=1) for values in (strains, ratios)
    )
    ends = [averaged, float(strains[-1])]
    lines = [
        PlottedLine(strains, ratios),
        PlottedLine(ends, 2 * [mean], f"mean after the transient {mean:.3f}", FLANK, 4),
    ]
    return line_panel(lines, "shear strain", "shear stress over normal stress", _RATIO_SIZE)
