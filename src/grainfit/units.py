"""Convert quantities with units from user input to SI, with angles in degrees."""

from __future__ import annotations

import functools
import math
import re
from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

from grainfit import ground_messages as messages
from grainfit.errors import Fault, GrainfitError

if TYPE_CHECKING:
    # Imported when the first quantity is read: it takes a third of a second.
    import pint

#: Largest length of a quantity; no sensible one is longer.
LONGEST_QUANTITY = 60

_NUMBER = r"[+-]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][+-]?[0-9]+)?"
_QUANTITY = re.compile(rf"(?P<number>{_NUMBER})\s*(?P<unit>.*)", re.DOTALL)
# Units have their own small grammar, and only single names reach pint: its expression parser also
# calculates, and 9^9^9^9 takes forever.
_FACTOR = re.compile(
    r"\s*(?P<operator>[*·/]?)\s*(?P<name>[A-Za-zµμΩÅ_]+|°[CF]?|%)(?:(?:\^|\*\*)?(?P<power>[+-]?[0-9]))?\s*"
)
_SUPERSCRIPTS = str.maketrans("⁰¹²³⁴⁵⁶⁷⁸⁹⁻", "0123456789-")
_SIGNS = {"%": "percent", "°": "degree", "°C": "degC", "°F": "degF"}
#: Units of results with one of these dimensions, instead of products of base units.
_SI_UNITS = ("", "deg", "m", "s", "kg", "Pa", "N", "J", "kg/m^3", "m/s", "kg/s", "1/s", "J/m^2")
#: Factors of pint for the units that most quantities have, by SI unit: pint takes a quarter of a
#: second to start.
_FACTORS = {
    "m": {"m": 1.0, "cm": 0.01, "mm": 0.001},
    "s": {"s": 1.0, "ms": 0.001, "min": 60.0, "h": 3600.0},
    "kg": {"kg": 1.0, "g": 0.001},
    "Pa": {"Pa": 1.0, "kPa": 1e3, "MPa": 1e6, "GPa": 1e9},
    "kg/m^3": {"kg/m^3": 1.0, "kg/m3": 1.0, "kg/m³": 1.0, "g/cm^3": 999.9999999999999},
    "m/s": {"m/s": 1.0, "cm/s": 0.01, "mm/s": 0.001},
    "kg/s": {"kg/s": 1.0, "g/s": 0.001},
    "J/m^2": {"J/m^2": 1.0, "mJ/m^2": 0.001},
    "deg": {"deg": 1.0, "°": 1.0},
    "rad/s": {"rpm": 0.10471975511965977},
    "": {"%": 0.01},
}
_USUAL = {name: (unit, by) for unit, names in _FACTORS.items() for name, by in names.items()}
_EXAMPLES = {
    "": "0.5",
    "m": "10 mm",
    "Pa": "0.36 MPa",
    "kg/m^3": "2100 kg/m^3",
    "m/s": "0.05 m/s",
    "s": "10 min",
    "deg": "22 deg",
    "rad/s": "10 rpm",
    "m^3": "150 cm^3",
}


class UnitError(GrainfitError, ValueError):
    """A text is not a quantity of the expected unit.

    Parameters
    ----------
    fault : Fault
        What is wrong with the text, and what to write instead.
    """

    def __init__(self, fault: Fault) -> None:
        super().__init__(f"{fault.message} {fault.remedy}")
        self.message = fault.message
        self.remedy = fault.remedy


def to_unit(text: str, unit: str) -> float:
    """Convert a quantity such as ``"0.36 MPa"`` to a number in the given unit.

    Parameters
    ----------
    text : str
        A number and its unit, which is made of names, powers, ``*`` and ``/``: ``kg/m^3``,
        ``kg/m3``, ``m s^-1``, ``%``, ``°``.
    unit : str
        The unit of the result; ``""`` when dimensionless. An angle is not dimensionless here.

    Returns
    -------
    float
        Finite number, in ``unit``.

    Raises
    ------
    UnitError
        The text is not a quantity, lacks a unit, or is of another dimension than ``unit``.

    Examples
    --------
    >>> to_unit("0.36 MPa", "Pa")
    360000.0
    >>> to_unit("22 deg", "deg")
    22.0
    """
    number, written_unit = _split(text, unit)
    if unit and not written_unit:
        raise UnitError(messages.NO_UNIT.fault("", given=text, remedy=how_to_write(unit)))
    value = _convert(number, written_unit, unit, text) if written_unit else number
    if not math.isfinite(value):
        raise UnitError(messages.TOO_LARGE.fault("", given=text, remedy=how_to_write(unit)))
    return value


def to_si(text: str) -> tuple[float, str]:
    """Convert a quantity to SI, angles to degrees; return the number and its unit.

    Raises
    ------
    UnitError
        The text is not a quantity.

    Examples
    --------
    >>> to_si("2.1 g/cm^3")
    (2100.0, 'kg/m^3')
    """
    _, written = _split(text, "")
    if not written:
        raise UnitError(messages.NO_UNIT_AT_ALL.fault("", given=text))
    if usual := _USUAL.get(written):
        return to_unit(text, usual[0]), usual[0]
    try:
        base = _base(_parse(written))
        unit = next((name for name in _SI_UNITS if _base(_parse(name)) == base), None)
    except _NotAUnitError as error:
        raise _unknown_unit(error, text, "m") from None
    unit = f"{base:~C}".replace("**", "^") if unit is None else unit
    return to_unit(text, unit), unit


def percentage(text: str) -> float | None:
    """Return 0.01 for ``"1 %"``; None for a text that is not a percentage.

    Examples
    --------
    >>> percentage("1 %")
    0.01
    """
    match = _QUANTITY.fullmatch(text[: LONGEST_QUANTITY + 1].strip())
    if match is None or match["unit"] not in ("%", "percent"):
        return None
    return float(match["number"]) / 100


def is_unit(text: str) -> bool:
    """Return True if quantities can be converted to this unit."""
    try:
        _parse(text)
    except _NotAUnitError:
        return False
    return True


def is_same_unit(text: str, unit: str) -> bool:
    """Return False for a text that is a unit, but another one; words for people may be any.

    Examples
    --------
    >>> is_same_unit("°", "deg"), is_same_unit("mm", "deg"), is_same_unit("g/cm^3", "kg/m^3")
    (True, False, False)
    """
    if text == unit:
        return True
    try:
        return to_unit(f"1 {text}", unit) == 1
    except UnitError:
        return not is_unit(text)


#: Powers of mass, length and time in SI units, whose products are known without pint.
_POWERS = {
    "deg": (0, 0, 0),
    "rad": (0, 0, 0),
    "m": (0, 1, 0),
    "s": (0, 0, 1),
    "kg": (1, 0, 0),
    "N": (1, 1, -2),
    "J": (1, 2, -2),
    "Pa": (1, -1, -2),
}


def powers(unit: str) -> tuple[int, int, int]:
    """Return the powers of mass, length and time in a unit.

    Raises
    ------
    UnitError
        The text is not a unit, or has another dimension.

    Examples
    --------
    >>> powers("Pa")
    (1, -1, -2)
    >>> powers("deg")
    (0, 0, 0)
    """
    try:
        if (known := _si_powers(unit)) is not None:
            return known
        dimensions = dict(_parse(unit).dimensionality)
    except _NotAUnitError as error:
        fault = messages.NOT_A_UNIT.fault("", unit=error, remedy=how_to_write("m"))
        raise UnitError(fault) from None
    found = [round(float(dimensions.pop(name, 0))) for name in ("[mass]", "[length]", "[time]")]  # type: ignore[arg-type]
    if dimensions:
        fault = messages.NOT_MECHANICAL.fault("", unit=unit, remedy=how_to_write("m"))
        raise UnitError(fault)
    return found[0], found[1], found[2]


@functools.lru_cache(maxsize=256)
def _si_powers(unit: str) -> tuple[int, int, int] | None:
    """Return the powers in a product of SI units; None for another unit."""
    factors = list(_factors(unit))
    if any(name not in _POWERS for name, _ in factors):
        return None
    mass, length, time = (
        sum(_POWERS[name][i] * power for name, power in factors) for i in range(3)
    )
    return mass, length, time


def how_to_write(unit: str, example: str = "") -> str:
    """Return a sentence that shows how to write a quantity of this unit; the example is usual."""
    example = example or example_with(unit)
    if not unit:
        return f"It has no unit: write a plain number, for example {example}."
    return f'Write it in {unit}, for example "{example}".'


def example_with(unit: str) -> str:
    """Return a quantity as it is written, in this unit or in a usual multiple of it.

    Examples
    --------
    >>> example_with("m"), example_with("J/m^2")
    ('10 mm', '1.5 J/m^2')
    """
    return _EXAMPLES.get(unit, f"1.5 {unit}")


#: Usual slips in a quantity, by what is written behind its first digits.
_SLIPS = {
    re.compile(","): messages.COMMA,
    re.compile(r"\d{3}"): messages.SPACE,
    re.compile(r"[^±+]*(?:±|\+/?-)"): messages.UNCERTAINTY,
}


class _NotAUnitError(Exception):
    pass


def _unknown_unit(unit: Exception, text: str, expected: str) -> UnitError:
    remedy = how_to_write(expected)
    return UnitError(messages.NOT_A_UNIT_IN.fault("", unit=unit, given=text, remedy=remedy))


def _split(text: str, unit: str) -> tuple[float, str]:
    if len(text) > LONGEST_QUANTITY:
        remedy = how_to_write(unit)
        raise UnitError(messages.TOO_LONG.fault("", beginning=text[:20], remedy=remedy))
    match = _QUANTITY.fullmatch(text.strip())
    if match is None:
        remedy = how_to_write(unit)
        raise UnitError(messages.NOT_A_QUANTITY.fault("", given=text, remedy=remedy))
    for behind_number, slip in _SLIPS.items():
        if behind_number.match(match["unit"]):
            raise UnitError(slip.fault("", given=text))
    # Spaces of any kind are one: a message shows the unit.
    return float(match["number"]), " ".join(match["unit"].split())


def _convert(number: float, written: str, expected: str, text: str) -> float:
    unit, factor = _USUAL.get(written, (None, math.nan))
    if unit == expected:
        return _rounded(number * factor)
    return _by_pint(number, written, expected, text)


def _by_pint(number: float, written: str, expected: str, text: str) -> float:
    from pint import PintError

    target = _parse(expected)
    remedy = how_to_write(expected)
    try:
        unit = _parse(written)
        # Base units are compared, not dimensions: to pint an angle is a pure number.
        if _base(unit) != _base(target):
            reason = f"cannot be converted to {expected}" if expected else "does not belong here"
            raise UnitError(
                messages.OTHER_UNIT.fault(
                    "", given=text, written=written, reason=reason, remedy=remedy
                )
            )
        value = _registry().Quantity(number, unit).to(target).magnitude
    except _NotAUnitError as error:
        raise _unknown_unit(error, text, expected) from None
    except (PintError, ArithmeticError):
        fault = messages.NOT_CONVERTED.fault("", given=text, unit=expected, remedy=remedy)
        raise UnitError(fault) from None
    return _rounded(value)


def _rounded(value: float) -> float:
    # Conversion loses the last digit: 9 mm must be 0.009 m, not 0.009000000000000001 m.
    return float(f"{value:.15g}")


@functools.cache
def _registry() -> pint.UnitRegistry[float]:
    from pint import UnitRegistry

    return UnitRegistry(cache_folder=None)


def _base(unit: pint.Unit) -> Any:
    return _registry().get_base_units(unit)[1]


@functools.lru_cache(maxsize=256)
def _parse(text: str) -> pint.Unit:
    """Build a unit from its factors, from left to right."""
    unit = _registry().Unit("")
    for name, power in _factors(text):
        unit = unit * _named(name) ** power
    return unit


def _factors(text: str) -> Iterator[tuple[str, int]]:
    """Iterate over the names in a unit, with their powers."""
    text = text.translate(_SUPERSCRIPTS)
    position = 1 if text.startswith("1/") else 0
    while position < len(text):
        factor = _FACTOR.match(text, position)
        if factor is None:
            raise _NotAUnitError(repr(text))
        yield factor["name"], int(factor["power"] or 1) * (-1 if factor["operator"] == "/" else 1)
        position = factor.end()


def _named(name: str) -> pint.Unit:
    from pint import PintError

    try:
        return _registry().Unit(_SIGNS.get(name, name))
    except (PintError, ValueError, TypeError, AttributeError):
        raise _NotAUnitError(repr(name)) from None
