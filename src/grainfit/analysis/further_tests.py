"""Recommend bulk tests that determine a material parameter.

The words follow measured sensitivities (docs/choosing_tests.md): heap, rotating drum and angle of
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

#: Laboratory measurements that give a parameter its value, so that it need not be free.
DIRECT: Mapping[str, str] = {
    DENSITY: "a pycnometer",
    ASPECT_RATIO: "photographs of particles",
    WALL_SLIDING: "an inclined plane",
}

#: Values for parameters that hardly change any common bulk test and are better fixed.
BETTER_FIXED: Mapping[str, str] = {
    "particle.poissons_ratio": "at a handbook's value",
    "wall.poissons_ratio": "at a handbook's value",
    "wall.youngs_modulus": "at that of the particles",
    "wall.density": "at any value: walls do not move",
    "particle_particle.rolling_damping": "at a value of the literature",
    "particle_wall.rolling_damping": "at a value of the literature",
}

#: Types of test that are named.
_TYPES = ("compression", "draw_down", "heap", "packing", "shear")
_FRICTIONS = frozenset({SLIDING, ROLLING})
#: Parameters that nothing but bulk tests determines.
_FROM_BULK_TESTS = _FRICTIONS | {MODULUS}


def to_settle(name: str) -> str:
    """Return sentences with a test that would determine an open parameter."""
    if plain_name(name) in BETTER_FIXED:
        return better_fixed(name)
    return f"To determine {name}: {how_to_determine(name)}"


def without_the_bench(name: str) -> str:
    """Return sentences on an open parameter that no bulk test settles; "" if nothing is known."""
    plain = plain_name(name)
    is_known = plain in {*TESTS, *BETTER_FIXED} and plain not in _FROM_BULK_TESTS
    return to_settle(name) if is_known else ""


def to_tell_apart(names: tuple[str, ...]) -> str:
    """Return sentences with tests that would tell parameters apart."""
    return f"To tell {in_a_row(names)} apart: {how_to_tell_apart(names)}"


def better_fixed(name: str) -> str:
    """Return a sentence about a parameter of `BETTER_FIXED`."""
    return (
        f"{name} hardly changes any common bulk test: take it out of the free parameters and "
        f"fix it {BETTER_FIXED[plain_name(name)]}."
    )


def how_to_determine(name: str) -> str:
    """Return the tests that determine a parameter, up to the end of a sentence."""
    words = TESTS.get(plain_name(name))
    if words is None:
        return "add a target of a test that responds to it."
    return f"{_with_types(words)}."


def how_to_tell_apart(names: tuple[str, ...]) -> str:
    """Return the tests that tell parameters apart, up to the end of a sentence."""
    if set(names) >= _FRICTIONS and set(names) <= {*_FRICTIONS, DENSITY}:
        return (
            f"{_with_types(f'{_bulk_density(names)}; {_DRAW_DOWN}; or {_COMPRESSION}')}. Another "
            "angle does not help: heap, rotating drum and angle of internal friction depend on "
            "both frictions in nearly the same way."
        )
    known = [
        f"for {name}, {_with_types(words)}"
        for name in names
        if (words := TESTS.get(plain_name(name))) is not None
    ]
    if not known:
        return "add a target of a test that responds to one of them only."
    return f"determine one of them; {'; '.join(known)}."


def _bulk_density(names: tuple[str, ...]) -> str:
    if DENSITY in names:
        return "give the particle density (pycnometer) and measure the bulk density"
    return "the bulk density ({packing}at a particle density that a pycnometer has determined)"


def _with_types(words: str) -> str:
    """Return words with the types of tests that are installed; the others are left out."""
    known = bulk_tests()
    types = {name: f'type = "{name}": ' if name in known else "" for name in _TYPES}
    return words.format(**types)
