"""Friction on a wall from an angle measured in the laboratory, without a simulation.

A flat body of the bulk solid begins to slide on an inclined plane of the wall's material at the
angle atan(sliding friction), and a single particle begins to roll at atan(rolling friction). Both
hold exactly for the contact models of `grainfit.contact_models`.
"""

from __future__ import annotations

import math

from grainfit.errors import Fault, InputError
from grainfit.materials import messages
from grainfit.one_line import shortened
from grainfit.units import UnitError, to_unit
from grainfit.validation import as_number, plain

#: Parameters that are the tangent of an angle.
MEASURED_BY_ANGLE = ("particle_wall.sliding_friction", "particle_wall.rolling_friction")
#: Measured frictions of particles and of bulk solids are below; above, a number was an angle.
USUAL_FRICTION = 1.5
#: Steeper planes tell nothing about friction, whose largest value is 10.
STEEPEST = 84.0
#: Standard uncertainties on either side that the interval of a measured parameter has.
REACH = 3.0


def friction_of_angle(angle: float | str) -> float:
    """Return the coefficient of friction on a wall whose angle was measured: its tangent.

    Parameters
    ----------
    angle : float or str
        Angle of the plane at which sliding or rolling begins, degrees, or a quantity.

    Raises
    ------
    InputError
        It is no angle, or not between 0 and 84 degrees.

    Examples
    --------
    >>> round(friction_of_angle("21.8 deg"), 4)
    0.4
    """
    return math.tan(math.radians(_degrees("angle", angle)))


def friction_about(
    angle: float | str, uncertainty: float | str
) -> tuple[float, float, float, float]:
    """Return friction, its standard uncertainty, and the ends of an interval about it.

    Parameters
    ----------
    angle, uncertainty : float or str
        Measured angle and its standard uncertainty, degrees, or quantities.

    Raises
    ------
    InputError
        One of them is no angle, or out of range.

    Examples
    --------
    >>> [round(number, 4) for number in friction_about("21.8 deg", "0.5 deg")]
    [0.4, 0.0101, 0.3699, 0.4307]
    """
    middle, spread = _degrees("angle", angle), _degrees("uncertainty", uncertainty)
    if spread == 0:
        raise InputError(messages.ANGLE_WITHOUT_UNCERTAINTY.fault("uncertainty"))
    ends = max(middle - REACH * spread, 0.0), min(middle + REACH * spread, STEEPEST)
    friction, low, high = (math.tan(math.radians(a)) for a in (middle, *ends))
    return friction, (1 + friction**2) * math.radians(spread), low, high


def _degrees(key: str, given: float | str) -> float:
    try:
        angle = to_unit(given, "deg") if isinstance(given, str) else as_number(plain(given))
    except UnitError as error:
        raise InputError(Fault(key, error.message, error.remedy)) from None
    if 0 <= angle < STEEPEST:
        return angle
    shown = given if isinstance(given, str) else shortened(plain(given))
    raise InputError(messages.NO_ANGLE.fault(key, given=shown, steepest=STEEPEST))
