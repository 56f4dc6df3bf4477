"""Runs of bulk tests in natural units: length d, time sqrt(d/g), mass rho d^3.

Two runs whose dimensionless numbers agree are the same run, at any size and density of the
particles: frictions, restitution, Poisson's ratio, E/(rho g d), and the test in units of d. A
run of one size therefore gives the responses of every other size.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import astuple, dataclass
from functools import cached_property
from typing import Any

from grainfit.bulk_tests.abilities import HasUserFunctions
from grainfit.bulk_tests.base import BulkTest
from grainfit.bulk_tests.parameter_names import DENSITY
from grainfit.bulk_tests.registry import recreate_test
from grainfit.contact_models.hertz_mindlin.model import particle_moduli
from grainfit.contact_models.registry import material_parameter, with_defaults
from grainfit.errors import InputError
from grainfit.materials.walls import PLAIN, material_on, walls_among
from grainfit.options.kinds import Quantity
from grainfit.run_definition import RunDefinition, identity_of
from grainfit.units import powers

#: Digits to which lengths and times of a test agree: conversions lose the last ones.
_DIGITS = 9
#: Walls of steel are all the same to soft particles: their stiffness agrees to this share.
_WALL_TOLERANCE = 1e-3
_TOLERANCE = 1e-9
#: Ratios of the stiffness of a contact with a wall to that of two particles.
_WALL_RATIOS = ("normal stiffness of walls", "tangential stiffness of walls")
_WALL = "wall."


@dataclass(frozen=True)
class Scale:
    """Natural units of a run.

    Parameters
    ----------
    length : float
        Sauter diameter, m.
    density : float
        Of the particles, kg/m^3.
    gravity : float
        m/s^2.
    """

    length: float
    density: float
    gravity: float

    def is_same(self, other: Scale) -> bool:
        """Return True if both are the same but for rounding errors."""
        pairs = zip(astuple(self), astuple(other), strict=True)
        return all(math.isclose(one, two, rel_tol=_TOLERANCE) for one, two in pairs)

    def of(self, unit: str) -> float:
        """Return the natural unit of a quantity in its SI unit.

        Examples
        --------
        >>> round(Scale(0.01, 2000.0, 10.0).of("Pa"), 6)
        200.0
        """
        mass, length, time = powers(unit)
        units = (self.density * self.length**3, self.length, math.sqrt(self.length / self.gravity))
        return float(units[0] ** mass * units[1] ** length * units[2] ** time)


@dataclass(frozen=True)
class NaturalRun:
    """A run of a bulk test without its scale.

    Parameters
    ----------
    model : mapping
        Solver, version, and the test in natural units, as JSON.
    numbers : mapping of str to float
        Dimensionless material parameters and loads.
    scale : Scale
        The natural units.
    test : BulkTest
        The test, in SI units.
    """

    model: Mapping[str, Any]
    numbers: Mapping[str, float]
    scale: Scale
    test: BulkTest

    @cached_property
    def model_hash(self) -> str:
        """Hash of the model, the same for all sizes."""
        return identity_of(self.model)

    def is_same(self, other: NaturalRun) -> bool:
        """Return True if both are the same run, at two scales."""
        if self.model_hash != other.model_hash or self.numbers.keys() != other.numbers.keys():
            return False
        return all(
            math.isclose(
                value,
                other.numbers[name],
                rel_tol=_WALL_TOLERANCE if name.startswith(_WALL_RATIOS) else _TOLERANCE,
                abs_tol=1e-12,
            )
            for name, value in self.numbers.items()
        )


def natural_run(definition: RunDefinition) -> NaturalRun | None:
    """Return a run in natural units; None for a model of the user, or a damaged definition."""
    try:
        test = recreate_test(definition)
        if test is None or isinstance(test, HasUserFunctions):
            return None
        material = with_defaults(definition.parameters)
        scale = Scale(test.sizes.sauter_diameter, material[DENSITY], float(test.gravity))
        numbers = _numbers_of_material(material, scale)
        options, loads = _options(test, scale)
    except (InputError, KeyError, TypeError, ValueError, ZeroDivisionError):
        return None
    recorded = dict(definition.model["test"])
    natural = {
        key: recorded[key]
        for key in ("type", "revision", "scenes", "deck", "packing")
        if key in recorded
    }
    natural |= test.sizes.definition()
    natural["diameters"] = [_rounded(d / scale.length) for d in test.sizes.diameters]
    model = {**definition.model, "test": {**natural, "options": options}}
    return NaturalRun(model, numbers | loads, scale, test)


def _numbers_of_material(material: Mapping[str, float], scale: Scale) -> dict[str, float]:
    numbers = {
        name: value / scale.of(unit_of_parameter(name))
        for name, value in material.items()
        # Walls do not move, and of their elasticity only the contact's stiffness matters.
        if name != DENSITY and not name.startswith(_WALL)
    }
    for wall in walls_among(name for name in material if name.startswith(_WALL)):
        numbers |= _wall_ratios(material_on(material, wall), wall)
    return numbers


def _wall_ratios(material: Mapping[str, float], wall: str) -> dict[str, float]:
    """Return the stiffness of contacts with a wall over that of contacts of two particles."""
    particles, walls = particle_moduli(material, "particle"), particle_moduli(material, "wall")
    ratios = (walls.young / particles.young, walls.shear / particles.shear)
    names = _WALL_RATIOS if wall == PLAIN else [f"{name}: {wall}" for name in _WALL_RATIOS]
    return dict(zip(names, ratios, strict=True))


def unit_of_parameter(name: str) -> str:
    """Return the SI unit of a material parameter.

    Raises
    ------
    KeyError
        There is none of this name.
    """
    known = material_parameter(name)
    if known is None:
        raise KeyError(name)
    return known.unit


def _options(test: BulkTest, scale: Scale) -> tuple[dict[str, Any], dict[str, float]]:
    """Return the options in natural units, those that contain a mass apart."""
    options: dict[str, Any] = {}
    loads: dict[str, float] = {}
    resolved = test.resolved_options()
    for key in test.option_keys():
        value = resolved[key.name]
        unit = key.kind.unit if isinstance(key.kind, Quantity) else None
        if value is None or not unit:
            options[key.name] = value
        elif powers(unit)[0]:
            loads[f"test.{key.name}"] = value / scale.of(unit)
        else:
            options[key.name] = _rounded(value / scale.of(unit))
    return options, loads


def _rounded(value: float) -> float:
    return float(f"{value:.{_DIGITS}g}")


def without_rounding_error(value: float) -> float:
    """Return a value without the digits that conversions lose."""
    return float(f"{value:.12g}")


def in_si(run: NaturalRun, scale: Scale) -> dict[str, float]:
    """Return the material parameters of a run at a scale, without those of walls."""
    values = {
        name: without_rounding_error(value * scale.of(known.unit))
        for name, value in run.numbers.items()
        if (known := material_parameter(name)) is not None
    }
    return {**values, DENSITY: scale.density}


def natural_hash(definition: RunDefinition) -> str:
    """Return the hash of a run's model without its scale; empty for a model of the user."""
    run = natural_run(definition)
    return "" if run is None else run.model_hash
