"""What one run of a heap test will cost, before it is made."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

from grainfit.bulk_tests.heap.heap import HeapTest

#: Particles times time steps per second on one core of a current processor.
_SPEED = {"lammps": 2.2e6, "liggghts": 2.5e6}
#: Two ranks are about 15 % faster than one: a heap is too small to share.
_RANKS_EXPONENT = 0.2
#: The bed is at rest soon after the shortest fill stage; the lift ends before its longest way.
_FILL_SHARE = 1.25
_LIFT_SHARE = 0.9


@dataclass(frozen=True)
class RunCost:
    """Estimated cost of one run.

    Parameters
    ----------
    time_step : float
        Exact, s.
    steps : int
        Estimated number of time steps.
    wall_seconds : float
        Estimated wall time on an otherwise idle core.
    """

    time_step: float
    steps: int
    wall_seconds: float


def estimate_cost(
    test: HeapTest, solver: str, material: Mapping[str, float], ranks: int = 1
) -> RunCost:
    """Estimate the cost of one run.

    Parameters
    ----------
    test : HeapTest
        What is simulated.
    solver : str
        ``"lammps"`` or ``"liggghts"``.
    material : mapping of str to float
        At least density, Young's modulus and Poisson's ratio of the particles.
    ranks : int
        MPI ranks of the run.
    """
    setup = test.setup
    simulated = _FILL_SHARE * setup.fill_time + _LIFT_SHARE * setup.lift_height / setup.lift_speed
    time_step = test.time_step(material)
    steps = math.ceil(simulated / time_step)
    speed = _SPEED[solver] * ranks**_RANKS_EXPONENT
    return RunCost(time_step, steps, steps * setup.particle_count / speed)
