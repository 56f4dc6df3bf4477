"""Picture of a shear cell: the bed, yield locus with Mohr circles, courses of failure."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path

from PIL import Image

from grainfit.bulk_tests.shear_cell.failure import WINDOW, Failure
from grainfit.bulk_tests.shear_cell.view import ShearCellView, half_circle
from grainfit.formatting import number
from grainfit.measurement.line_panel import PlottedLine, line_panel
from grainfit.measurement.sheet import FLANK, INK, OVERSAMPLING, sheet

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
