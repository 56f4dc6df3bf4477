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

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace

from grainfit.bulk_tests.parameter_names import (
    DENSITY,
    MODULUS,
    RESTITUTION,
    ROLLING,
    SLIDING,
    WALL_RESTITUTION,
    WALL_SLIDING,
)
from grainfit.bulk_tests.registry import bulk_tests
from grainfit.formatting import in_a_row
from grainfit.materials.particle_shape import ASPECT_RATIO
from grainfit.materials.walls import plain_name
from grainfit.which_test import messages

_ENERGY_DENSITY = "particle_particle.cohesion_energy_density"
_DROP_TEST = "fix it from a drop test (height to which a particle rebounds"


@dataclass(frozen=True)
class _Way:
    """A measurement that determines a parameter.

    Parameters
    ----------
    text : str
        Description. Fields such as ``{heap}`` are the types of tests, for the calibration file, as
        far as they are installed.
    responses : tuple of str
        Responses of one test that are measured.
    tests : int
        Number of such tests.
    """

    text: str
    responses: tuple[str, ...] = ()
    tests: int = 1

    def is_measured(self, measured: Collection[str]) -> bool:
        """Return whether a calibration with these targets has it, whatever its tests are called."""
        having = [
            {name.rpartition(".")[0] for name in measured if name.rpartition(".")[2] == response}
            for response in self.responses
        ]
        return bool(having) and len(set.intersection(*having)) >= self.tests


_BULK_DENSITY = _Way(
    "the bulk density ({packing}at a particle density that a pycnometer has determined)",
    ("bulk_density",),
)
_DRAW_DOWN = _Way(
    "a draw-down test ({draw_down}angle of repose, mass flow)", ("angle_of_repose", "mass_flow")
)
_COMPRESSION = _Way(
    "uniaxial compression ({compression}lateral stress ratio)", ("lateral_stress_ratio",)
)

#: Measurements that respond to one parameter and to little else, by the parameter's name.
TESTS: Mapping[str, tuple[_Way, ...]] = {
    SLIDING: (
        replace(
            _BULK_DENSITY,
            text="the bulk density ({packing}at a particle density that a pycnometer has "
            "determined; it falls with sliding friction, and hardly with rolling friction)",
        ),
        _DRAW_DOWN,
        _COMPRESSION,
    ),
    ROLLING: (
        _Way(
            "the angle of repose of a heap ({heap}at a sliding friction that another test "
            "determines)",
            ("angle_of_repose",),
        ),
    ),
    RESTITUTION: (
        _Way(f"none of grainfit's tests does; {_DROP_TEST} from a plate of the same material)"),
    ),
    WALL_SLIDING: (
        _Way(
            "an inclined plane of the wall's material: the angle at which the bulk solid slides is "
            "atan(sliding friction), so the value is known without a simulation; a heap hardly "
            "depends on that of its cylinder"
        ),
    ),
    "particle_wall.rolling_friction": (
        _Way(
            "an inclined plane of the wall's material: the angle at which single particles begin "
            "to roll is atan(rolling friction), so the value is known without a simulation"
        ),
    ),
    WALL_RESTITUTION: (
        _Way(f"none of grainfit's tests does; {_DROP_TEST} from the wall's material)"),
    ),
    DENSITY: (
        _Way(
            "a pycnometer (density of the solid); bulk densities and mass flows are proportional "
            "to it, and angles do not depend on it"
        ),
    ),
    MODULUS: (
        _Way(
            "uniaxial compression ({compression}modulus of loading and unloading), which alone "
            "depends on it as a bulk property; without that test, fix it: stiff enough that "
            "overlaps do not add to the bulk density, see 'grainfit stiffness'",
            ("loading_modulus", "unloading_modulus"),
        ),
    ),
    ASPECT_RATIO: (
        _Way("photographs of particles (largest extent over width)"),
        _Way(
            "the bulk density ({packing}at a known particle density) beside an angle of repose: "
            "the angle grows with the aspect ratio, the bulk density is highest near 1.5",
            ("bulk_density", "angle_of_repose"),
        ),
    ),
    "particle_particle.surface_energy": (
        _Way(
            "a shear test ({shear}angle of internal friction) at two normal stresses or more: "
            "their yield locus has a cohesion",
            ("internal_friction_angle",),
            tests=2,
        ),
    ),
    _ENERGY_DENSITY: (
        _Way(
            "the angle of repose of a heap ({heap}at frictions that tests of the dry material "
            "determine)",
            ("angle_of_repose",),
        ),
    ),
}

#: Limits of what bulk tests say of a parameter.
_LIMITS = {
    ROLLING: (
        "where rolling friction is larger than sliding friction, none of grainfit's tests "
        "determines it well"
    )
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


def determining_tests(name: str, measured: Collection[str] = ()) -> str:
    """Return sentences with a test that would determine an open parameter.

    Parameters
    ----------
    name : str
        The parameter.
    measured : collection of str
        Names of the targets that there are, which are not proposed again.
    """
    if plain_name(name) in BETTER_FIXED:
        return better_fixed(name)
    return messages.TO_DETERMINE(name=name, how=how_to_determine(name, measured))


def other_measurement(name: str, measured: Collection[str] = ()) -> str:
    """Return sentences on an open parameter that no bulk test settles; "" if nothing is known."""
    plain = plain_name(name)
    is_known = plain in {*TESTS, *BETTER_FIXED} and plain not in _FROM_BULK_TESTS
    return determining_tests(name, measured) if is_known else ""


def separating_tests(names: tuple[str, ...], measured: Collection[str] = ()) -> str:
    """Return sentences with tests that would tell parameters apart."""
    return messages.TO_TELL_APART(names=in_a_row(names), how=how_to_tell_apart(names, measured))


def better_fixed(name: str) -> str:
    """Return a sentence about a parameter of `BETTER_FIXED`."""
    return messages.BETTER_FIXED(name=name, where=BETTER_FIXED[plain_name(name)])


def how_to_determine(name: str, measured: Collection[str] = ()) -> str:
    """Return the tests that determine a parameter, up to the end of a sentence."""
    plain = plain_name(name)
    if plain not in TESTS:
        return messages.ADD_A_TARGET()
    limit = f"; {_LIMITS[plain]}" if plain in _LIMITS else ""
    how = _described(TESTS[plain], measured) or _measured_already(TESTS[plain])
    return f"{how}{limit}."


def how_to_tell_apart(names: tuple[str, ...], measured: Collection[str] = ()) -> str:
    """Return the tests that tell parameters apart, up to the end of a sentence."""
    if set(names) >= _FRICTIONS and set(names) <= {*_FRICTIONS, DENSITY}:
        ways = (_BULK_DENSITY, _DRAW_DOWN, _COMPRESSION)
        if DENSITY in names:
            density = "give the particle density (pycnometer)"
            if not _BULK_DENSITY.is_measured(measured):
                density += " and measure the bulk density"
            ways = (_Way(density), *ways[1:])
        tests = _described(ways, measured) or _measured_already(ways)
        return messages.ANGLES_DO_NOT_HELP(tests=tests)
    known = [name for name in names if plain_name(name) in TESTS]
    if not known:
        return messages.ADD_A_TARGET_OF_ONE()
    ways_of = {name: TESTS[plain_name(name)] for name in known}
    found = [
        f"for {name}, {own}"
        for name, ways in ways_of.items()
        if (own := _described(ways, measured))
    ]
    if not found:
        found = [f"for {name}, {_measured_already(ways)}" for name, ways in ways_of.items()]
    return messages.DETERMINE_ONE(tests="; ".join(found))


def _described(ways: Sequence[_Way], measured: Collection[str]) -> str:
    """Return the measurements that are not there yet; "" if all are."""
    left = [_with_types(way.text) for way in ways if not way.is_measured(measured)]
    if len(left) > 1:
        left[-1] = f"or {left[-1]}"
    return "; ".join(left)


def _measured_already(ways: Sequence[_Way]) -> str:
    responses = dict.fromkeys(name.replace("_", " ") for way in ways for name in way.responses)
    return messages.MEASURED_ALREADY(
        responses=in_a_row(responses), is_measured="is" if len(responses) == 1 else "are"
    )


def _with_types(tests: str) -> str:
    """Return a text with the types of tests that are installed; the others are left out."""
    known = bulk_tests()
    types = {name: f'type = "{name}": ' if name in known else "" for name in _TYPES}
    return tests.format(**types)
