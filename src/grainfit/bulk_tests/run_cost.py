"""Estimated cost of one DEM run."""

from __future__ import annotations

from dataclasses import dataclass

from grainfit.formatting import duration


@dataclass(frozen=True)
class RunCost:
    """Estimated cost of one run.

    Parameters
    ----------
    time_step : float
        Time step, exact, s.
    steps : int
        Estimated number of time steps.
    wall_seconds : float
        Estimated wall time on an otherwise idle core.
    particles : int, optional
        Number of particles, glued ones included.
    time_step_fraction : float, optional
        Time step over the Rayleigh time step.
    spheres : int
        Number of spheres of each particle.
    """

    time_step: float
    steps: int
    wall_seconds: float
    particles: int | None = None
    time_step_fraction: float | None = None
    spheres: int = 1

    def __str__(self) -> str:
        particles = "particle" if self.particles == 1 else "particles"
        if self.spheres > 1:
            particles += f" of {self.spheres} spheres"
        words = "" if self.particles is None else f"{self.particles} {particles}, "
        words += f"time step {self.time_step:.3g} s"
        if self.time_step_fraction is not None:
            words += f" ({self.time_step_fraction:.0%} of the Rayleigh time step)"
        return f"{words}, about {self.steps:,} steps, about {duration(self.wall_seconds)} a run"
