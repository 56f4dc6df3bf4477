"""The largest time step of a bulk test: what its contact law and the stress on its bed allow."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping

from grainfit.bulk_tests.abilities import is_of_user
from grainfit.bulk_tests.base import TIME_STEP_FRACTION, BulkTest
from grainfit.bulk_tests.parameter_names import DENSITY, MODULUS
from grainfit.bulk_tests.stiffness import UnderLoad
from grainfit.contact_models.hertz_mindlin.model import clump_factor
from grainfit.contact_models.registry import contact_law, simulated_material
from grainfit.materials.particle_shape import ASPECT_RATIO, NEAREST_CLUMP
from grainfit.materials.sizes import ParticleSizes
from grainfit.scenes.packing import mean_particle_volume

#: Solid height of a bed whose cross-section changes, in diameters: that of most default tests.
_USUAL_LAYERS = 7.0
#: Power of Young's modulus that the number of time steps of a run follows, up to the stiffest bed:
#: that of the Rayleigh time step, less that of the share of it that is safe.
STEPS_BY_MODULUS = 1 / 2 - 1 / 6
#: Smallest share that is rounded down to a percent.
_PERCENT = 0.01
_LOWER_IS_WORSE = (".restitution", ".youngs_modulus")


def least_stable(intervals: Mapping[str, tuple[float, float]]) -> dict[str, float]:
    """Return the material within intervals that needs the smallest share of the Rayleigh time step.

    That is the softest and heaviest one with the lowest restitution, and the most friction, damping
    and cohesion.

    Parameters
    ----------
    intervals : mapping of str to tuple of float
        Ends of the interval of every parameter by dotted name; twice the value of a fixed one.
    """
    return {name: e[0] if name.endswith(_LOWER_IS_WORSE) else e[1] for name, e in intervals.items()}


def least_safe_fraction(
    test: BulkTest,
    intervals: Mapping[str, tuple[float, float]],
    contact_models: Iterable[str] = (),
) -> float:
    """Return the largest share of the Rayleigh time step that is safe within intervals.

    That of `least_stable`; of clumps, at either end of their aspect ratio: near 1 more of their
    spheres touch at once, and slender ones have smaller spheres.
    """
    material = least_stable(intervals)
    low, high = intervals.get(ASPECT_RATIO, (1.0, 1.0))
    if low == high:
        return safe_time_step_fraction(test, material, contact_models)
    ends = (max(low, NEAREST_CLUMP), high)
    return min(
        safe_time_step_fraction(test, {**material, ASPECT_RATIO: ratio}, contact_models)
        for ratio in ends
    )


def safe_time_step_fraction(
    test: BulkTest, material: Mapping[str, float], contact_models: Iterable[str] = ()
) -> float:
    """Return the largest safe share of the Rayleigh time step of a test.

    That of the contact law, under the stress of the test and the weight of all its particles on its
    cross-section. More than `TIME_STEP_FRACTION` is not measured of clumps, which
    touch in several places at once, and of cohesive particles; of a test that a user has written,
    the stress is not known.

    Parameters
    ----------
    test : BulkTest
        The test.
    material : mapping of str to float
        Values by dotted name; of free parameters those of `least_stable`.
    contact_models : iterable of str
        Contact models that replace the usual ones of their kind.
    """
    law = contact_law(material, contact_models)
    sizes = test.sizes
    if is_of_user(test) or law.cohesion is not None or sizes.shape is not None:
        return fraction_in_any_bed(sizes, material, contact_models)
    values = simulated_material(material, sizes.coarse_graining)
    return law.time_step_fraction(values, sizes.rayleigh_radius, _largest_stress(test, material))


def fraction_in_any_bed(
    sizes: ParticleSizes, material: Mapping[str, float], contact_models: Iterable[str] = ()
) -> float:
    """Return the largest safe share of the Rayleigh time step where the stress is not known."""
    law = contact_law(material, contact_models)
    values = simulated_material(material, sizes.coarse_graining)
    sizes = sizes.with_aspect_ratio(material.get(ASPECT_RATIO))
    factor = 1.0 if sizes.clump is None else clump_factor(values, sizes.clump.touching)
    share = factor * law.time_step_fraction(values, sizes.rayleigh_radius, None)
    return min(share, TIME_STEP_FRACTION)


def usual_time_step_fraction(
    test: BulkTest,
    intervals: Mapping[str, tuple[float, float]],
    contact_models: Iterable[str] = (),
) -> float:
    """Return the default share of the Rayleigh time step of a test in a calibration.

    The safe one with every free parameter, rounded down, because it is part of a run's identity.
    See `least_safe_fraction`.
    """
    return rounded_down(min(least_safe_fraction(test, intervals, contact_models), 1.0))


def rounded_down(share: float) -> float:
    """Return a share of the Rayleigh time step in whole percent, a small one in hundredths.

    Examples
    --------
    >>> rounded_down(0.0434), rounded_down(0.12), rounded_down(0.00567)
    (0.04, 0.12, 0.0056)
    """
    digits = 100 if share >= _PERCENT else 10_000
    return math.floor(digits * share + 1e-9) / digits


def with_safe_time_step(
    test: BulkTest,
    intervals: Mapping[str, tuple[float, float]],
    contact_models: Iterable[str] = (),
) -> BulkTest:
    """Return a test with a time step of the usual share at most, see `usual_time_step_fraction`."""
    usual = usual_time_step_fraction(test, intervals, contact_models)
    return test.with_time_step_fraction(usual) if usual < test.setup.time_step_fraction else test


def _largest_stress(test: BulkTest, material: Mapping[str, float]) -> float:
    """Stress at the bottom of a test, without friction at walls, Pa."""
    diameter = test.sizes.sauter_diameter
    try:
        count = test.of_material(material).number_of_particles
        volume = count * mean_particle_volume(test.sizes)
        height = volume / test.footprint.area
    except NotImplementedError:
        height = _USUAL_LAYERS * diameter
    load = material[MODULUS] / test.stiffness_number(material) if isinstance(test, UnderLoad) else 0
    return material[DENSITY] * float(test.gravity) * height + load
