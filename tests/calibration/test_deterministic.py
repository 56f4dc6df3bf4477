"""Models that ignore the seed: one run at the answer, and no scatter that is none."""

from __future__ import annotations

import itertools
import json
import math
import shutil
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import grainfit as gf
from grainfit.bulk_tests.own_scene.bulk_test import OwnScene
from grainfit.calibration.live_file import LIVE_NAME, LiveFile, LiveState
from grainfit.calibration.progress import Progress
from grainfit.calibration.records_read import RecordsRead
from grainfit.calibration.repetitions import Repetitions
from grainfit.calibration.runs_to_come import RunsToCome
from grainfit.calibration.so_far import result_so_far
from grainfit.campaign.batch import simulate_batch
from grainfit.campaign.campaign import CampaignOptions
from grainfit.evaluation import Evaluation, Proposal, Response
from grainfit.plain_data import read_plain
from grainfit.solvers.own_model.command import Command
from grainfit.solvers.own_model.python_callable import PythonCallable
from grainfit.solvers.registry import DEM_PROGRAMS
from grainfit.testing.materials import GLASS_BEADS
from grainfit.verdict.evidence import TargetEvidence, Verified
from grainfit.verdict.reasons import Deterministic
from grainfit.verdict.rule import is_contradicted

FRICTION = gf.Parameter("friction", 0.1, 0.9)
ROLLING = gf.Parameter("rolling", 0.1, 0.9)
ANGLE = gf.Target("angle", 27.0, tolerance=0.4, unit="deg")
PROBLEM = gf.Problem([FRICTION, ROLLING], [ANGLE])
SAID = "The model is deterministic"
OTHER = "The model of drum is deterministic"


def angle(parameters: dict[str, float]) -> float:
    return 15 + 20 * parameters["friction"] ** 1.3 + 5 * math.sin(3 * parameters["rolling"])


def without_seed(parameters):
    return {"angle": angle(parameters)}


def ignores_seed(parameters, seed):
    return {"angle": angle(parameters)}


@pytest.mark.parametrize("seed", range(1, 6))
@pytest.mark.parametrize(("simulate", "runs"), [(without_seed, 1), (ignores_seed, 2)])
def test_a_deterministic_model_is_calibrated_by_one_run_at_the_answer(
    simulate: Callable[..., Any], runs: int, seed: int
) -> None:
    result = gf.calibrate(PROBLEM, simulate, seed=seed)

    assert result.status == "calibrated"
    assert abs(angle(dict(result.parameters)) - 27.0) < 0.4
    found = result.responses["angle"]
    assert len(found.verified_values) == 1
    assert result.runs.verification <= runs
    assert found.verified_interval is None
    assert SAID in str(result)
    assert f"Run at the answer: angle {found.verified_values[0]:.4g} deg." in str(result)
    assert "fresh seed" not in str(result)


def rounded(value: float, random: np.random.Generator) -> float:
    return round(value + random.normal(0.0, 0.01), 1)


def zero(value: float, random: np.random.Generator) -> float:
    return max(0.0, value + random.normal(0.0, 0.01) - 27.0)


def hidden(value: float, random: np.random.Generator) -> float:
    return value + float(np.random.default_rng().normal(0.0, 0.01))


@pytest.mark.parametrize("measured", [rounded, zero, hidden])
def test_equal_responses_alone_make_no_model_deterministic(measured: Callable[..., float]) -> None:
    def simulate(parameters, seed):
        return {"angle": measured(angle(parameters), np.random.default_rng(seed))}

    records = RecordsRead({"heap": PythonCallable(simulate)}, {"heap": 1})
    places = [{"friction": 0.3, "rolling": 0.3}, {"friction": 0.4, "rolling": 0.4}]
    runs = [
        Evaluation(
            Proposal(place, seed, "verification"),
            {"angle": Response(simulate(place, seed)["angle"])},
            runs={"heap": f"{seed}"},
        )
        for seed, place in enumerate(itertools.chain(*([place] * 5 for place in places)))
    ]
    assert records.repetitions([], runs).deterministic == ()
    assert records.repetitions([], runs).stale == {}


def test_a_run_beside_the_tolerance_contradicts_what_all_runs_predict() -> None:
    def evidence(value: float) -> TargetEvidence:
        only = Verified(value, 0.0, 0.0, 1)
        return TargetEvidence(
            "angle", "deg", 27.0, 0.4, True, 27.0, 0.1, 0.99, 0.3, only, 1, is_deterministic=True
        )

    assert is_contradicted(evidence(27.41))
    assert not is_contradicted(evidence(27.39))


def test_of_several_tests_the_deterministic_one_needs_one_run() -> None:
    def heap(parameters, seed):
        scatter = np.random.default_rng(seed).normal(0.0, 0.2)
        return {"angle": 15 + 20 * parameters["friction"] + scatter}

    def drum(parameters, seed):
        return {"angle": 10 + 30 * parameters["friction"] + parameters["rolling"]}

    targets = [
        gf.Target("heap.angle", 25.0, tolerance=0.5, unit="deg"),
        gf.Target("drum.angle", 25.5, tolerance=0.5, unit="deg"),
    ]
    problem = gf.Problem([FRICTION, ROLLING], targets)
    tests = {"heap": PythonCallable(heap), "drum": PythonCallable(drum)}
    result = gf.calibrate(problem, tests, seed=2)

    assert result.status == "calibrated"
    assert len(result.responses["drum.angle"].verified_values) == 1
    assert len(result.responses["heap.angle"].verified_values) >= 2
    assert [one.test for one in result.reasons if isinstance(one, Deterministic)] == ["drum"]
    assert OTHER in str(result)


def test_the_report_and_the_answer_so_far_say_it(tmp_path: Path) -> None:
    def simulate(parameters, seed):
        return {"angle": angle(parameters), "depth": {"coordinates": [0, 1], "values": [1, 2]}}

    result = gf.calibrate(PROBLEM, simulate, seed=1, workdir=tmp_path)
    assert SAID in gf.write_report(tmp_path).read_text(encoding="utf-8")
    saved = gf.open(tmp_path)
    assert saved.result is not None
    assert any(isinstance(one, Deterministic) for one in saved.result.reasons)
    assert result.runs.verification == 2
    records = RecordsRead({"simulate": PythonCallable(simulate)}, {"simulate": 1})
    verification = [one for one in saved.evaluations if one.proposal.stage == "verification"]
    search = [one for one in saved.evaluations if one not in verification]
    found = result_so_far(
        saved.problem,
        saved.evaluations,
        options=saved.strategy_options,
        repetitions=read_back(records.repetitions(search, verification), tmp_path),
    )
    assert found is not None
    assert found.parameters == result.parameters
    assert len(found.responses["angle"].verified_values) == 1
    assert found.reasons == result.reasons


def read_back(repetitions: Repetitions, folder: Path) -> Repetitions:
    """Return what a watch reads of the live file."""
    progress = Progress("verification", 1, 0, 0, RunsToCome(0.0), None, None, ())
    with LiveFile(folder) as file:
        file.update("calibration", progress, repetitions)
        content = json.loads((folder / LIVE_NAME).read_text())
    state: LiveState = read_plain(LiveState, content)
    assert state.repetitions == repetitions
    return state.repetitions


PROGRAM = """
import json, random, sys
values = json.load(open("parameters.json"))
noise = random.Random(values["seed"])
with open("particles.txt", "w") as file:
    for number in range(40):
        height = (number + 1) ** values["friction"] + {noise} * noise.random()
        print(f"{{height:.6f}}", file=file)
with open("run.log", "w") as file:
    print(noise.random(), file=file)
json.dump({{"angle": round(values["friction"], 1)}}, open("responses.json", "w"))
"""


@pytest.mark.parametrize(("noise", "deterministic"), [(0.0, True), (1e-3, False)])
def test_the_raw_output_of_a_command_decides(
    tmp_path: Path, noise: float, deterministic: bool
) -> None:
    model = tmp_path / "model"
    model.mkdir()
    (model / "model.py").write_text(PROGRAM.format(noise=noise))
    solver = Command(model, [sys.executable, "model.py"])
    # Its text has the name of the seed: only the files that it wrote tell.
    assert solver.seed_use == "read"
    found = simulated(solver, tmp_path / "work", [{"friction": 0.3}, {"friction": 0.62}])
    assert found == (("", "test") if deterministic else ())


def simulated(
    solver: gf.Solver, work: Path, places: list[dict[str, float]], seeds: int = 2
) -> tuple[str, ...]:
    """Return the deterministic tests, by runs with several seeds at the first place."""
    proposals = [Proposal(places[0], seed, "verification") for seed in range(1, seeds + 1)]
    proposals += [Proposal(place, 9, "design") for place in places[1:]]
    runs = simulate_batch({"test": solver}, proposals, work, CampaignOptions(1))
    assert all(not run.failures for run in runs)
    records = RecordsRead({"test": solver}, {"test": 1}, work)
    return records.repetitions([], runs).deterministic


@pytest.mark.parametrize(
    ("text", "use"),
    [
        ("print({{ friction }})", "unread"),
        ("print({{ friction }}, {{ prime_seed_2 }})", "read"),
        ("import json; json.load(open('parameters.json'))['friction']", "unread"),
        ("print({{ parameters | tojson }})", "read"),
    ],
)
def test_a_command_reads_the_seed_where_its_text_has_it(
    tmp_path: Path, text: str, use: str
) -> None:
    (tmp_path / "model.py.j2").write_text(text)
    assert Command(tmp_path, ["python3", "model.py"]).seed_use == use


SCENE = """
import numpy as np
from grainfit.scenes import Box, Column, Elapsed, Plane, Scene, Stage, Wall

def scene(material, sizes, seed, gravity, time_step):
    d = sizes.sauter_diameter
    start = {START}
    places = np.array([[2 * d * i, 0.0, d * (0.6 + start + 0.05 * i)] for i in range(40)])
    return Scene(
        title="Beads fall on a floor",
        material=material,
        sizes=sizes,
        particles=Column(places, np.zeros(40, dtype=int), d),
        box=Box((-d, -d, -d), (80 * d, d, 8 * d)),
        walls={"floor": Wall(Plane("z", 0.0))},
        stages=(Stage("fall", Elapsed(0.1), is_closed=True),),
        gravity=gravity,
        time_step=time_step,
        quiet_speed=1e-5,
        check_interval=0.01,
    )

def measure(run):
    return {"lowest": round(run.snapshot("end").positions[:, 2].min(), 2)}
"""


@pytest.mark.parametrize(("start", "deterministic"), [("0.1", True), ("0.01 * seed", False)])
@pytest.mark.parametrize("program", ["lammps", "liggghts"])
def test_particles_of_a_scene_tell_whether_it_uses_the_seed(
    tmp_path: Path, program: str, start: str, deterministic: bool
) -> None:
    if program != "lammps" and shutil.which(program) is None:
        pytest.skip(f"{program} is not installed")
    path = tmp_path / "beads.py"
    path.write_text(SCENE.replace("{START}", start))
    test = OwnScene(diameter="10 mm", scene=f"{path}:scene", measure=f"{path}:measure")
    name = "particle.density"
    solver = DEM_PROGRAMS[program](test, {k: v for k, v in GLASS_BEADS.items() if k != name})
    places = [{name: GLASS_BEADS[name]}, {name: 0.9 * GLASS_BEADS[name]}]
    found = simulated(solver, tmp_path / "work", places)
    assert found == (("", "test") if deterministic else ())
