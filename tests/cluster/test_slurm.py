"""Calibrations in jobs of a real Slurm of two nodes: disturbed, refused, interrupted."""

from __future__ import annotations

import json
import os
import re
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack, contextmanager
from dataclasses import replace
from pathlib import Path

import psutil
import pytest

import grainfit as gf
from grainfit.bulk_tests.heap import Heap
from grainfit.bulk_tests.packing import Packing
from grainfit.campaign import messages
from grainfit.campaign.cluster import followed, parsl_executor
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
from grainfit.testing.materials import GLASS_BEADS, ROUGH_PLATE
from grainfit.watch.state import read_folder, state_of

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
    **ROUGH_PLATE,
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


def node_of(job: str) -> str:
    return slurm_says("squeue", "--noheader", f"--jobs={job}", "--format=%N").strip()


def set_node(node: str, state: str) -> None:
    slurm_says("scontrol", "update", f"nodename={node}", f"state={state}", "reason=test")


def take_its_node_down(job: str) -> None:
    node = node_of(job)
    set_node(node, "down")
    until(lambda: jobs()[job] != "RUNNING")
    set_node(node, "resume")


def preempt(job: str) -> None:
    """Have a job of a higher priority take its node."""
    request = ("--partition=urgent", f"--nodelist={node_of(job)}", "--cpus-per-task=8")
    said = slurm_says("sbatch", "--output=/dev/null", "--wrap=true", *request)
    until(lambda: jobs()[said.split()[-1]] == "COMPLETED")


def preempt_and_requeue(job: str) -> None:
    """As on a cluster where every job may be requeued, whatever it says itself."""
    slurm_says("scontrol", "update", f"jobid={job}", "requeue=1")
    preempt(job)
    assert "Restarts=1" in slurm_says("scontrol", "show", "job", job)


def end_its_processes(job: str) -> None:
    """End what a job is on its node at once, without a word to Slurm's controller."""
    for process in psutil.process_iter(["cmdline"]):
        if f"slurmstepd: [{job}.batch]" in " ".join(process.info["cmdline"] or []):
            for one in [process, *process.children(recursive=True)]:
                one.kill()


#: Name and start of every node.
NODES = [(node, "slurmd", "-N", node) for node in ("node1", "node2")]


def is_running(slurm: Path, daemon: str) -> bool:
    pid = int((slurm / f"{daemon}.pid").read_text())
    return psutil.pid_exists(pid) and psutil.Process(pid).status() != psutil.STATUS_ZOMBIE


def kill_daemon(slurm: Path, daemon: str) -> None:
    os.kill(int((slurm / f"{daemon}.pid").read_text()), signal.SIGKILL)
    until(lambda: not is_running(slurm, daemon))


DRUM = """
import os
import random
import time
from contextlib import suppress
from pathlib import Path

def drum(parameters, seed):
    folder = Path(__file__).parent
    job = os.environ.get("SLURM_JOB_ID", "none")
    with (folder / "calls").open("a") as calls:
        calls.write(f"{job}\\n")
    while (folder / "hold").exists():
        time.sleep(0.02)
    if job != "none":
        with suppress(FileNotFoundError):
            (folder / "halt").rename(folder / "halted")
            (folder / "halted").write_text(job)
            time.sleep(100)
    noise = random.Random(seed).gauss(0, 0.3)
    return {"angle": 20 + 40 * parameters["friction"] + noise}
"""


def calibrate_drum(folder: Path, options: ClusterOptions | None, **rest: int) -> Result:
    problem = gf.Problem(
        [gf.Parameter("friction", 0.1, 0.9)], [gf.Target("angle", 36.0, uncertainty=0.4)]
    )
    solver = PythonCallable.from_file(f"{folder}/drum.py:drum", ["angle"])
    return calibrate_in(options, folder / "work", problem, solver, **{"max_runs": 14, **rest})


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
    design_runs: int = 4,
    workers: int = 1,
) -> Result:
    rest = {"max_runs": max_runs, "seed": 3, "verification_runs": 2, "workers": workers}
    rest["strategy"] = gf.Sequential(design_runs=design_runs)
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


@pytest.fixture
def _quick(monkeypatch: pytest.MonkeyPatch) -> None:
    """All that has to be noticed is noticed three times as fast as usual."""
    for name, seconds in (("HEARTBEAT", 2), ("LOST", 6), ("STATUS", 3), ("LOOK", 1)):
        home = followed if name == "STATUS" else parsl_executor
        monkeypatch.setattr(home, f"_{name}_SECONDS", seconds)


@pytest.mark.usefixtures("_quick")
@pytest.mark.thorough
def test_what_happens_to_jobs_costs_the_runs_in_them_alone(tmp_path: Path) -> None:
    """The node of a job goes down, others reach the walltime, are cancelled, preempted, requeued.

    In the end the calibration is, to the last digit, what it is on this machine; and so is one of a
    real heap.
    """
    drum, here = drum_folder(tmp_path / "drum"), drum_folder(tmp_path / "drum here")
    disturbances = (
        *(take_its_node_down, preempt),
        *(let_its_time_run_out, cancel, preempt_and_requeue),
    )
    many = {"max_runs": 40, "design_runs": 32}
    disturbed = []
    with ThreadPoolExecutor() as threads:
        drums = threads.submit(calibrate_drum, drum, ONE_JOB, **many)
        for disturb in disturbances:
            # A run that is lost three times is given up: each time it is another one.
            enough = len(calls(drum)) + 2
            until(lambda enough=enough: len(calls(drum)) >= enough)
            disturbed.append(halt(drum))
            disturb(disturbed[-1])
            if len(disturbed) == 2:
                # Not before: the node was that of all jobs.
                heaps = threads.submit(calibrate_heap, tmp_path / "heap", ONE_JOB)
                drums_alone = threads.submit(calibrate_drum, here, None, **many)
        heaps_alone = threads.submit(calibrate_heap, tmp_path / "heap here", None)
    assert same(drums.result()) == same(drums_alone.result())
    assert same(heaps.result()) == same(heaps_alone.result())
    assert len(calls(drum)) == len(calls(here)) + 5, "those that were lost, and no others"
    assert len(set(disturbed)) == 5
    # The last one was requeued, and cancelled in the end.
    ends = ["NODE_FAIL", "PREEMPTED", "TIMEOUT", "CANCELLED", "CANCELLED"]
    assert [jobs()[job] for job in disturbed] == ends


@pytest.mark.usefixtures("_quick")
def test_who_watches_sees_the_queue(tmp_path: Path) -> None:
    drum = drum_folder(tmp_path / "drum")
    (drum / "hold").touch()

    def watched() -> list[tuple[str, str]]:
        reading = read_folder(drum / "work")
        rows = state_of(reading, None)["jobs"] if reading.is_running else []
        return [(row["number"], row["state"]) for row in rows]

    with ThreadPoolExecutor() as threads:
        drums = threads.submit(calibrate_drum, drum, ONE_JOB, max_runs=7)
        until(lambda: watched() and watched()[0][1] == "running")
        [(number, _)] = watched()
        assert jobs()[number] == "RUNNING"
        (drum / "hold").unlink()
    assert drums.result().runs.total > 0


def halt(folder: Path) -> str:
    """Have the next run halt, wait until it has, and return its job."""
    (folder / "halt").touch()
    halted = folder / "halted"
    until(lambda: halted.exists() and halted.read_text())
    job = halted.read_text()
    halted.unlink()
    return job


@pytest.fixture
def _whole_cluster(slurm: Path) -> Iterator[None]:
    """Have controller and nodes in the end, whatever happened to them."""
    yield
    for name, *start in (("slurmctld", "slurmctld"), *NODES):
        if not is_running(slurm, name):
            slurm_says(*start)
    for node, *_ in NODES:
        if "DOWN" in slurm_says("scontrol", "show", "node", node):
            set_node(node, "resume")
    until(lambda: slurm_says("sinfo", "-h", "-p", "short", "-t", "idle", "-o", "%D").strip() == "2")


@contextmanager
def silent_controller(slurm: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """Kill Slurm's controller, and start it again in the end."""
    # Slurm's commands give up after 1 s instead of 9 s.
    impatient = slurm / "impatient.conf"
    usual = (slurm / "slurm.conf").read_text()
    impatient.write_text(f"{usual}\nMessageTimeout=2\n")
    kill_daemon(slurm, "slurmctld")
    with monkeypatch.context() as patch:
        patch.setenv("SLURM_CONF", str(impatient))
        try:
            yield
        finally:
            slurm_says("slurmctld")


@pytest.mark.usefixtures("_quick", "_whole_cluster")
@pytest.mark.thorough
def test_a_silent_controller_and_a_lost_node_cost_the_current_runs_alone(
    slurm: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A calibration over two nodes goes on without Slurm's controller, and without one node.

    While the controller is silent, one more executor needs a second job, and another one whose job
    is lost needs a new one: both get it afterwards.
    """
    monkeypatch.setattr(slurm_jobs, "_FAILED_START_SECONDS", 3.0)
    drum, here = drum_folder(tmp_path / "drum"), drum_folder(tmp_path / "drum here")
    # Two such jobs do not fit on one node.
    over_both = replace(ONE_JOB, jobs=2, cores_per_run=5)
    many = {"max_runs": 40, "design_runs": 32, "workers": 2}
    hold, free = drum / "hold", tmp_path / "free"
    hold.touch()
    with ThreadPoolExecutor() as threads, ExitStack() as stack:
        stack.callback(hold.unlink, missing_ok=True)
        drums = threads.submit(calibrate_drum, drum, over_both, **many)
        drums_alone = threads.submit(calibrate_drum, here, None, **many)
        growing = stack.enter_context(
            cluster_executor(replace(ONE_JOB, jobs=2), tmp_path / "growing")
        )
        losing = stack.enter_context(cluster_executor(ONE_JOB, tmp_path / "losing"))
        wait = f"touch {free}.awaited; while [ ! -e {free} ]; do sleep 0.1; done"
        stack.callback(free.touch)
        growing.submit(subprocess.run, ["sh", "-c", wait], check=True)
        lost_job = losing.submit(*WHERE).result(NEVER_HERE)
        slurm_says("scontrol", "update", f"jobid={lost_job}", "requeue=1")
        cancel(lost_job)
        until(lambda: not has_a_job(losing))
        # Requeued by an administrator, it would be one job too many.
        slurm_says("scontrol", "requeue", lost_job)
        until(lambda: jobs()[lost_job] == "CANCELLED")
        until(Path(f"{free}.awaited").exists)
        until(lambda: len(calls(drum)) == 2)
        assert {node_of(job) for job in calls(drum)} == {"node1", "node2"}

        with silent_controller(slurm, monkeypatch):
            waiting = [executor.submit(*WHERE) for executor in (growing, losing)]
            hold.unlink()
            until(lambda: len(calls(drum)) >= 8)
            hold.touch()
            for folder in ("growing", "losing"):
                until(lambda folder=folder: submissions(tmp_path / folder) >= 5)
        assert len({lost_job, *(future.result(NEVER_HERE) for future in waiting)}) == 3
        stack.close()

        lost_job = halt(drum)
        node = node_of(lost_job)
        kill_daemon(slurm, node)
        end_its_processes(lost_job)
        so_far = len(calls(drum))
        until(lambda: len(calls(drum)) >= so_far + 3)
        set_node(node, "down")
        until(lambda: jobs()[lost_job] == "NODE_FAIL")
    there, alone = drums.result(), drums_alone.result()
    assert there.status == alone.status == "calibrated"
    assert designed(there) == designed(alone)
    assert there.parameters == pytest.approx(alone.parameters, rel=0.02)
    made = [run for summary in there.history for run in summary.runs.values()]
    assert len(made) == len(set(made))
    assert len(calls(drum)) == len(made) + 1, "the one that was lost, and no others"


#: A call whose result is the job that executes it.
WHERE = (os.getenv, "SLURM_JOB_ID")


def has_a_job(executor: object) -> bool:
    """Return True as long as an executor believes to have a job, or workers in it."""
    parsl = executor._kernel.executors["grainfit"]
    ended = all(status.terminal for status in parsl.status_facade.values())
    return bool(parsl.connected_managers()) or not ended


def submissions(folder: Path) -> int:
    """Number of jobs that were submitted, or should have been."""
    scripts = (folder / "parsl").glob("*/submit_scripts/parsl.grainfit.block-*")
    return len({path.name.split(".")[2] for path in scripts})


def designed(result: Result) -> dict[tuple[object, ...], object]:
    """Responses at the parameter sets that do not depend on the order in which runs end."""
    stage = result.history[0].stage
    runs = [run for run in result.history if run.stage == stage]
    return {(*run.parameters.values(), run.seed): run.responses for run in runs}


def order(solver: Solver, folder: Path) -> RunTask:
    (folder / "runs").mkdir(parents=True, exist_ok=True)
    record = RunRecord(solver.name, "packing", "running", solver.definition({}, 1))
    return RunTask(record, solver, {}, 1, folder)


@pytest.mark.thorough
@pytest.mark.parametrize("nodes", [1, 2])
def test_runs_of_several_ranks_are_the_same_in_a_job(
    slurm: Path, tmp_path: Path, nodes: int
) -> None:
    # Ranks that wait for each other keep the cores busy: a few hundred particles are enough.
    bed = Packing(diameter=0.01, cylinder_radius=0.04, fill_height=0.07)
    solvers: list[Solver] = [Lammps(bed, GLASS_BEADS, ranks=2)]
    if shutil.which("liggghts"):
        solvers.append(Liggghts(bed, GLASS_BEADS, ranks=2))
    here, there = tmp_path / "here", tmp_path / "there"

    def ranks_started() -> list[int]:
        """How often MPI's launcher had each node start ranks."""
        logs = [(slurm / f"node{n}.log").read_text(encoding="utf-8") for n in (1, 2)]
        return [len(re.findall(r"launch task StepId=\d+\.\d+ request", log)) for log in logs]

    before = ranks_started()
    options = replace(ONE_JOB, cores_per_run=2, nodes_per_run=nodes)
    with cluster_executor(options, there) as executor:
        futures = [executor.submit(execute, order(solver, there)) for solver in solvers]
        alone = [execute(order(solver, here)) for solver in solvers]
        in_job = [future.result(120) for future in futures]
    assert [record.reason for record in alone + in_job] == [""] * 2 * len(solvers)
    assert [record.responses for record in in_job] == [record.responses for record in alone]
    started = [now - then for now, then in zip(ranks_started(), before, strict=True)]
    assert started == ([len(solvers)] * 2 if nodes == 2 else [0, 0])


def test_jobs_that_cannot_start_end_the_calibration_with_the_reason(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(slurm_jobs, "_FAILED_START_SECONDS", 3.0)
    monkeypatch.setattr(followed, "_STATUS_SECONDS", 2)
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
        assert messages.NO_JOB_STARTS.is_in(said)
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
    assert messages.NO_SCHEDULER.is_in(said)
    assert ", 0 reused" not in said
    assert set(jobs()) - before == {job}
    result = json.loads((folder / "sand.grainfit" / "result.json").read_text())
    assert result["status"] == "calibrated"
