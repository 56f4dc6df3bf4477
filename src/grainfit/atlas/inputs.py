"""Inputs of the atlas: a material and an apparatus as dimensionless numbers, and back."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any, NamedTuple, cast

from grainfit.bulk_tests.base import BulkTest
from grainfit.bulk_tests.natural_units import Scale
from grainfit.bulk_tests.parameter_names import (
    DENSITY,
    MODULUS,
    RESTITUTION,
    ROLLING,
    SLIDING,
    WALL_RESTITUTION,
    WALL_ROLLING,
    WALL_SLIDING,
)
from grainfit.bulk_tests.size import CanBeResized
from grainfit.bulk_tests.stiffness import UnderLoad, stiffness_number
from grainfit.bulk_tests.time_steps import usual_time_step_fraction
from grainfit.bulk_tests.varied_options import InAtlas, Range, VariedOptions

STIFFNESS, SIZE = "stiffness", "size"
#: Overlaps of Hertz contacts, and what they add to a response, follow this power of the stiffness.
_OVERLAP = -2 / 3
#: Frictions, and the restitution of all contacts.
MATERIAL: Mapping[str, Range] = {
    SLIDING: Range(0.05, 1.5, power=0),
    # Below 0.05 hardly any heap is one: fewer rows are there than on a logarithmic scale.
    ROLLING: Range(0.01, 1.5, power=0.3),
    WALL_SLIDING: Range(0.05, 1.2, power=0),
    WALL_ROLLING: Range(0.005, 0.8, power=0),
    RESTITUTION: Range(0.2, 0.9),
}
#: Young's modulus over the stress that presses particles together.
_UNDER_OWN_WEIGHT = Range(1500.0, 20_000.0, power=_OVERLAP)
_UNDER_A_STRESS = Range(1000.0, 20_000.0, power=_OVERLAP)
#: Of the rows, in SI units; all others follow in natural units.
ROW_SCALE = Scale(0.01, 2000.0, 9.81)
#: Parameters of the rows that responses hardly depend on, or not at all with stiff walls.
_FIXED: Mapping[str, float] = {
    DENSITY: ROW_SCALE.density,
    "particle.poissons_ratio": 0.3,
    "wall.youngs_modulus": 2.11e11,
    "wall.poissons_ratio": 0.3,
    "wall.density": 7700.0,
    "particle_particle.rolling_damping": 0.0,
    "particle_wall.rolling_damping": 0.0,
}


class Simulated(NamedTuple):
    """A test and a material that can be simulated."""

    test: BulkTest
    material: Mapping[str, float]


def ranges_of(kind: type[BulkTest]) -> dict[str, Range]:
    """Return the ranges of all inputs of a test in the atlas, by name of the input.

    Parameters
    ----------
    kind : type
        Class of a test that is `InAtlas`.
    """
    varied = varied_of(kind)
    # A class, not a test: all that the protocol asks for is in it.
    usual = _UNDER_A_STRESS if isinstance(kind, UnderLoad) else _UNDER_OWN_WEIGHT
    return {**MATERIAL, STIFFNESS: varied.stiffness or usual, **varied.ranges}


def varied_of(kind: type[BulkTest]) -> VariedOptions:
    """Return what the rows of a test vary of its apparatus."""
    return cast(InAtlas, kind).varied


def simulated(kind: type[BulkTest], inputs: Mapping[str, float]) -> Simulated:
    """Return test and material of a row of the atlas.

    Raises
    ------
    InputError
        The apparatus is impossible.
    """
    test = apparatus(kind, inputs, ROW_SCALE)
    material = {
        **_FIXED,
        **{name: inputs[name] for name in MATERIAL},
        WALL_RESTITUTION: inputs[RESTITUTION],
        MODULUS: 1.0,
    }
    material[MODULUS] = inputs[STIFFNESS] / stiffness_number(test, material)
    ends = {name: (value, value) for name, value in material.items()}
    fraction = usual_time_step_fraction(test, ends)
    return Simulated(replace(test, time_step_fraction=fraction), material)


def apparatus(kind: type[BulkTest], inputs: Mapping[str, float], scale: Scale) -> BulkTest:
    """Return a test in the apparatus of a row, at any scale."""
    varied = varied_of(kind)
    usual = kind(diameter=scale.length, gravity=scale.gravity, **varied.same)
    options: dict[str, Any] = {**varied.same, **_at_size(usual, varied, inputs[SIZE])}
    values = usual.resolved_options()
    factors = {**varied.wider, **{name: inputs[name] for name in varied.factors}}
    for name, factor in factors.items():
        options[name] = factor * options.get(name, values[name])
    options |= {name: inputs[name] for name in varied.values}
    options |= {name: inputs[name] * scale.of("Pa") for name in varied.loads}
    return kind(diameter=scale.length, gravity=scale.gravity, **options)


def _at_size(usual: BulkTest, varied: VariedOptions, size: float) -> dict[str, Any]:
    found = cast(CanBeResized, usual).at_size(size)
    return {name: value for name, value in found.items() if name not in varied.left}
