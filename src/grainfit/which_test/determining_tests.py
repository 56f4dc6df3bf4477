"""Tests that determine a material parameter, for the sentences that recommend them.

The texts follow measured sensitivities (docs/choosing_tests.md): heap, rotating drum and angle of
internal friction depend on both frictions of the particles in nearly the same way, so none of them
tells sliding from rolling friction beside another; bulk densities, a draw-down test and uniaxial
compression do.

References
----------
Coetzee (2017), Review: Calibration of the discrete element method, *Powder Technology* 310,
104-142.
Coetzee & Els (2009), Calibration of discrete element parameters and the modelling of silo
discharge and bucket filling, *Computers and Electronics in Agriculture* 65, 198-212: confined
compression for stiffness.
Roessler, Richter, Katterfeld & Will (2019), Development of a standard calibration procedure for
the DEM parameters of cohesionless bulk materials - part I: Solving the problem of ambiguous
parameter combinations, *Powder Technology* 343, 803-812: draw-down test; one angle of repose fits
many pairs of frictions.
"""

from __future__ import annotations

from collections.abc import Mapping

from grainfit.bulk_tests.registry import bulk_tests
from grainfit.bulk_tests.sensitivities import (
    DENSITY,
    MODULUS,
    RESTITUTION,
    ROLLING,
    SLIDING,
    WALL_RESTITUTION,
    WALL_SLIDING,
)
from grainfit.formatting import in_a_row
from grainfit.materials.particle_shape import ASPECT_RATIO
from grainfit.materials.walls import plain_name
from grainfit.which_test import messages

_ENERGY_DENSITY = "particle_particle.cohesion_energy_density"
_DROP_TEST = "fix it from a drop test (height to which a particle rebounds"

_DRAW_DOWN = "a draw-down test ({draw_down}angle of repose, mass flow)"
_COMPRESSION = "uniaxial compression ({compression}lateral stress ratio)"

#: Tests that respond to one parameter and to little else, by the parameter's name. Fields such as
#: ``{heap}`` are the types of tests, for the calibration file, as far as they are installed.
TESTS: Mapping[str, str] = {
    SLIDING: (
        "the bulk density ({packing}at a particle density that a pycnometer has determined; it "
        "falls with sliding friction, and hardly with rolling friction); "
        f"{_DRAW_DOWN}; or {_COMPRESSION}"
    ),
    ROLLING: (
        "the angle of repose of a heap ({heap}at a sliding friction that another test determines); "
        "where rolling friction is larger than sliding friction, none of grainfit's tests "
        "determines it well"
    ),
    RESTITUTION: (
        f"none of grainfit's tests does; {_DROP_TEST} from a plate of the same material)"
    ),
    WALL_SLIDING: (
        "an inclined plane of the wall's material: the angle at which the bulk solid slides is "
        "atan(sliding friction), so the value is known without a simulation; a heap hardly "
        "depends on that of its cylinder"
    ),
    "particle_wall.rolling_friction": (
        "an inclined plane of the wall's material: the angle at which single particles begin to "
        "roll is atan(rolling friction), so the value is known without a simulation"
    ),
    WALL_RESTITUTION: (f"none of grainfit's tests does; {_DROP_TEST} from the wall's material)"),
    DENSITY: (
        "a pycnometer (density of the solid); bulk densities and mass flows are proportional to "
        "it, and angles do not depend on it"
    ),
    MODULUS: (
        "uniaxial compression ({compression}modulus of loading and unloading), which alone "
        "depends on it as a bulk property; without that test, fix it: stiff enough that overlaps "
        "do not add to the bulk density, see 'grainfit stiffness'"
    ),
    ASPECT_RATIO: (
        "photographs of particles (largest extent over width); or the bulk density ({packing}at a "
        "known particle density) beside an angle of repose: the angle grows with the aspect "
        "ratio, the bulk density is highest near 1.5"
    ),
    "particle_particle.surface_energy": (
        "a shear test ({shear}angle of internal friction) at two normal stresses or more: their "
        "yield locus has a cohesion"
    ),
    _ENERGY_DENSITY: (
        "the angle of repose of a heap ({heap}at frictions that tests of the dry material "
        "determine)"
    ),
}

#: Parameters that a laboratory measures on their own, so that they need not be free.
DIRECT = frozenset({DENSITY, ASPECT_RATIO, WALL_SLIDING})

#: Values for parameters that hardly change any common bulk test and are better fixed.
BETTER_FIXED: Mapping[str, str] = {
    "particle.poissons_ratio": "at a handbook's value",
    "wall.poissons_ratio": "at a handbook's value",
    "wall.youngs_modulus": "at that of the particles",
    "wall.density": "at any value: walls do not move",
    "particle_particle.rolling_damping": "at 0, where all solvers have the same law",
    "particle_wall.rolling_damping": "at 0, where all solvers have the same law",
}

#: Types of test that are named.
_TYPES = ("compression", "draw_down", "heap", "packing", "shear")
_FRICTIONS = frozenset({SLIDING, ROLLING})
#: Parameters that nothing but bulk tests determines.
_FROM_BULK_TESTS = _FRICTIONS | {MODULUS}


def determining_tests(name: str) -> str:
    """Return sentences with a test that would determine an open parameter."""
    if plain_name(name) in BETTER_FIXED:
        return better_fixed(name)
    return messages.TO_DETERMINE(name=name, how=how_to_determine(name))


def other_measurement(name: str) -> str:
    """Return sentences on an open parameter that no bulk test settles; "" if nothing is known."""
    plain = plain_name(name)
    is_known = plain in {*TESTS, *BETTER_FIXED} and plain not in _FROM_BULK_TESTS
    return determining_tests(name) if is_known else ""


def separating_tests(names: tuple[str, ...]) -> str:
    """Return sentences with tests that would tell parameters apart."""
    return messages.TO_TELL_APART(names=in_a_row(names), how=how_to_tell_apart(names))


def better_fixed(name: str) -> str:
    """Return a sentence about a parameter of `BETTER_FIXED`."""
    return messages.BETTER_FIXED(name=name, where=BETTER_FIXED[plain_name(name)])


def how_to_determine(name: str) -> str:
    """Return the tests that determine a parameter, up to the end of a sentence."""
    tests = TESTS.get(plain_name(name))
    return messages.ADD_A_TARGET() if tests is None else f"{_with_types(tests)}."


def how_to_tell_apart(names: tuple[str, ...]) -> str:
    """Return the tests that tell parameters apart, up to the end of a sentence."""
    if set(names) >= _FRICTIONS and set(names) <= {*_FRICTIONS, DENSITY}:
        tests = f"{_bulk_density(names)}; {_DRAW_DOWN}; or {_COMPRESSION}"
        return messages.ANGLES_DO_NOT_HELP(tests=_with_types(tests))
    known = [
        f"for {name}, {_with_types(own)}"
        for name in names
        if (own := TESTS.get(plain_name(name))) is not None
    ]
    if not known:
        return messages.ADD_A_TARGET_OF_ONE()
    return messages.DETERMINE_ONE(tests="; ".join(known))


def _bulk_density(names: tuple[str, ...]) -> str:
    if DENSITY in names:
        return "give the particle density (pycnometer) and measure the bulk density"
    return "the bulk density ({packing}at a particle density that a pycnometer has determined)"


def _with_types(tests: str) -> str:
    """Return a text with the types of tests that are installed; the others are left out."""
    known = bulk_tests()
    types = {name: f'type = "{name}": ' if name in known else "" for name in _TYPES}
    return tests.format(**types)
