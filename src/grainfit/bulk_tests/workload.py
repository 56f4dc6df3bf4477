"""Amount of computation in one run of a bulk test, whatever program computes it."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

from grainfit.materials.particle_shape import ASPECT_RATIO

if TYPE_CHECKING:
    from grainfit.bulk_tests.base import BulkTest


@dataclass(frozen=True)
class Workload:
    """Amount of computation in one run.

    Parameters
    ----------
    time_step : float
        Time step, exact, s.
    steps : int
        Estimated number of time steps.
    particles : int
        Number of particles, glued ones included.
    spheres : int
        Number of spheres of each particle.
    time_step_fraction : float
        Time step over the Rayleigh time step.
    """

    time_step: float
    steps: int
    particles: int
    spheres: int
    time_step_fraction: float


def workload(test: BulkTest, material: Mapping[str, float]) -> Workload:
    """Estimate the amount of computation in one run of a test.

    Parameters
    ----------
    test : BulkTest
        The test.
    material : mapping of str to float
        At least density, Young's modulus and Poisson's ratio of the particles.
    """
    step = test.time_step(material)
    clump = test.sizes.with_aspect_ratio(material.get(ASPECT_RATIO)).clump
    return Workload(
        time_step=step,
        steps=math.ceil(test.simulated_time(material) / step),
        particles=test.of_material(material).number_of_particles,
        spheres=1 if clump is None else len(clump),
        time_step_fraction=test.setup.time_step_fraction,
    )
