"""No run can hang for ever, also when a calibration is started from Python."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import pytest

import grainfit as gf
from grainfit.bulk_tests.heap import Heap
from grainfit.calibration.timeouts import default_timeouts
from grainfit.errors import RunFailedError
from grainfit.evaluation import Response
from grainfit.solvers.dem.lammps.program import Lammps
from grainfit.solvers.parameters_for import ParametersFor
from grainfit.testing.materials import GLASS_BEADS

FRICTION = "particle_particle.rolling_friction"
FIXED = {name: value for name, value in GLASS_BEADS.items() if name != FRICTION}


def problem(response: str = "angle_of_repose", *more: gf.Parameter) -> gf.Problem:
    return gf.Problem([gf.Parameter(FRICTION, 0.2, 1.0), *more], [gf.Target(response, 22.0)])


class Timed(gf.Solver):
    """A model that knows how long it takes, and notes the time-out of its runs."""

    name = "timed"
    uses_folder = False

    def __init__(self) -> None:
        self.timeouts: set[float | None] = set()

    @property
    def response_names(self) -> tuple[str, ...]:
        return ("angle",)

    def model(self) -> dict[str, Any]:
        return {"solver": self.name}

    def run(
        self, parameters: Mapping[str, float], seed: int, workspace: gf.Workspace
    ) -> dict[str, Response]:
        self.timeouts.add(workspace.timeout)
        return {"angle": Response(10 + 20 * parameters[FRICTION])}

    def default_timeout(self, parameters: Mapping[str, float]) -> float:
        return 100 * parameters[FRICTION]


@pytest.mark.parametrize(
    ("given", "expected"),
    [
        ({}, 60.0),
        ({"timeouts": {"timed": 5.0}}, 5.0),
        ({"timeouts": {"timed": "2 min"}}, 120.0),
        ({"timeouts": {"timed": math.inf}}, None),
    ],
)
def test_a_run_has_the_time_out_of_its_solver_unless_one_is_given(
    given: dict[str, Any], expected: float | None
) -> None:
    solver = Timed()
    gf.calibrate(problem("angle"), solver, max_runs=12, **given)
    [timeout] = solver.timeouts
    assert timeout == (None if expected is None else pytest.approx(expected))


def test_a_heap_test_has_one_and_so_has_one_among_own_parameters() -> None:
    solver = Lammps(Heap(diameter="10 mm"), FIXED)
    cost = solver.estimate_cost({FRICTION: 0.6})
    alone = default_timeouts(problem(), {"heap": solver})
    wrapped = ParametersFor(solver, takes=GLASS_BEADS.__contains__)
    among = default_timeouts(
        problem("angle_of_repose", gf.Parameter("cohesion", 0.0, 1.0)), {"heap": wrapped}
    )

    assert alone == among == {"heap": pytest.approx(600 + 100 * cost.wall_seconds)}
    assert default_timeouts(problem(), {"own": ParametersFor(Timed())}) == {
        "own": pytest.approx(60.0)
    }


class Impatient(Lammps):
    """LAMMPS, of which a run seems to hang after a second."""

    def default_timeout(self, parameters: Mapping[str, float]) -> float:
        return 1.0


def test_a_heap_test_that_hangs_is_ended_when_started_from_python() -> None:
    solver = Impatient(Heap(diameter="10 mm", settling_time_limit="1000 s"), FIXED)
    with pytest.raises(RunFailedError, match="time-out of 1 s"):
        gf.calibrate(problem(), solver, max_runs=12)
