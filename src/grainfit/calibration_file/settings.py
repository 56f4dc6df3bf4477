"""Values of single parameters of a calibration file, set as ``NAME=VALUE``."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from difflib import get_close_matches

from grainfit.calibration_file import messages
from grainfit.calibration_file.content import CalibrationFile
from grainfit.contact_models.registry import material_parameter
from grainfit.errors import InputError
from grainfit.formatting import in_a_row
from grainfit.options.kinds import Quantity, suggest
from grainfit.options.places import Findings, Place
from grainfit.units import is_unit


def set_values(
    file: CalibrationFile, settings: Iterable[str], others: Mapping[str, float] | None = None
) -> dict[str, float]:
    """Return the values of all free parameters, and of fixed ones that are set.

    Parameters
    ----------
    file : CalibrationFile
        The file, with its parameters.
    settings : iterable of str
        ``NAME=VALUE``; a value may have a unit.
    others : mapping of str to float, optional
        Values of parameters that are not set; by default free ones take the middle of their
        interval.

    Raises
    ------
    InputError
        A setting has another form, names no parameter of the file, or is no possible value.
    """
    findings = Findings(file.path.parent)
    values = {p.name: p.from_unit(0.5) for p in file.parameters} | dict(others or {})
    for setting in settings:
        name, _, text = setting.partition("=")
        place = Place(findings, tuple(name.strip().split(".")))
        values |= _set(file, name.strip(), text.strip(), place)
    InputError.raise_for(findings.faults)
    return values


def quantity_of(file: CalibrationFile, name: str) -> Quantity:
    """Return the unit and the physical limits of a parameter of a file."""
    if (known := material_parameter(name)) is not None:
        return known.possible
    units = [p.unit for p in file.parameters if p.name == name and is_unit(p.unit)]
    return Quantity(units[0] if units and units[0] else None)


def _set(file: CalibrationFile, name: str, text: str, place: Place) -> dict[str, float]:
    free = [parameter.name for parameter in file.parameters]
    if name not in (known := [*free, *file.fixed]):
        place.fault(messages.NO_PARAMETER_OF_FILE, remedy=_meant(name, known, free))
    elif not text:
        place.fault(messages.NO_VALUE_GIVEN, name=name)
    elif (value := quantity_of(file, name).read(_number_or_text(text), place)) is not None:
        return {name: value}
    return {}


def _meant(name: str, known: Sequence[str], free: Sequence[str]) -> str:
    """Return a sentence that suggests a parameter; of those of one key, the free ones."""
    keys = [other.rpartition(".")[2] for other in known]
    close = get_close_matches(name[:64], keys, n=1)
    alike = [other for other, key in zip(known, keys, strict=True) if key in close]
    alike = [other for other in alike if other in free] or alike
    if "." in name or not alike:
        return suggest(name, known, "It has")
    return f"Write its whole name: {in_a_row(alike, 'or')}."


def _number_or_text(text: str) -> float | str:
    try:
        return float(text)
    except ValueError:
        return text
