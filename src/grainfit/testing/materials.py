"""Materials from the literature, for tests and comparisons."""

from collections.abc import Mapping

#: Glass beads of Rackl, Görnig, Hanley & Günthner (ECCOMAS 2016), table 1: all 14 parameters, SI.
GLASS_BEADS: Mapping[str, float] = {
    "particle.youngs_modulus": 3.6e5,
    "particle.poissons_ratio": 0.22,
    "particle.density": 2100.0,
    "wall.youngs_modulus": 2.11e11,
    "wall.poissons_ratio": 0.30,
    "wall.density": 7700.0,
    "particle_particle.sliding_friction": 0.18,
    "particle_particle.rolling_friction": 0.67,
    "particle_particle.restitution": 0.79,
    "particle_particle.rolling_damping": 0.25,
    "particle_wall.sliding_friction": 0.27,
    "particle_wall.rolling_friction": 0.005,
    "particle_wall.restitution": 0.82,
    "particle_wall.rolling_damping": 0.25,
}

#: Rough, soft spheres at which bulk tests are compared in the documentation: with a diameter of
#: 10 mm, Young's modulus over density, gravity and diameter is 1750. SI.
ROUGH_SPHERES: Mapping[str, float] = {
    **GLASS_BEADS,
    "particle_particle.sliding_friction": 0.5,
    "particle_particle.rolling_friction": 0.2,
    "particle_particle.restitution": 0.6,
    "particle_wall.sliding_friction": 0.4,
    "particle_wall.rolling_friction": 0.1,
    "particle_wall.restitution": 0.6,
}

#: Options of a heap on a plate with the particles glued to it, and a sliding friction of 0.5.
ROUGH_PLATE: Mapping[str, float | str] = {
    "plate_sliding_friction": 0.5,
    "plate_rolling_friction": "particle_particle",
}


def rough_plate_of(test: str) -> Mapping[str, float | str]:
    """Return these options for a bulk test that has a plate; none for others."""
    return ROUGH_PLATE if test in ("funnel", "heap") else {}
