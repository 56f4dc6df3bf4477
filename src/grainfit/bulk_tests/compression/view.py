"""View of a compression test in a report: the bed, and stress over strain."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

from grainfit.bulk_tests.compression.curve import FITTED, Array, Curve, Modulus, fit_modulus
from grainfit.bulk_tests.shared.pot_view import PotView
from grainfit.bulk_tests.view import MeasuredDrawing
from grainfit.errors import NotMeasurableError
from grainfit.measurement.drawing import CurveScale, Drawing, Line

#: The drawing ends at a multiple of this strain, so that most runs are drawn to one scale.
_STRAIN = 0.06


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
