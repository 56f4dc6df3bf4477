"""Calibrations in jobs of a real Slurm: undisturbed, disturbed, refused, interrupted."""

from __future__ import annotations

import json
import os
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from pathlib import Path

import pytest

import grainfit as gf
from grainfit.bulk_tests.heap import Heap
from grainfit.campaign.cluster import parsl_executor
from grainfit.campaign.cluster import slurm as slurm_jobs
from grainfit.campaign.cluster.executor import cluster_executor
from grainfit.campaign.cluster.options import ClusterOptions
from grainfit.campaign.store.records import RunRecord
from grainfit.campaign.worker import RunTask, execute
from grainfit.errors import ExecutorError
from grainfit.materials.sizes import ParticleSizes
from grainfit.result import Result
from grainfit.solvers.base import Solver
from grainfit.solvers.dem.lammps.program import Lammps
from grainfit.solvers.dem.liggghts.program import Liggghts
from grainfit.solvers.own_model.python_callable import PythonCallable
from grainfit.testing.materials import GLASS_BEADS

pytest.importorskip("parsl")
pytestmark = pytest.mark.slow

ONE_JOB = ClusterOptions(walltime=600.0)
#: A third of the usual beads: a heap that takes a second or two.
SMALL = Heap(
    ParticleSizes((0.010,)),
    cylinder_radius=0.04,
    strike_off_height=0.08,
    bulk_density_top=0.07,
    plate_radius=0.12,
)
NEVER_HERE = 60.0


def slurm_says(*command: str) -> str:
    return subprocess.run(command, capture_output=True, text=True, check=True, timeout=30).stdout


def jobs() -> dict[str, str]:
    """State of every job that there has been, by its number."""
    lines = slurm_says("squeue", "--noheader", "--states=all", "--format=%i %T").splitlines()
    return dict(line.split() for line in lines)


def until(condition: Callable[[], object], seconds: float = NEVER_HERE) -> None:
    deadline = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < deadline, "waited in vain"
        time.sleep(0.1)


def processes_in(folder: Path) -> list[str]:
    """Processes that name a folder in their command or work in it."""
    found = []
    for process in Path("/proc").glob("[0-9]*"):
        try:
            command = (process / "cmdline").read_text().replace("\0", " ")
            where = str((process / "cwd").readlink())
        except OSError:
            continue
        if str(folder) in command or where.startswith(str(folder)):
            found.append(command or process.name)
    return found


@pytest.fixture(autouse=True)
def _nothing_is_left(slurm: Path, tmp_path: Path) -> Iterator[None]:
    yield
    alive = {"PENDING", "CONFIGURING", "RUNNING", "COMPLETING"}
    assert not alive & set(jobs().values())
    until(lambda: not processes_in(tmp_path), 10)


# Disturbances --------------------------------------------------------------------------------


def cancel(job: str) -> None:
    slurm_says("scancel", job)


def let_its_time_run_out(job: str) -> None:
    # Slurm looks at the limits of jobs twice a minute.
    slurm_says("scontrol", "update", f"jobid={job}", "EndTime=now+1")
    until(lambda: jobs()[job] == "TIMEOUT")


def take_its_node_down(job: str) -> None:
    slurm_says("scontrol", "update", "nodename=node", "state=down", "reason=test")
    until(lambda: jobs()[job] != "RUNNING")
    slurm_says("scontrol", "update", "nodename=node", "state=resume")


DRUM = """
import os
import random
import time
from pathlib import Path

def drum(parameters, seed):
    folder = Path(__file__).parent
    job = os.environ.get("SLURM_JOB_ID", "none")
    with (folder / "calls").open("a") as calls:
        calls.write(f"{job}\\n")
    if (folder / "halt").exists() and job != "none":
        (folder / "halt").rename(folder / "halted")
        time.sleep(100)
    noise = random.Random(seed).gauss(0, 0.3)
    return {"angle": 20 + 40 * parameters["friction"] + noise}
"""


def calibrate_drum(folder: Path, options: ClusterOptions | None) -> Result:
    problem = gf.Problem(
        [gf.Parameter("friction", 0.1, 0.9)], [gf.Target("angle", 36.0, uncertainty=0.4)]
    )
    solver = PythonCallable.from_file(f"{folder}/drum.py:drum", ["angle"])
    return calibrate_in(options, folder / "work", problem, solver, max_runs=14)


def calibrate_heap(folder: Path, options: ClusterOptions | None) -> Result:
    fixed = {name: v for name, v in GLASS_BEADS.items() if name != "particle.density"}
    problem = gf.Problem(
        [gf.Parameter("particle.density", 1400.0, 2800.0)],
        [gf.Target("bulk_density", 1200.0, uncertainty=20.0)],
    )
    return calibrate_in(options, folder / "work", problem, Lammps(SMALL, fixed), max_runs=7)


def calibrate_in(
    options: ClusterOptions | None,
    folder: Path,
    problem: gf.Problem,
    solver: Solver,
    max_runs: int,
) -> Result:
    rest = {"max_runs": max_runs, "seed": 3, "verification_runs": 2}
    rest["strategy"] = gf.Sequential(design_runs=4)
    if options is None:
        return gf.calibrate(problem, solver, workdir=folder, **rest)
    with cluster_executor(options, folder) as executor:
        return gf.calibrate(problem, solver, workdir=folder, executor=executor, **rest)


def same(result: Result) -> tuple[object, ...]:
    """What must not depend on where runs are made."""
    return (result.status, result.parameters, result.responses, result.runs)


def drum_folder(folder: Path) -> Path:
    folder.mkdir()
    (folder / "drum.py").write_text(DRUM)
    return folder


def calls(folder: Path) -> list[str]:
    path = folder / "calls"
    return path.read_text().split() if path.exists() else []


def test_what_happens_to_jobs_costs_the_runs_in_them_alone(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The node of a job goes down, another reaches its walltime, a third is cancelled.

    In the end the calibration is, to the last digit, what it is on this machine; and so is one of a
    real heap.
    """
    # All that has to be noticed is noticed three times as fast as usual.
    for name, seconds in (("HEARTBEAT", 2), ("LOST", 6), ("STATUS", 3), ("LOOK", 1)):
        home = slurm_jobs if name == "STATUS" else parsl_executor
        monkeypatch.setattr(home, f"_{name}_SECONDS", seconds)
    drum, here = drum_folder(tmp_path / "drum"), drum_folder(tmp_path / "drum here")
    disturbances = (take_its_node_down, let_its_time_run_out, cancel)
    disturbed = []
    with ThreadPoolExecutor() as threads:
        drums = threads.submit(calibrate_drum, drum, ONE_JOB)
        for disturb in disturbances:
            # A run that is lost three times is given up: each time it is another one.
            enough = len(calls(drum)) + 2
            until(lambda enough=enough: len(calls(drum)) >= enough)
            halt(drum)
            disturbed.append(calls(drum)[-1])
            disturb(disturbed[-1])
            if len(disturbed) == 1:
                # Not before: the node was that of all jobs.
                heaps = threads.submit(calibrate_heap, tmp_path / "heap", ONE_JOB)
                drums_alone = threads.submit(calibrate_drum, here, None)
        heaps_alone = threads.submit(calibrate_heap, tmp_path / "heap here", None)
    assert same(drums.result()) == same(drums_alone.result())
    assert same(heaps.result()) == same(heaps_alone.result())
    assert len(calls(drum)) == len(calls(here)) + 3, "those that were lost, and no others"
    assert len(set(calls(drum))) == 4
    assert [jobs()[job] for job in disturbed] == ["NODE_FAIL", "TIMEOUT", "CANCELLED"]


def halt(folder: Path) -> None:
    """Have the next run halt, and wait until it has."""
    (folder / "halt").touch()
    until((folder / "halted").exists)
    (folder / "halted").unlink()


def test_runs_of_several_ranks_are_the_same_in_a_job(tmp_path: Path) -> None:
    solvers: list[Solver] = [Lammps(SMALL, GLASS_BEADS, ranks=2)]
    if shutil.which("liggghts"):
        solvers.append(Liggghts(SMALL, GLASS_BEADS, ranks=2))
    here, there = tmp_path / "here", tmp_path / "there"

    def order(solver: Solver, folder: Path) -> RunTask:
        (folder / "runs").mkdir(parents=True, exist_ok=True)
        record = RunRecord(solver.name, "heap", "running", solver.definition({}, 1))
        return RunTask(record, solver, {}, 1, folder)

    with cluster_executor(replace(ONE_JOB, cores_per_run=2), there) as executor:
        futures = [executor.submit(execute, order(solver, there)) for solver in solvers]
        alone = [execute(order(solver, here)) for solver in solvers]
        in_job = [future.result(120) for future in futures]
    assert [record.reason for record in alone + in_job] == [""] * 2 * len(solvers)
    assert [record.responses for record in in_job] == [record.responses for record in alone]


def test_jobs_that_cannot_start_end_the_calibration_with_the_reason(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(slurm_jobs, "_FAILED_START_SECONDS", 3.0)
    monkeypatch.setattr(slurm_jobs, "_STATUS_SECONDS", 2)
    hopeless = {
        "sbatch: error: invalid partition specified: nope": {"partition": "nope"},
        "PENDING, PartitionTimeLimit": {"partition": "closed"},
        "no such module": {"setup": ("echo no such module >&2; exit 3",)},
    }

    def reason(number: int, change: dict[str, object]) -> str:
        folder = drum_folder(tmp_path / str(number))
        started = time.monotonic()
        with pytest.raises(ExecutorError) as caught:
            calibrate_drum(folder, replace(ONE_JOB, **change))
        assert time.monotonic() - started < 60
        return str(caught.value)

    with ThreadPoolExecutor() as threads:
        reasons = list(threads.map(reason, range(3), hopeless.values()))
    for words, said in zip(hopeless, reasons, strict=True):
        assert "no job of the cluster starts: " in said
        assert words in said


FILE = """
name = "sand"

[parameters]
friction = { min = 0.1, max = 0.9 }

[[test]]
type = "python"
function = "drum.py:drum"
targets.angle = { value = 36, uncertainty = 0.4 }

[strategy]
max_runs = 14

[cluster]
partition = "short"
walltime = "10 min"
runs_per_job = 2
setup = ["export GREETING=hello"]
options = ["--comment=calibration"]
"""


def command(*arguments: str) -> list[str]:
    return [sys.executable, "-m", "grainfit", *arguments]


def grainfit(folder: Path, *arguments: str, **environment: str) -> str:
    done = subprocess.run(
        command(*arguments),
        cwd=folder,
        env=os.environ | environment,
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout + done.stderr


@pytest.mark.usefixtures("ctrl_c")
def test_ctrl_c_ends_the_jobs_and_the_next_start_goes_on_anywhere(tmp_path: Path) -> None:
    folder = drum_folder(tmp_path / "drum")
    (folder / "sand.toml").write_text(FILE)
    shown = grainfit(folder, "check", "sand.toml")
    for part in ("2 runs at a time", "partition short", "10 min", "GREETING", "--comment"):
        assert part in " ".join(shown.split())
    before = set(jobs())
    # One run of the design does not end, so that the calibration cannot either.
    (folder / "halt").touch()

    process = subprocess.Popen(
        command("run", "sand.toml", "--no-report"),
        cwd=folder,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        start_new_session=True,
    )
    until(lambda: len(calls(folder)) >= 3 and (folder / "halted").exists())
    # As a terminal does: everything that is not in a session of its own gets it.
    os.killpg(process.pid, signal.SIGINT)
    said, _ = process.communicate(timeout=60)
    assert process.returncode == 130
    assert "interrupted" in said
    assert "Traceback" not in said
    until(lambda: not processes_in(folder), 10)
    [job] = set(jobs()) - before
    assert jobs()[job] == "CANCELLED"
    assert sorted(path.name for path in folder.iterdir()) == [
        "calls",
        "drum.py",
        "halted",
        "sand.grainfit",
        "sand.toml",
    ]

    said = grainfit(folder, "run", "sand.toml", "--no-report", PATH=str(tmp_path / "nothing"))
    assert "sbatch is not found" in said
    assert ", 0 reused" not in said
    assert set(jobs()) - before == {job}
    result = json.loads((folder / "sand.grainfit" / "result.json").read_text())
    assert result["status"] == "calibrated"
