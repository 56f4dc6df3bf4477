"""Yield locus, Mohr circles and flowability of a bulk solid, as a shear tester reports them."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Self

from grainfit.evaluation import Response
from grainfit.measurement.yield_locus import fit_yield_locus

#: Standard errors within which an unconfined strength is zero.
_CERTAIN = 2.0


@dataclass(frozen=True)
class MohrCircles:
    """Linearised yield locus with the circles of steady flow and of unconfined failure.

    The circle of steady flow goes through the preshear point and touches the locus at a smaller
    normal stress; that of unconfined failure goes through the origin and touches the locus (ASTM
    D6773; Schulze, Powders and Bulk Solids, 2nd ed. 2021, section 3.1). A preshear point above the
    locus counts as one on it.

    Parameters
    ----------
    cohesion : float
        Shear stress of the locus without a normal stress, Pa.
    slope : float
        Tangent of the angle of the locus, above zero.
    normal_stress, shear_stress : float
        The preshear point, Pa.

    Examples
    --------
    >>> circles = MohrCircles(100.0, 0.6, 1000.0, 650.0)
    >>> round(circles.major_consolidation_stress), round(circles.unconfined_strength)
    (1925, 353)
    """

    cohesion: float
    slope: float
    normal_stress: float
    shear_stress: float

    @property
    def _sine(self) -> float:
        return self.slope / math.sqrt(1 + self.slope**2)

    @property
    def _reach(self) -> float:
        """Radius of a circle about the origin that touches the locus, Pa."""
        return self.cohesion / math.sqrt(1 + self.slope**2)

    @property
    def centre(self) -> float:
        """Centre of the circle of steady flow, Pa."""
        square = 1 - self._sine**2
        half = self.normal_stress + self._sine * self._reach
        rest = self.normal_stress**2 + self.shear_stress**2 - self._reach**2
        return (half - math.sqrt(max(half**2 - square * rest, 0.0))) / square

    @property
    def radius(self) -> float:
        """Radius of the circle of steady flow, Pa."""
        return self.centre * self._sine + self._reach

    @property
    def major_consolidation_stress(self) -> float:
        """Major principal stress of steady flow, Pa."""
        return self.centre + self.radius

    @property
    def unconfined_strength(self) -> float:
        """Major principal stress at failure without a minor one, Pa."""
        return 2 * self._reach / (1 - self._sine)

    @property
    def effective_angle(self) -> float:
        """Angle of the line through the origin that touches the circle of steady flow, degrees."""
        return math.degrees(math.asin(min(self.radius / self.centre, 1.0)))

    @property
    def inverse_ffc(self) -> float:
        """Unconfined strength over major consolidation stress."""
        return self.unconfined_strength / self.major_consolidation_stress


@dataclass(frozen=True)
class ShearTest:
    """Evaluation of a shear test: points of incipient flow after preshear.

    Parameters
    ----------
    normal_stresses : sequence of float
        At failure, Pa.
    angles : sequence of Response
        Angles whose tangents are the shear stresses at failure over them, degrees.
    preshear_stress : float
        Normal stress of the preshear, Pa.
    steady_angle : Response
        Angle whose tangent is the shear stress of steady flow over it, degrees.

    Raises
    ------
    ValueError
        See `fit_yield_locus`; or the shear stress does not rise with the normal stress.
    """

    normal_stresses: Sequence[float]
    angles: Sequence[Response]
    preshear_stress: float
    steady_angle: Response

    def __post_init__(self) -> None:
        if self.circles.slope <= 0:
            raise ValueError("shear stress at failure does not rise with normal stress")

    @property
    def circles(self) -> MohrCircles:
        """Yield locus and Mohr circles."""
        locus = fit_yield_locus(self.normal_stresses, self.angles)
        slope = math.tan(math.radians(locus.internal_friction_angle.value))
        shear = self.preshear_stress * math.tan(math.radians(self.steady_angle.value))
        return MohrCircles(locus.cohesion.value, slope, self.preshear_stress, shear)

    @property
    def responses(self) -> dict[str, Response]:
        """Numbers that a shear tester reports, SI and degrees, with standard errors.

        The flow function coefficient ``ffc`` is missing of a material that `flows_freely`.
        """
        found = self._with_errors
        inverse = found.pop("inverse")
        if not self.flows_freely:
            error = inverse.standard_error / inverse.value**2
            found["ffc"] = Response(1 / inverse.value, error)
        return found

    @property
    def flows_freely(self) -> bool:
        """Whether the unconfined strength is zero within two standard errors."""
        inverse = self._with_errors["inverse"]
        return inverse.value <= _CERTAIN * inverse.standard_error

    @property
    def least_ffc(self) -> float:
        """Value that ffc is above, within two standard errors of the unconfined strength."""
        inverse = self._with_errors["inverse"]
        most = inverse.value + _CERTAIN * inverse.standard_error
        return 1 / most if most > 0 else math.inf

    @property
    def _with_errors(self) -> dict[str, Response]:
        """Return all numbers; every angle is moved by its standard error to get theirs."""
        values = self._values()
        moved = [
            (self._moved(number, 1.0)._values(), self._moved(number, -1.0)._values())
            for number in range(len(self.angles) + 1)
        ]
        return {
            name: Response(
                value, math.hypot(*((more[name] - less[name]) / 2 for more, less in moved))
            )
            for name, value in values.items()
        }

    def _values(self) -> dict[str, float]:
        circles = self.circles
        return {
            "cohesion": circles.cohesion,
            "phi_lin": math.degrees(math.atan(circles.slope)),
            "phi_e": circles.effective_angle,
            "phi_sf": self.steady_angle.value,
            "unconfined_strength": circles.unconfined_strength,
            "major_consolidation_stress": circles.major_consolidation_stress,
            "inverse": circles.inverse_ffc,
        }

    def _moved(self, number: int, errors: float) -> Self:
        """Return the test with one angle moved by standard errors."""
        every = [*self.angles, self.steady_angle]
        found = every[number]
        shifted = found.value + errors * found.standard_error
        every[number] = Response(shifted, found.standard_error)
        return type(self)(self.normal_stresses, every[:-1], self.preshear_stress, every[-1])
