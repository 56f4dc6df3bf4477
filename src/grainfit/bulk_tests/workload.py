"""Amount of computation in one run of a bulk test, whatever program computes it."""

from __future__ import annotations

from dataclasses import dataclass


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
