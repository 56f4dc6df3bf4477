"""Speed of a DEM program on one core of a current processor."""

from __future__ import annotations

import math
from dataclasses import dataclass

from grainfit.bulk_tests.workload import Workload
from grainfit.solvers.run_cost import RunCost

#: Spheres that fit into the cache; with more, the speed falls by this power of their number.
_CACHED_SPHERES = 10_000
_CACHE_EXPONENT = 0.15
#: Spheres of which two MPI ranks gain nothing: what they share grows with their common surface.
#: Packings and heaps of 500 to 50,000 (`benchmarks/ranks.py`).
_TOO_FEW_TO_SHARE = 145.0


def gain_of_ranks(ranks: int, spheres: int) -> float:
    """Return how many times as fast as one a number of MPI ranks simulates a run.

    Two are measured; each doubling shares what the one before has left.

    Parameters
    ----------
    ranks : int
        MPI ranks of the run.
    spheres : int
        All of its spheres.

    Examples
    --------
    >>> [round(gain_of_ranks(2, count), 1) for count in (1500, 15_000, 50_000)]
    [1.5, 1.7, 1.8]
    """
    doublings, exponent, shared = math.log2(ranks), 0.0, float(spheres)
    while doublings > 0:
        gained = 1 - (_TOO_FEW_TO_SHARE / shared) ** (1 / 3)
        exponent += min(doublings, 1.0) * max(gained, 0.0)
        doublings, shared = doublings - 1, shared / 2
    return float(2**exponent)


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
        speed = self.sphere_steps * gain_of_ranks(ranks, spheres)
        speed *= min(_CACHED_SPHERES / spheres, 1.0) ** _CACHE_EXPONENT
        return RunCost(**vars(workload), wall_seconds=workload.steps * spheres / speed)
