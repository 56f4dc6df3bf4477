"""Runs of near problems guide a search; no verdict rests on them."""

from __future__ import annotations

import sys
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import grainfit as gf
from grainfit.bulk_tests.heap import Heap
from grainfit.campaign import messages
from grainfit.campaign.near_runs import MOST_NEAR, NearRuns, near_records, near_runs
from grainfit.campaign.store.records import RunRecord
from grainfit.campaign.store.store import RunStore
from grainfit.evaluation import Response
from grainfit.solvers.dem.lammps.program import Lammps
from grainfit.testing.materials import GLASS_BEADS, ROUGH_PLATE
from grainfit.work_folder.saved_calibration import SavedCalibration

SLIDING = "particle_particle.sliding_friction"
RESTITUTION, MODULUS = "particle_particle.restitution", "particle.youngs_modulus"
FIXED = {name: value for name, value in GLASS_BEADS.items() if name != SLIDING}
PROBLEM = gf.Problem(
    [gf.Parameter(SLIDING, 0.1, 0.9)],
    [gf.Target("angle_of_repose", 25.0, uncertainty=0.5)],
)
BENCHMARKS = Path(__file__).parents[2] / "benchmarks"


def heap(
    material: Mapping[str, float] | None = None,
    diameter: str = "10 mm",
    **options: Any,
) -> Lammps:
    """Return a heap whose fixed numbers differ from the usual ones."""
    test = Heap(diameter=diameter, **{**ROUGH_PLATE, **options})
    return Lammps(test, {**FIXED, **(material or {})})


def records(solver: Lammps, count: int = 6, first: int = 1) -> list[RunRecord]:
    """Return runs of a heap all over the interval of the sliding friction."""
    found = []
    for number, friction in enumerate(np.linspace(0.15, 0.85, count), first):
        definition = solver.definition({SLIDING: float(friction)}, number)
        responses = {"angle_of_repose": Response(15 + 18 * float(friction))}
        run = RunRecord(definition.identity, "a heap", "finished", definition, responses)
        found.append(run)
    return found


def found_in(*runs: RunRecord, solver: Lammps | None = None) -> NearRuns:
    """Return the near runs of a store."""
    store, solvers = RunStore.in_memory(), {"heap": solver or heap()}
    store.save_many(runs)
    return near_runs(PROBLEM, solvers, near_records(store, PROBLEM, solvers), seed=1)


@pytest.mark.parametrize(
    ("other", "said"),
    [
        (heap({RESTITUTION: GLASS_BEADS[RESTITUTION] - 0.01}), "restitution 0.78"),
        (heap({MODULUS: 1.1 * GLASS_BEADS[MODULUS]}), "youngs modulus 3.96·10⁵ Pa"),
        (heap(cylinder_radius="61 mm"), "cylinder radius 61 mm"),
        (heap(particle_count=1600), "particle count 1600"),
        (heap(diameter="9.8 mm", cylinder_radius="60 mm"), "particle diameter 9.8 mm"),
    ],
)
def test_what_differs_a_little_is_near_and_named(other: Lammps, said: str) -> None:
    near = found_in(*records(other))

    assert near.tests == ("",)
    assert len(near.evaluations) == 6
    assert messages.NEAR_RUNS.is_in(near.notice)
    assert near.notice.startswith("6 runs of 1 near problem ")
    assert said in near.notice


@pytest.mark.parametrize(
    "other",
    [
        heap({RESTITUTION: 0.6 * GLASS_BEADS[RESTITUTION]}),
        heap(cylinder_radius="80 mm"),
        heap(base="plate", rim_height="5 mm"),
        heap(),
    ],
)
def test_what_differs_more_and_runs_of_the_problem_itself_are_not_near(other: Lammps) -> None:
    assert found_in(*records(other)) == NearRuns()


def _changed(run: RunRecord, **changes: Any) -> RunRecord:
    """Return a run with another solver, version or test."""
    model = run.definition.model
    test = {**model["test"], **changes.pop("test", {})}
    definition = replace(run.definition, model={**model, **changes, "test": test})
    return replace(run, identity=definition.identity, definition=definition)


def test_runs_of_another_revision_or_solver_are_not_near_those_of_another_version_are() -> None:
    runs = records(heap({RESTITUTION: 0.8}))

    assert found_in(*(_changed(run, test={"revision": 1}) for run in runs)) == NearRuns()
    assert found_in(*(_changed(run, solver="liggghts") for run in runs)) == NearRuns()
    assert (
        "version 1 Apr 2024" in found_in(*(_changed(r, version="1 Apr 2024") for r in runs)).notice
    )


def test_runs_of_several_near_problems_are_counted_and_a_few_are_none() -> None:
    two = [heap({RESTITUTION: 0.8}), heap(cylinder_radius="61 mm")]
    near = found_in(*(run for other in two for run in records(other)))

    assert near.notice.startswith("12 runs of 2 near problems ")
    # A metamodel needs more places than a line has coefficients.
    assert found_in(*records(two[0], count=2)) == NearRuns()


def test_of_many_near_runs_some_are_spread_and_some_near_the_answer() -> None:
    near = found_in(*records(heap({RESTITUTION: 0.8}), count=70))
    frictions = np.sort([one.proposal.parameters[SLIDING] for one in near.evaluations])

    assert len(frictions) == MOST_NEAR
    assert frictions[0] < 0.2
    assert frictions[-1] > 0.8
    # The target of 25 degrees is met at 0.556: all of the 17 that are that near are taken.
    assert (abs(frictions - 0.556) < 0.09).sum() >= 17


def test_near_runs_of_another_size_are_brought_to_the_size_of_the_problem() -> None:
    small = heap(
        {RESTITUTION: 0.8, MODULUS: 0.5 * GLASS_BEADS[MODULUS]},
        "5 mm",
        cylinder_radius="30 mm",
        lift_speed="35.4 mm/s",
    )
    near = found_in(*records(small))

    assert "restitution 0.8" in near.notice
    assert "cylinder" not in near.notice
    assert all(set(one.responses) == {" (relative).angle_of_repose"} for one in near.evaluations)


@pytest.fixture(scope="module")
def emulated() -> Any:
    """The benchmark of near runs: emulated responses, definitions of LAMMPS."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(sys, "path", [str(BENCHMARKS), *sys.path])
        import near_runs as benchmark

        yield benchmark


def calibrated(emulated: Any, kind: str, folder: Path, **given: Any) -> gf.Result:
    """Calibrate the emulated heap with runs of near problems in the work folder."""
    known = emulated.PROBLEMS["line"](2)
    own = emulated.EmulatedHeap(known, known.simulate)
    if emulated.RELATIVES[kind] is not None and not folder.exists():
        folder.mkdir()
        emulated.left_behind(known, emulated.RELATIVES[kind], folder, 2, count=6)
    result = gf.calibrate(own.problem, {"heap": own}, seed=2, workdir=folder, atlas=False, **given)
    assert result.status == "calibrated"
    assert own.off(result.parameters) <= 1.0
    return result


@pytest.fixture(scope="module")
def without(emulated: Any, tmp_path_factory: pytest.TempPathFactory) -> gf.Result:
    """The same calibration in an empty work folder."""
    return calibrated(emulated, "none", tmp_path_factory.mktemp("near") / "none")


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The work folder of a calibration that good near runs guide."""
    return tmp_path_factory.mktemp("near") / "good"


@pytest.fixture(scope="module")
def result(emulated: Any, folder: Path) -> gf.Result:
    """Its result."""
    return calibrated(emulated, "good", folder)


def test_near_runs_are_said_replayed_and_switched_off(
    emulated: Any, folder: Path, result: gf.Result, without: gf.Result
) -> None:
    assert result.runs.design < without.runs.design
    [notice] = [one for one in result.notices if messages.NEAR_RUNS.is_in(one)]
    assert "2 near problems" in notice
    saved = SavedCalibration.open(folder)
    # No verdict rests on them: they are neither runs of the calibration nor of its warm start.
    assert result.runs.warm_start_runs == 0
    assert saved.warm_start == ()
    assert all(set(one.runs) == {"heap"} for one in saved.evaluations)
    assert result.runs.verification >= 3

    again = calibrated(emulated, "good", folder)
    assert again.parameters == result.parameters
    assert again.runs.reused == again.runs.total == result.runs.total
    assert notice in again.notices

    off = calibrated(emulated, "good", folder, near_runs=False)
    assert off.identity != result.identity
    assert not any(map(messages.NEAR_RUNS.is_in, off.notices))


def test_wrong_near_runs_cost_two_runs_at_most_and_no_truth(
    emulated: Any, tmp_path: Path, result: gf.Result, without: gf.Result
) -> None:
    wrong = calibrated(emulated, "wrong", tmp_path / "wrong")

    assert any(map(messages.NEAR_RUNS.is_in, wrong.notices))
    assert wrong.runs.total <= without.runs.total + 2
    # What the near runs gave decided where own runs were made.
    guided = [[one.parameters for one in found.history] for found in (result, wrong)]
    assert guided[0] != guided[1]


@pytest.mark.slow
@pytest.mark.thorough
@pytest.mark.parametrize("problem", ["smooth", "basins"])
@pytest.mark.parametrize("kind", ["useless", "wrong"])
def test_no_verdict_is_false_because_of_near_runs(emulated: Any, problem: str, kind: str) -> None:
    found = emulated.calibrate(emulated.Calibration(problem, kind, 1))

    assert found["said"]
    assert found["status"] != "unreachable"
    assert found["off"] <= 1.0
