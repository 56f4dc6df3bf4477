"""The simulated apparatus in a laboratory's units: what was given, and what is assumed."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass, fields, replace
from typing import Any, Literal

from grainfit.bulk_tests import messages
from grainfit.bulk_tests.abilities import friction_options, is_of_user
from grainfit.bulk_tests.base import BulkTest
from grainfit.bulk_tests.instrument import Instrument
from grainfit.bulk_tests.parameter_names import DENSITY
from grainfit.bulk_tests.shared.part_friction import AS_PARTICLES
from grainfit.errors import InputError
from grainfit.formatting import in_usual_unit, number, plain
from grainfit.materials.walls import PLAIN, on_wall
from grainfit.options.tables import Key
from grainfit.scenes.packing import mean_particle_volume

Origin = Literal["given", "instrument", "assumed"]

#: Units of lengths, speeds and stresses, which describe an apparatus; other options are numerical
#: ones, shares and counts.
_UNITS = ("m", "m^3", "kg", "m/s", "rad/s", "deg", "Pa")
#: Options without such a unit that a laboratory knows, too.
_OTHERS = ("orifice", "base", "lining", "end_caps", "taps", "fill_level", "inertial_number")
#: Heights between which a density is measured are no part of an apparatus that nobody described.
_MEASURED = ("bulk_density_bottom", "bulk_density_top")
#: Options that give another one.
_ANOTHER_WAY = {"rotational_speed": "froude_number"}
#: What is filled in, and the option that gives its number.
_FILLING, _COUNT = "particles", "particle_count"
_LINES = {
    "given": messages.GIVEN,
    "instrument": messages.OF_INSTRUMENT,
    "assumed": messages.ASSUMED,
}


@dataclass(frozen=True)
class ApparatusValue:
    """A value of an apparatus.

    Parameters
    ----------
    name : str
        The option, or ``particles`` for what is filled in.
    value : str
        With its unit.
    origin : {"given", "instrument", "assumed"}
        Whether the calibration file says so, the instrument that it names, or a default.
    instrument : str
        Title of that instrument.
    """

    name: str
    value: str
    origin: Origin
    instrument: str = ""

    @property
    def option(self) -> str:
        """The option that gives the value."""
        return _COUNT if self.name == _FILLING else self.name

    def __str__(self) -> str:
        return f"{self.name.replace('_', ' ')} {self.value}"


def apparatus_of(
    test: BulkTest,
    given: Collection[str] | None = None,
    material: Mapping[str, float] | None = None,
    walls: Mapping[str, str] | None = None,
    instrument: Instrument | None = None,
) -> tuple[ApparatusValue, ...]:
    """Return the apparatus of a test; nothing of a scene of the user, whose file describes it.

    Parameters
    ----------
    test : BulkTest
        The test.
    given : collection of str, optional
        Options that were given. Without it, as for tests made in Python, those that differ from
        their defaults, because runs record the value of every option.
    material : mapping of str to float, optional
        Material parameters by dotted name: those that are known.
    walls : mapping of str to str, optional
        Walls with a name, by the parts that are made of them.
    instrument : Instrument, optional
        Instrument that gives its options where they are not given.
    """
    if is_of_user(test):
        return ()
    found = _Apparatus(test, given, material or {}, walls or {}, instrument)
    return tuple(found.values())


def apparatus_lines(test: str, values: Collection[ApparatusValue]) -> Iterator[str]:
    """Yield an apparatus in a line each: what was given, is the instrument's, and is assumed."""
    for origin in ("given", "instrument", "assumed"):
        of_origin = [value for value in values if value.origin == origin]
        if of_origin:
            listed, instrument = ", ".join(map(str, of_origin)), of_origin[0].instrument
            yield _LINES[origin](test=test, values=listed, instrument=instrument)


def as_smaller(test: str) -> str:
    """Return the name of a test for the smaller apparatus that is simulated in its search."""
    return messages.SMALLER(test=test)


@dataclass(frozen=True)
class _Apparatus:
    test: BulkTest
    given: Collection[str] | None
    material: Mapping[str, float]
    walls: Mapping[str, str]
    instrument: Instrument | None

    def values(self) -> Iterator[ApparatusValue]:
        values = self.test.resolved_options()
        of_parts = friction_options(type(self.test))
        frictions = {name: part for part, names in of_parts.items() for name in names}
        for key in self.test.option_keys():
            value = values[key.name]
            is_named = frictions.get(key.name) in self.walls
            origin = "given" if is_named else self._origin(key.name, value)
            if key.name in frictions:
                shown = self._friction(key.name, value, frictions[key.name])
            elif value is None or not _is_of_apparatus(key, origin):
                continue
            else:
                shown = shown_value(key, value)
            yield self._value(key.name, shown, origin)
        count = values.get(_COUNT)
        yield self._value(_FILLING, self._filling(), self._origin(_COUNT, count))

    def _value(self, name: str, shown: str, origin: Origin) -> ApparatusValue:
        title = self.instrument.title if self.instrument and origin == "instrument" else ""
        return ApparatusValue(name, shown, origin, title)

    def _friction(self, option: str, value: Any, part: str) -> str:
        """Return the friction of a part: its own, that of particles or that of a wall."""
        if value is not None:
            is_named = value == AS_PARTICLES
            return "as between particles" if is_named else number(float(value))
        wall = self.walls.get(part, PLAIN)
        known = self.material.get(on_wall(option.replace(f"{part}_", "particle_wall."), wall))
        words = f"of the {wall or 'walls'}"
        return words if known is None else f"{words}, {number(known)}"

    def _filling(self) -> str:
        test = self.test.of_material(self.material)
        count = test.number_of_particles - test.number_of_glued
        density = self.material.get(DENSITY)
        beside = f" beside {test.number_of_glued} that are glued" if test.number_of_glued else ""
        if density is None:
            return f"{count}{beside}"
        mass = count * mean_particle_volume(test.sizes) * density
        return f"{count}, {number(mass)} kg{beside}"

    def _origin(self, option: str, value: Any) -> Origin:
        if self.given is not None:
            names = {option, _ANOTHER_WAY.get(option, option)}
            if names & set(self.given):
                return "given"
            of_instrument = self.instrument.options if self.instrument else {}
            return "instrument" if names & set(of_instrument) else "assumed"
        return "assumed" if self._is_default(option, value) else "given"

    def _is_default(self, option: str, value: Any) -> bool:
        """Return whether an option has the value that it has when it is not given."""
        defaults: dict[str, Any] = {field.name: field.default for field in fields(self.test)}
        if option not in defaults:
            return True
        try:
            usual = replace(self.test, **{option: defaults[option]}).resolved_options()[option]
        except InputError:
            return False
        if isinstance(value, float) and isinstance(usual, float):
            return math.isclose(value, usual, rel_tol=1e-9)
        return bool(value == usual)


def _is_of_apparatus(key: Key, origin: Origin) -> bool:
    if key.name in _MEASURED:
        return origin != "assumed"
    return key.name in _OTHERS or getattr(key.kind, "unit", None) in _UNITS


def shown_value(key: Key, value: Any) -> str:
    """Return the value of an option in the unit of a laboratory; "" for one that is not set."""
    if value is None:
        return ""
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, list | tuple):
        return ", ".join(filter(None, (shown_value(key, one) for one in value)))
    if isinstance(value, int | float):
        return in_usual_unit(float(value), str(getattr(key.kind, "unit", "") or ""))
    return plain(str(value))
