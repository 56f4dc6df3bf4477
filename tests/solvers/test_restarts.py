"""Long runs that are killed: they continue from the restart file of their solver."""

from __future__ import annotations

import os
import random
import shutil
import signal
import subprocess
import sys
import textwrap
import threading
import time
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from small_heaps import SMALL_HEAP
from typer.testing import CliRunner

import needs
from grainfit.analysis import messages as of_analysis
from grainfit.bulk_tests.heap import Heap
from grainfit.bulk_tests.registry import bulk_tests
from grainfit.calibration_file.starter import starter_file
from grainfit.campaign.store.records import RunRecord
from grainfit.campaign.worker import RunTask, execute
from grainfit.cli.app import app
from grainfit.evaluation import scalars
from grainfit.scenes.conditions import Drained, Elapsed, Loaded
from grainfit.scenes.film import FILM
from grainfit.scenes.packing import Rectangle, random_column
from grainfit.scenes.records import Force, Frames, KineticEnergy, Series, Travel
from grainfit.scenes.run_output import RunOutput
from grainfit.scenes.scene import Box, Load, Scene, Stage, Velocity, Wall, time_step
from grainfit.scenes.shapes import Block, Plane
from grainfit.solvers.base import Workspace
from grainfit.solvers.dem import messages, restarts
from grainfit.solvers.dem.lammps.program import Lammps
from grainfit.solvers.dem.liggghts.program import Liggghts
from grainfit.solvers.dem.program import DeckSolver
from grainfit.solvers.dem.yade.program import Yade
from grainfit.testing.materials import GLASS_BEADS
from grainfit.testing.simulated_scenes import (
    GRAVITY,
    RADIUS,
    SIZES,
    material,
    scene_of,
    settle,
    spheres,
)

SMALL = Heap(diameter="10 mm", **SMALL_HEAP)
ROUGH = material(0.4, 0.5)
UNDAMPED = {n: 0.0 if n.endswith("rolling_damping") else v for n, v in GLASS_BEADS.items()}
OTHERS = [
    pytest.param(Liggghts, id="liggghts", marks=needs.LIGGGHTS),
    pytest.param(Yade, id="yade", marks=needs.YADE),
]
#: Standard deviations of the small heap over 14 seeds. A break is one more roll of the dice: what
#: follows differs in rounding, and collisions of a fill make another bed of that.
SCATTER = {"bulk_density": 6.1, "angle_of_repose": 1.2, "base_radius": 0.0013}
#: Runs that are killed: they count as long, and save about once in a tenth of a run.
KILLED = """
    from pathlib import Path
    from grainfit.bulk_tests.registry import bulk_tests
    from grainfit.campaign.batch import simulate_batch
    from grainfit.campaign.campaign import CampaignOptions
    from grainfit.evaluation import Proposal
    from grainfit.solvers.dem import restarts
    from grainfit.solvers.registry import DEM_PROGRAMS

    restarts.LONG_RUN, restarts.INTERVAL = 0.0, 0.1
    test = bulk_tests()[{test!r}](diameter="10 mm", **{options!r})
    solver = DEM_PROGRAMS[{program!r}](test, {material!r})
    proposals = [Proposal({{}}, 5, "design")]
    simulate_batch({{"test": solver}}, proposals, Path({folder!r}), CampaignOptions())
"""


def pressed() -> Scene:
    """Return rough spheres that settle, are pressed, pushed from the side, and released."""
    box = Box((-0.03, 0.0, -0.01), (0.05, 0.035, 0.4), periodic="y")
    walls = {
        "floor": Wall(Plane("z", 0.0)),
        "left": Wall(Plane("x", -0.027)),
        "ram": Wall(Block((0.03, -0.04, -0.01), (0.045, 0.04, 0.12))),
    }
    lid = Wall(Block((-0.03, -0.04, 0.1), (0.029, 0.04, 0.11)))
    seen = {"force": Force("lid", "z"), "way": Travel("lid"), "side": Force("ram", "x")}
    press = {"lid": Load("z", -2.0, largest_speed=0.3, gain=0.05)}
    stages = (
        settle(),
        Stage(
            "press",
            Loaded("lid", 0.02, 1.0),
            put={"lid": lid},
            motions=press,
            series=Series(seen, 0.001),
        ),
        Stage(
            "push",
            Elapsed(0.1),
            motions={**press, "ram": Velocity("x", -0.03)},
            series=Series({**seen, "energy": KineticEnergy()}, 0.001),
            frames=Frames("pushing", 0.01),
            snapshot="pushed",
            sliding_friction=0.2,
            is_closed=True,
        ),
        Stage("free", Elapsed(0.05), take_away=("lid",), snapshot="freed"),
    )
    column = random_column(SIZES, 60, Rectangle(0.05, 0.035), seed=3)
    return scene_of(
        column,
        walls,
        stages,
        ROUGH,
        box=box,
        film_interval=0.02,
        time_step=time_step(SIZES, ROUGH, 0.1),
        quiet_speed=1e-3,
    )


def simulated(folder: Path, scene: Scene, every: int | None = None) -> RunOutput:
    folder.mkdir(exist_ok=True)
    solver = Lammps(SMALL, GLASS_BEADS)
    return solver.simulate(scene, Workspace(folder, 120.0), every)


@pytest.fixture(scope="module")
def unbroken(tmp_path_factory: pytest.TempPathFactory) -> RunOutput:
    return simulated(tmp_path_factory.mktemp("unbroken"), pressed())


def written(out: RunOutput) -> dict[str, bytes]:
    files = [*out.folder.glob("*.csv"), *out.folder.glob("snapshots/*"), out.folder / FILM]
    return {path.name: path.read_bytes() for path in files}


def break_at(saved: RunOutput, folder: Path, step: int) -> Path:
    """Leave a run as if it had been killed just after a restart file."""
    shutil.copytree(saved.folder, folder)
    states = restarts.saved_states(folder, pressed())
    last = next(state for state in states if state.step == step)
    for state in states:
        if state.step > step:
            (folder / f"{state.file}.state").unlink()
    assert last.step == step
    return folder


@pytest.fixture(scope="module")
def saving(tmp_path_factory: pytest.TempPathFactory, unbroken: RunOutput) -> dict[float, RunOutput]:
    """Return runs that saved at different moments, by the share of their steps between two."""
    steps = unbroken.stages[-1].step
    return {
        share: simulated(tmp_path_factory.mktemp("saving"), pressed(), round(share * steps))
        for share in (0.11, 0.15)
    }


def test_saving_changes_no_byte_of_a_run(
    unbroken: RunOutput, saving: dict[float, RunOutput]
) -> None:
    for run in saving.values():
        assert written(run) == written(unbroken)


def test_a_continued_run_is_the_unbroken_one(
    unbroken: RunOutput, saving: dict[float, RunOutput], tmp_path: Path
) -> None:
    stages = set()
    for share, run in saving.items():
        for state in restarts.saved_states(run.folder, pressed()):
            folder = break_at(run, tmp_path / f"{share}_{state.step}", state.step)
            out = simulated(folder, pressed(), round(share * unbroken.stages[-1].step))
            stages.add(state.stage)

            assert f"time step {state.step} of" in (folder / restarts.LOG).read_text()
            assert_alike(out, unbroken)
    assert stages == {"press", "push", "free"}


def assert_alike(out: RunOutput, unbroken: RunOutput) -> None:
    ends = [(end.name, end.end, end.step, end.particles) for end in out.stages]
    assert ends == [(end.name, end.end, end.step, end.particles) for end in unbroken.stages]
    for stage in ("press", "push"):
        found, expected = out.series(stage), unbroken.series(stage)
        for name, column in expected.items():
            # Dashpots see the speed of a whole time step at first, not of a half one.
            scale = float(np.abs(column).max())
            assert found[name] == pytest.approx(column, abs=0.05 * scale)
    for name in ("rest", "pushed", "freed"):
        places = unbroken.snapshot(name).positions
        assert out.snapshot(name).positions == pytest.approx(places, abs=0.02 * RADIUS)
    steps = [frame.step for frame in unbroken.frames("pushing")]
    assert [frame.step for frame in out.frames("pushing")] == steps


@pytest.mark.slow
@pytest.mark.parametrize("program", OTHERS)
def test_a_continued_run_of_another_program_is_its_unbroken_one(
    program: type[DeckSolver], tmp_path: Path
) -> None:
    scene = pressed()
    if program is Liggghts:
        # It has one friction for all stages.
        stages = tuple(replace(stage, sliding_friction=None) for stage in scene.stages)
        scene = replace(scene, stages=stages)
    solver, whole = program(SMALL, UNDAMPED), tmp_path / "whole"
    whole.mkdir()
    unbroken = solver.simulate(scene, Workspace(whole, 120.0), 3000)
    folder = shutil.copytree(whole, tmp_path / "broken")
    later, first = restarts.saved_states(folder, scene)
    (folder / f"{later.file}.state").unlink()

    out = solver.simulate(scene, Workspace(folder, 120.0), 3000)

    assert first.stage == "press"
    assert f"time step {first.step} of" in (folder / restarts.LOG).read_text()
    assert_alike(out, unbroken)


@pytest.mark.slow
@pytest.mark.parametrize("program", [Lammps, *OTHERS])
def test_a_stage_that_drains_goes_on_to_the_same_end(
    program: type[DeckSolver], tmp_path: Path
) -> None:
    falls = [(0.02 * n, 0.0, GRAVITY * (0.02 * n) ** 2 / 2) for n in range(1, 5)]
    drain = Stage("drain", Drained(0.0, 0.9, 1.0, at_least=0.01))
    scene = scene_of(spheres(falls), {}, [drain], UNDAMPED)
    solver, whole = program(SMALL, UNDAMPED), tmp_path / "whole"
    whole.mkdir()
    every = scene.steps(0.03)
    unbroken = solver.simulate(scene, Workspace(whole, 120.0), every)
    folder = shutil.copytree(whole, tmp_path / "broken")
    later, first = restarts.saved_states(folder, scene)
    (folder / f"{later.file}.state").unlink()

    out = solver.simulate(scene, Workspace(folder, 120.0), every)

    assert f"time step {first.step} of" in (folder / restarts.LOG).read_text()
    assert out.stages == unbroken.stages
    assert out.stages[-1].time == pytest.approx(0.08, abs=2 * scene.check_interval)


def test_what_starts_anew_after_a_kill_is_said_by_check(tmp_path: Path) -> None:
    large = bulk_tests()["drum"](diameter="2 mm", drum_radius="300 mm")

    assert "glued particles" in Lammps(large, UNDAMPED).starts_anew({})
    assert "glued particles" in Liggghts(large, UNDAMPED).starts_anew({})
    assert not Yade(large, UNDAMPED).starts_anew({})
    # A short run makes no fuss.
    short = bulk_tests()["drum"](diameter="10 mm")
    assert not Lammps(short, UNDAMPED).starts_anew({})
    path = tmp_path / "drum.toml"
    kind = 'type = "drum"'
    text = starter_file(["drum"]).replace(kind, f'drum_radius = "1 m"\n{kind}')
    path.write_text(text, encoding="utf-8")
    shown = " ".join(CliRunner().invoke(app, ["check", str(path)]).output.split())
    assert of_analysis.STARTS_ANEW.is_in(shown)
    assert "LAMMPS does not continue glued particles" in shown


def test_a_damaged_restart_file_gives_way_to_the_one_before_and_then_to_a_new_start(
    unbroken: RunOutput, saving: dict[float, RunOutput], tmp_path: Path
) -> None:
    (share, run), *_ = saving.items()
    folder = shutil.copytree(run.folder, tmp_path / "run")
    every = round(share * unbroken.stages[-1].step)
    later, earlier = restarts.saved_states(folder, pressed())
    damaged = (folder / later.file).read_bytes()
    (folder / later.file).write_bytes(damaged[: len(damaged) // 2])

    assert_alike(simulated(folder, pressed(), every), unbroken)
    notes = (folder / restarts.LOG).read_text().splitlines()
    assert notes[1].startswith(f"{later.file} cannot be used: ")
    assert notes[2].startswith(f"continues at time step {earlier.step} ")

    # One of another run, and one that is not there.
    again = shutil.copytree(run.folder, tmp_path / "again")
    shutil.copy2(again / earlier.file, again / later.file)
    (again / earlier.file).unlink()

    assert written(simulated(again, pressed(), every)) == written(unbroken)
    assert len((again / restarts.LOG).read_text().splitlines()) == 4


def test_restart_files_of_another_deck_are_not_read(
    unbroken: RunOutput, saving: dict[float, RunOutput], tmp_path: Path
) -> None:
    (share, run), *_ = saving.items()
    folder = shutil.copytree(run.folder, tmp_path / "run")
    with (folder / "in.lammps").open("a") as deck:
        deck.write("# Another.\n")

    out = simulated(folder, pressed(), round(share * unbroken.stages[-1].step))

    assert "another deck" in (folder / restarts.LOG).read_text()
    assert written(out) == written(unbroken)


def wait_for(folder: Path, pattern: str, process: subprocess.Popen[bytes]) -> None:
    end = time.monotonic() + 300.0
    while not any(folder.glob(pattern)):
        assert process.poll() is None, "it ended before it was killed"
        assert time.monotonic() < end
        time.sleep(0.01)


def kill_all(process: subprocess.Popen[bytes], folder: Path) -> None:
    """Kill a calibration and its solver, with their groups, as a machine does that goes down."""
    sessions = [path.read_text().split()[0] for path in folder.glob("runs/*.partial/.session")]
    for leader in (process.pid, *map(int, sessions)):
        with suppress(ProcessLookupError):
            os.killpg(leader, signal.SIGKILL)
    process.wait()


def killed(
    tmp_path: Path, solver: DeckSolver, material: Mapping[str, float], options: object, times: int
) -> tuple[Path, Path]:
    """Return the folders of a run that was killed so many times, and of the unbroken one."""
    random_moments = random.Random(4)
    folder, unbroken = tmp_path / "runs of beads", tmp_path / "unbroken"
    about = {"program": solver.name, "test": solver.test.type, "material": dict(material)}
    script = textwrap.dedent(KILLED).format(**about, options=options, folder=str(folder))
    for _ in range(times):
        process = subprocess.Popen([sys.executable, "-c", script], start_new_session=True)
        wait_for(folder, "runs/*.partial/restart.*.state", process)
        time.sleep(random_moments.uniform(0.0, 0.5))
        kill_all(process, folder)
    subprocess.run([sys.executable, "-c", script], check=True)
    (run,) = (folder / "runs").iterdir()
    assert messages.CONTINUED.is_in((run / restarts.LOG).read_text())
    assert not list(run.glob("restart.*"))
    unbroken.mkdir()
    solver.run({}, 5, Workspace(unbroken, 120.0))
    return run, unbroken


def assert_of_one_scatter(solver: DeckSolver, run: Path, unbroken: Path) -> None:
    expected = scalars(solver.test.measure(RunOutput(unbroken)))
    found = scalars(solver.test.measure(RunOutput(run)))
    for name, scatter in SCATTER.items():
        if name in expected:
            assert found[name].value == pytest.approx(expected[name].value, abs=6 * scatter), name
    names = [stage.name for stage in RunOutput(unbroken).stages]
    assert [stage.name for stage in RunOutput(run).stages] == names


def test_a_run_killed_at_random_moments_continues_by_itself_to_the_same_responses(
    tmp_path: Path,
) -> None:
    solver = Lammps(SMALL, GLASS_BEADS)
    assert_of_one_scatter(solver, *killed(tmp_path, solver, GLASS_BEADS, SMALL_HEAP, 3))


@pytest.mark.thorough
@pytest.mark.parametrize("program", OTHERS)
def test_a_run_of_another_program_is_killed_and_continues(
    program: type[DeckSolver], tmp_path: Path
) -> None:
    # A bed of LIGGGHTS would have ended before it is killed, a heap of YADE takes long.
    kind, options = "heap", SMALL_HEAP
    if program is Yade:
        kind, options = "packing", {"cylinder_radius": 0.03, "fill_height": 0.05}
    solver = program(bulk_tests()[kind](diameter="10 mm", **options), UNDAMPED)
    assert_of_one_scatter(solver, *killed(tmp_path, solver, UNDAMPED, options, 1))


@pytest.mark.parametrize("kind", ["cancelled", "machine"])
def test_a_run_that_the_user_stops_or_whose_solver_is_killed_continues_in_the_next_attempt(
    kind: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(restarts, "LONG_RUN", 0.0)
    monkeypatch.setattr(restarts, "INTERVAL", 0.1)
    solver = Lammps(SMALL, GLASS_BEADS)
    definition = solver.definition({}, 5)
    record = RunRecord(definition.identity, "heap", "running", definition)
    task = RunTask(record, solver, {}, 5, tmp_path)
    stop = threading.Event()

    def interrupt() -> None:
        while not (states := [*tmp_path.glob("runs/*.partial/restart.*.state")]):
            time.sleep(0.01)
        if kind == "cancelled":
            stop.set()
        else:
            leader = (states[0].parent / ".session").read_text().split()[0]
            os.killpg(int(leader), signal.SIGKILL)

    thread = threading.Thread(target=interrupt, daemon=True)
    thread.start()
    first = execute(task, stop)
    thread.join(10.0)
    second = execute(task)

    assert (first.status, first.kind) == ("failed", kind)
    assert second.status == "finished"
    (run,) = (tmp_path / "runs").iterdir()
    assert messages.CONTINUED.is_in((run / restarts.LOG).read_text())
    assert not list(run.glob("restart.*"))
