"""Speed of a DEM program on one core of a current processor."""

from __future__ import annotations

from dataclasses import dataclass

from grainfit.bulk_tests.workload import Workload
from grainfit.solvers.run_cost import RunCost

#: Spheres that fit into the cache; with more, the speed falls by this power of their number.
_CACHED_SPHERES = 10_000
_CACHE_EXPONENT = 0.15
#: Two ranks are about 15 % faster than one: a bulk test is too small to share.
_RANKS_EXPONENT = 0.2


def gain_of_ranks(ranks: int) -> float:
    """Return how many times as fast as one a number of MPI ranks simulates a run."""
    return float(ranks**_RANKS_EXPONENT)


@dataclass(frozen=True)
class Speed:
    """Speed of a DEM program.

    Parameters
    ----------
    sphere_steps : float
        Spheres times time steps per second, as long as they fit into the cache of the processor.
    """

    sphere_steps: float

    @classmethod
    def of_run(cls, workload: Workload, seconds: float) -> Speed:
        """Return the speed with which a run took as many seconds.

        Examples
        --------
        >>> Speed.of_run(Workload(1e-5, 1000, 40_000, 1, 0.1), 50.0).cost(
        ...     Workload(1e-5, 1000, 40_000, 1, 0.1)
        ... ).wall_seconds
        50.0
        """
        return cls(cls(1.0).cost(workload).wall_seconds / seconds)

    def cost(self, workload: Workload, ranks: int = 1) -> RunCost:
        """Estimate the cost of a run."""
        spheres = workload.particles * workload.spheres
        speed = self.sphere_steps * gain_of_ranks(ranks)
        speed *= min(_CACHED_SPHERES / spheres, 1.0) ** _CACHE_EXPONENT
        return RunCost(**vars(workload), wall_seconds=workload.steps * spheres / speed)
