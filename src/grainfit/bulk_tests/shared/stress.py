"""Stresses of plates and pistons: defaults that follow the particles, limits by their stiffness."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from grainfit.bulk_tests.shared import messages
from grainfit.contact_models.contact import particle_mass
from grainfit.errors import Fault
from grainfit.materials.sizes import ParticleSizes
from grainfit.scenes.scene import STANDARD_GRAVITY

_REFERENCE_DIAMETER = 0.010
_REFERENCE_GRAVITY = 9.81


def scaled_stress(reference: float, sizes: ParticleSizes, gravity: float) -> float:
    """Return a stress that is proportional to diameter and gravity, Pa.

    The weight of a bed is, too, so that the test is the same test at every size.

    Parameters
    ----------
    reference : float
        The stress for particles of 10 mm on Earth, Pa.
    sizes : ParticleSizes
        With the Sauter diameter.
    gravity : float
        m/s^2.
    """
    scale = sizes.sauter_diameter / _REFERENCE_DIAMETER * gravity / _REFERENCE_GRAVITY
    return reference * scale


def softness_faults(
    key: str, stress: float, material: Mapping[str, float], smallest: float, otherwise: str
) -> Iterator[Fault]:
    """Yield why particles are too soft for a stress.

    Parameters
    ----------
    key : str
        Option of the stress.
    stress : float
        Pa.
    material : mapping of str to float
        Material parameters by dotted name: those that are known.
    smallest : float
        Smallest Young's modulus over stress.
    otherwise : str
        Consequence of softer particles, as the end of a sentence.
    """
    modulus = material.get("particle.youngs_modulus")
    if modulus is not None and modulus < (1 - 1e-9) * smallest * stress:
        yield messages.TOO_SOFT.fault(
            key,
            stress=stress,
            modulus=modulus,
            ratio=modulus / stress,
            smallest=smallest,
            otherwise=otherwise,
            least=smallest * stress,
            most=modulus / smallest,
        )


def typical_load(stress: float, diameter: float, material: Mapping[str, float]) -> float:
    """Return the usual force of a contact under a stress, in particle weights on Earth.

    Parameters
    ----------
    stress : float
        Pa.
    diameter : float
        Of the particles, m.
    material : mapping of str to float
        Material parameters by dotted name.
    """
    weight = particle_mass(material, diameter / 2) * STANDARD_GRAVITY
    return float(stress * diameter**2 / weight)
