"""View of a compression test in a report: the bed, and stress over strain."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from grainfit.bulk_tests.compression.curve import FITTED, Curve, Modulus, fit_modulus
from grainfit.bulk_tests.shared.pot_view import PotView
from grainfit.bulk_tests.view import MeasuredDrawing
from grainfit.errors import NotMeasurableError
from grainfit.measurement.drawing import Drawing, Line

#: Half the width and the height of the drawing of stress over strain, pixels.
_HALF_WIDTH, _HEIGHT, _SPACE = 300, 400, 12
#: The drawing ends at a multiple of this strain, so that most runs are drawn to one scale.
_STRAIN = 0.06
_MOST_POINTS = 200


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
        return self._drawing((), ())

    def measured_drawing(self, target: float | None) -> MeasuredDrawing:
        """Draw stress over strain with the fitted modulus of loading, and the target's slope."""
        height = self._height
        try:
            fit = fit_modulus(self.curves["load"], height, self.stress, "loading modulus")
        except NotMeasurableError:
            return MeasuredDrawing(self.drawing(), "")
        wanted = (self._line(fit, target),) if target else ()
        return MeasuredDrawing(self._drawing((self._line(fit, fit.value),), wanted), self.words)

    @property
    def _height(self) -> float:
        """Height of the bed at zero strain, m."""
        return float(self.curves["seat"].heights[-1])

    def _line(self, fit: Modulus, slope: float) -> Line:
        """A line of a slope through the middle of the fitted one."""
        middle = sum(FITTED) / 2 * self.stress
        strain = (middle - fit.stress_at_zero) / fit.value
        ends = [share * self.stress for share in FITTED]
        points = [self._place(strain + (end - middle) / slope, end) for end in ends]
        return Line(*points[0], *points[1])

    @property
    def _longest(self) -> float:
        strain = float(self.curves["load"].strains(self._height).max())
        return _STRAIN * max(1, math.ceil(strain / _STRAIN))

    def _place(self, strain: float, stress: float) -> tuple[float, float]:
        x = (2 * strain / self._longest - 1) * _HALF_WIDTH
        return round(x, 1), round(-stress / self.stress * _HEIGHT, 1)

    def _drawing(self, fitted: tuple[Line, ...], wanted: tuple[Line, ...]) -> Drawing:
        places = []
        for curve in (self.curves["load"], self.curves["unload"]):
            shown = np.linspace(0, len(curve.times) - 1, min(len(curve.times), _MOST_POINTS))
            strains = curve.strains(self._height)
            places += [self._place(strains[i], curve.stresses[i]) for i in shown.astype(int)]
        points = " ".join(f"{x:.0f},{y:.0f}" for x, y in places)
        return Drawing(
            path=f"M{places[0][0]:.0f},0 L{points} L{places[-1][0]:.0f},0Z",
            half_width=_HALF_WIDTH + _SPACE,
            height=_HEIGHT + _SPACE,
            fitted=fitted,
            wanted=wanted,
        )
