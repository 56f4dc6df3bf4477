"""Stress over strain and the bed: the view of a report, and the picture of a run."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from PIL import Image

from grainfit.arrays import Array
from grainfit.bulk_tests.compression.curve import FITTED, Curve, Modulus, fit_modulus
from grainfit.bulk_tests.compression.setup import CompressionSetup
from grainfit.bulk_tests.shared.pot_view import PotView
from grainfit.bulk_tests.view import MeasuredDrawing
from grainfit.errors import NotMeasurableError
from grainfit.formatting import number
from grainfit.measurement.drawing import CurveScale, Drawing, Line
from grainfit.measurement.line_panel import PlottedLine, line_panel
from grainfit.measurement.sheet import INK, OVERSAMPLING, sheet

#: The drawing ends at a multiple of this strain, so that most runs are drawn to one scale.
_STRAIN = 0.06
_PANEL_WIDTH = 560 * OVERSAMPLING
_PLOT_SIZE = _PANEL_WIDTH, 420 * OVERSAMPLING
_NAMES = {"load": "loading", "unload": "unloading"}
#: Blue and vermilion are distinct in any kind of colour blindness (Okabe & Ito).
_COLOURS = "#0072b2", "#d55e00"


@dataclass(frozen=True)
class CompressionView(PotView):
    """The loaded bed of one run, and its curves.

    Parameters
    ----------
    curves : mapping of str to Curve
        Of the stages ``"seat"``, ``"load"`` and ``"unload"``.
    stress : float
        Of the piston, Pa.
    """

    curves: Mapping[str, Curve]
    stress: float

    def drawing(self) -> Drawing:
        """Draw stress over strain, from loading to unloading."""
        return self._scale.drawing(self._curves)

    def measured_drawing(self, target: float | None) -> MeasuredDrawing:
        """Draw stress over strain with the fitted modulus of loading, and the target's slope."""
        height = self._height
        try:
            fit = fit_modulus(self.curves["load"], height, self.stress, "loading modulus")
        except NotMeasurableError:
            return MeasuredDrawing(self.drawing(), "")
        wanted = [self._line(fit, target)] if target else []
        drawing = self._scale.drawing(self._curves, [self._line(fit, fit.value)], wanted)
        return MeasuredDrawing(drawing, self.words)

    @property
    def _height(self) -> float:
        """Height of the bed at zero strain, m."""
        return float(self.curves["seat"].heights[-1])

    def _line(self, fit: Modulus, slope: float) -> Line:
        """A line of a slope through the middle of the fitted one."""
        middle = sum(FITTED) / 2 * self.stress
        strain = (middle - fit.stress_at_zero) / fit.value
        ends = [share * self.stress for share in FITTED]
        low, high = ((strain + (end - middle) / slope, end) for end in ends)
        return self._scale.line(low, high)

    @property
    def _scale(self) -> CurveScale:
        strain = float(self.curves["load"].strains(self._height).max())
        return CurveScale(_STRAIN * max(1, math.ceil(strain / _STRAIN)), self.stress)

    @property
    def _curves(self) -> list[tuple[Array, Array]]:
        curves = (self.curves["load"], self.curves["unload"])
        return [(curve.strains(self._height), curve.stresses) for curve in curves]


def draw_compression(
    path: Path,
    view: PotView,
    setup: CompressionSetup,
    curves: Mapping[str, Curve],
    moduli: Mapping[str, Modulus],
) -> None:
    """Write a PNG of the bed under the stress, and of stress over strain with the fitted moduli."""
    values = [f"{_NAMES[s]} {_kilo(moduli[f'{s}ing_modulus'].value)} kPa" for s in _NAMES]
    title = f"Compression: modulus of {', of '.join(values)}"
    subtitle = (
        f"left, the bed under {_kilo(setup.stress)} kPa behind the axis; right, the stress on the "
        "piston against strain, and the fitted lines"
    )
    panels = [
        view.side_view(has_piston=True).panel(_PANEL_WIDTH),
        _stress_panel(setup.stress, curves, moduli),
    ]
    sheet(title, subtitle, panels, _PANEL_WIDTH).save(path)


def _kilo(pascals: float) -> str:
    return number(pascals / 1000, 3)


def _stress_panel(
    stress: float, curves: Mapping[str, Curve], moduli: Mapping[str, Modulus]
) -> Image.Image:
    height = float(curves["seat"].heights[-1])
    stresses = np.array(FITTED) * stress
    behind, fitted = [], []
    for (stage, name), colour in zip(_NAMES.items(), _COLOURS, strict=True):
        curve, fit = curves[stage], moduli[f"{stage}ing_modulus"]
        label = f"{name}, {_kilo(fit.value)} kPa"
        strains = 100 * curve.strains(height)
        behind.append(PlottedLine(strains, curve.stresses / 1000, label, colour))
        strains = 100 * (stresses - fit.stress_at_zero) / fit.value
        fitted.append(PlottedLine(strains, stresses / 1000, colour=INK, width=4))
    return line_panel([*behind, *fitted], "strain, %", "stress on the piston, kPa", _PLOT_SIZE)
