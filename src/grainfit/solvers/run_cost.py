"""Estimated cost of one DEM run."""

from __future__ import annotations

from dataclasses import dataclass

from grainfit.bulk_tests.workload import Workload
from grainfit.formatting import duration


@dataclass(frozen=True)
class RunCost(Workload):
    """Estimated cost of one run.

    Parameters
    ----------
    time_step, steps, particles, spheres, time_step_fraction
        As of a `Workload`.
    wall_seconds : float
        Estimated wall time on an otherwise idle core.
    """

    wall_seconds: float

    def __str__(self) -> str:
        particles = "particle" if self.particles == 1 else "particles"
        if self.spheres > 1:
            particles += f" of {self.spheres} spheres"
        return (
            f"{self.particles} {particles}, time step {self.time_step:.3g} s "
            f"({self.time_step_fraction:.0%} of the Rayleigh time step), "
            f"about {self.steps:,} steps, about {duration(self.wall_seconds)} a run"
        )
