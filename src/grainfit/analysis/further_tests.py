"""Recommend common bulk tests that determine a material parameter.

References
----------
Coetzee (2017), Review: Calibration of the discrete element method, *Powder Technology* 310,
104-142.
Coetzee & Els (2009), Calibration of discrete element parameters and the modelling of silo
discharge and bucket filling, *Computers and Electronics in Agriculture* 65, 198-212: shear test
for friction, confined compression for stiffness.
Roessler, Richter, Katterfeld & Will (2019), Development of a standard calibration procedure for
the DEM parameters of cohesionless bulk materials - part I: Solving the problem of ambiguous
parameter combinations, *Powder Technology* 343, 803-812.
Lommen, Schott & Lodewijks (2014), DEM speedup: Stiffness effects on behavior of bulk material,
*Particuology* 12, 107-112.
"""

from __future__ import annotations

from collections.abc import Mapping

_DROP_TEST = "a drop test (height to which a particle rebounds"

#: Tests that respond to one parameter and to little else, by the parameter's name.
TESTS: Mapping[str, str] = {
    "particle_particle.sliding_friction": (
        "a shear test (direct or ring shear cell: angle of internal friction)"
    ),
    "particle_particle.rolling_friction": (
        "a rotating drum or a heap of another kind (dynamic or static angle of repose), at a "
        "sliding friction that a shear test has determined"
    ),
    "particle_particle.restitution": f"{_DROP_TEST} from a plate of the same material)",
    "particle_wall.sliding_friction": (
        "a wall shear test or an inclined plane (angle at which the material slides on the wall)"
    ),
    "particle_wall.rolling_friction": (
        "an inclined plane of the wall's material (angle at which single particles begin to roll)"
    ),
    "particle_wall.restitution": f"{_DROP_TEST} from the wall's material)",
    "particle.density": (
        "the bulk density of a filled container, or the density of the solid by a pycnometer"
    ),
    "particle.youngs_modulus": (
        "a uniaxial (confined) compression test, where the stiffness of the bulk matters; where "
        "it does not, fix it as low as your process allows, for a large time step"
    ),
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


def to_settle(name: str) -> str:
    """Return a sentence with a test that would determine an open parameter."""
    if name in TESTS:
        return f"To determine {name}: {TESTS[name]}."
    if name in BETTER_FIXED:
        return (
            f"{name} hardly changes any common bulk test: take it out of the free parameters and "
            f"fix it {BETTER_FIXED[name]}."
        )
    return f"To determine {name}: add a target of a test that responds to it."


def to_tell_apart(names: tuple[str, ...]) -> str:
    """Return a sentence with tests that would tell parameters apart."""
    known = [f"{TESTS[name]} for {name}" for name in names if name in TESTS]
    whole = " and ".join(filter(None, [", ".join(names[:-1]), names[-1]]))
    if not known:
        return f"To tell {whole} apart: add a target of a test that responds to one of them only."
    return f"To tell {whole} apart, one more test: {'; or '.join(known)}."
