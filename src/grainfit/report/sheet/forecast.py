"""What a calibrated material costs in a simulation of a process, by the runs of its calibration."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass
from statistics import median

from grainfit.bulk_tests.parameter_names import DENSITY
from grainfit.bulk_tests.registry import recreate_test
from grainfit.bulk_tests.workload import Workload, workload
from grainfit.errors import InputError
from grainfit.materials.card import MaterialCard
from grainfit.scenes.packing import mean_particle_volume
from grainfit.solvers.speed import Speed
from grainfit.work_folder.saved_calibration import SavedCalibration

#: Numbers of particles of the forecast.
_PARTICLES = (10_000, 100_000, 1_000_000)
#: Shorter runs take most of their time to start, s.
_SHORTEST = 1.0


@dataclass(frozen=True)
class ProcessCost:
    """Cost of one simulated second of a process.

    Parameters
    ----------
    particles : int
        Number of particles.
    mass : float, optional
        Their mass, kg.
    seconds : float
        Wall time, s.
    """

    particles: int
    mass: float | None
    seconds: float


def process_costs(card: MaterialCard, reading: SavedCalibration) -> list[ProcessCost]:
    """Return what processes of some sizes cost; nothing where no run tells the speed.

    Parameters
    ----------
    card : MaterialCard
        The material: its particles and its time step.
    reading : SavedCalibration
        Its calibration, whose runs tell the speed of the solver on their machine.
    """
    speeds = list(_speeds(reading))
    step, sizes = card.recommended_time_step, card.sizes
    if not speeds or step is None or sizes is None:
        return []
    speed = Speed(median(speeds))
    spheres = 1 if sizes.clump is None else len(sizes.clump)
    density = card.values.get(DENSITY)
    return [
        ProcessCost(
            count,
            None if density is None else count * mean_particle_volume(sizes) * density,
            speed.cost(
                Workload(step, round(1 / step), count, spheres, card.time_step_fraction)
            ).wall_seconds,
        )
        for count in _PARTICLES
    ]


def _speeds(reading: SavedCalibration) -> Iterator[float]:
    """Yield the speed of every run that took some time, spheres times time steps per second."""
    for record in reading.records.values():
        if record.status != "finished" or record.seconds < _SHORTEST:
            continue
        with suppress(InputError, KeyError, ValueError):
            test = recreate_test(record.definition)
            if test is not None:
                done = workload(test, record.definition.parameters)
                yield Speed.of_run(done, record.seconds).sphere_steps
