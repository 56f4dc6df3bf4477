"""View of a shear cell in a report: yield locus and Mohr circles."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from grainfit.bulk_tests.shear.view import ShearView
from grainfit.bulk_tests.view import MeasuredDrawing
from grainfit.formatting import number
from grainfit.measurement.drawing import CURVE_HEIGHT, CurveScale, Drawing, Line
from grainfit.measurement.mohr_circles import MohrCircles, ShearTest

_HALF_WIDTH = 300


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
