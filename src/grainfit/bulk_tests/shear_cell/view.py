"""Yield locus and Mohr circles: the view of a report, and the picture of a run."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from PIL import Image

from grainfit.bulk_tests.shear.view import ShearView
from grainfit.bulk_tests.shear_cell.failure import WINDOW, Failure
from grainfit.bulk_tests.view import MeasuredDrawing
from grainfit.formatting import number
from grainfit.measurement.drawing import CURVE_HEIGHT, CurveScale, Drawing, Line
from grainfit.measurement.line_panel import PlottedLine, line_panel
from grainfit.measurement.mohr_circles import MohrCircles, ShearTest
from grainfit.measurement.sheet import FLANK, INK, OVERSAMPLING, sheet

_HALF_WIDTH = 300
_PANEL_WIDTH = 560 * OVERSAMPLING
_SIZE = _PANEL_WIDTH, 420 * OVERSAMPLING
#: Height of a panel of Mohr circles over its width, at which they are nearly round.
_ROUND = 0.5
#: Half the size of the mark of a point, over the normal stress of the preshear.
_MARK = 0.012
_STEADY = "#0072b2"
_STRESSES = {
    "cohesion": "cohesion",
    "unconfined_strength": "unconfined strength",
    "major_consolidation_stress": "major consolidation stress",
}


@dataclass(frozen=True)
class ShearCellView(ShearView):
    """A sheared bed between its plates, and what a shear tester reports of it.

    Parameters
    ----------
    evaluation : ShearTest
        The points of the yield locus.
    """

    evaluation: ShearTest

    @property
    def _circles(self) -> MohrCircles:
        return self.evaluation.circles

    @property
    def _scale(self) -> CurveScale:
        """Both axes have one scale: circles are round."""
        across = 1.05 * self._circles.major_consolidation_stress
        return CurveScale(across, across * CURVE_HEIGHT / (2 * _HALF_WIDTH), _HALF_WIDTH)

    def drawing(self) -> Drawing:
        """Draw the Mohr circle of steady flow."""
        return self._scale.drawing([self.circle()])

    def measured_drawing(self, target: float | None) -> MeasuredDrawing:
        """Draw the yield locus over the circle of steady flow, and one with the target's angle."""
        wanted = [self._line(math.tan(math.radians(target)))] if target else []
        fitted = [self._line(self._circles.slope)]
        return MeasuredDrawing(self._scale.drawing([self.circle()], fitted, wanted), self.words)

    @property
    def words(self) -> str:
        """What was measured, and whether the material flows freely."""
        test = self.evaluation
        points = f"line through {len(test.angles)} points of failure after preshear"
        return f"{points}; drawn: Mohr circle of steady flow; {self.flowability}"

    @property
    def flowability(self) -> str:
        """Flow function coefficient in words."""
        test = self.evaluation
        if "ffc" in (found := test.responses):
            return f"ffc {number(found['ffc'].value, 3)}"
        least = test.least_ffc
        return f"free flowing, ffc above {number(least, 2)}" if least < math.inf else "free flowing"

    def circle(self) -> tuple[list[float], list[float]]:
        """Return the upper half of the Mohr circle of steady flow, Pa."""
        circles = self._circles
        return half_circle(circles.centre, circles.radius)

    def _line(self, slope: float) -> Line:
        """Draw a locus of a slope through the middle of the measured one."""
        circles, stresses = self._circles, self.evaluation.normal_stresses
        middle = (min(stresses) + max(stresses)) / 2
        height = circles.cohesion + circles.slope * middle
        ends = (min(stresses), circles.normal_stress)
        low, high = ((end, height + slope * (end - middle)) for end in ends)
        return self._scale.line(low, high)


def half_circle(centre: float, radius: float) -> tuple[list[float], list[float]]:
    """Return the upper half of a circle about a point of the normal stress axis, Pa."""
    angles = np.linspace(math.pi, 0.0, 90)
    return (centre + radius * np.cos(angles)).tolist(), (radius * np.sin(angles)).tolist()


def draw_shear_cell(
    path: Path, view: ShearCellView, failures: Sequence[Failure], steady: float
) -> None:
    """Write a PNG of the bed, yield locus and Mohr circles, and courses of failure.

    Parameters
    ----------
    path : Path
        Of the picture.
    view : ShearCellView
        Bed and evaluation.
    failures : sequence of Failure
        Courses, in the order of the points.
    steady : float
        Shear stress over normal stress in steady flow.
    """
    found = view.evaluation.responses
    angles = [f"{name} {found[name].value:.1f}°" for name in ("phi_lin", "phi_e", "phi_sf")]
    values = [
        f"{words} {number(found[name].value, 3)} ± {number(found[name].standard_error, 2)} Pa"
        for name, words in _STRESSES.items()
    ]
    subtitle = (
        f"{', '.join(values)} (± standard error). The bed with its plates (grey) and the velocity "
        "profile; points of failure (vermilion) and of the preshear (blue) with yield locus and "
        "Mohr circles; shear stress over normal stress against shear strain, means over a strain "
        f"of {WINDOW:g}"
    )
    title = f"Shear cell: {', '.join(angles)}; {view.flowability}"
    panels = [
        view.side_view().panel(_PANEL_WIDTH),
        _locus_panel(view),
        _course_panel(failures, steady),
    ]
    sheet(title, subtitle, panels, _PANEL_WIDTH).save(path)


def _locus_panel(view: ShearCellView) -> Image.Image:
    test, circles = view.evaluation, view.evaluation.circles
    rings = [view.circle()]
    if (strength := circles.unconfined_strength) > 0:
        rings.append(half_circle(strength / 2, strength / 2))
    end = circles.normal_stress
    lines = [PlottedLine(*ring, width=2) for ring in rings]
    ends = [0.0, end], [circles.cohesion, circles.cohesion + circles.slope * end]
    lines.append(PlottedLine(*ends, colour=INK, width=3))
    points = [
        (stress, stress * math.tan(math.radians(angle.value)), FLANK)
        for stress, angle in zip(test.normal_stresses, test.angles, strict=True)
    ]
    points.append((circles.normal_stress, circles.shear_stress, _STEADY))
    size = _MARK * circles.normal_stress
    for x, y, colour in points:
        for bars in (([x - size, x + size], [y, y]), ([x, x], [y - size, y + size])):
            lines.append(PlottedLine(*bars, colour=colour, width=4))
    extent = _PANEL_WIDTH, _PANEL_WIDTH * _ROUND
    return line_panel(lines, "normal stress, Pa", "shear stress, Pa", extent)


def _course_panel(failures: Sequence[Failure], steady: float) -> Image.Image:
    shades = ("#d55e00", "#e69f00", "#cc79a7", "#009e73", "#56b4e9")
    lines = [
        PlottedLine(
            failure.middles,
            failure.frictions,
            f"{number(failure.normal_stress, 3)} Pa",
            shades[number_of % len(shades)],
            3,
        )
        for number_of, failure in enumerate(failures)
    ]
    end = float(max(failure.middles[-1] for failure in failures))
    lines.append(PlottedLine([0.0, end], 2 * [steady], "steady", _STEADY, 3))
    return line_panel(
        lines, "shear strain", "shear stress over normal stress", _SIZE, from_zero=False
    )
