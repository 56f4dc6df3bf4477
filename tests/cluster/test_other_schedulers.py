"""Calibrations in jobs of a real Grid Engine, and of stubs of PBS and LSF.

No PBS and no LSF can be had from Debian: `commands_like` answers as their manuals document it.
"""

from __future__ import annotations

import os
import subprocess
import sys
import time
from collections.abc import Iterator
from concurrent.futures import Executor
from pathlib import Path

import pytest

import grainfit as gf
from grainfit.campaign import messages
from grainfit.campaign.cluster import followed, parsl_executor
from grainfit.campaign.cluster import slurm as slurm_jobs
from grainfit.campaign.cluster.executor import cluster_executor
from grainfit.campaign.cluster.options import ClusterOptions
from grainfit.errors import ExecutorError
from grainfit.result import Result
from grainfit.solvers.own_model.python_callable import PythonCallable
from tests.cluster.conftest import started

pytest.importorskip("parsl")
pytestmark = pytest.mark.slow

PROGRAMS = ("sge_qmaster", "sge_execd", "qsub", "qconf")
HILL = """
import os
import random
from pathlib import Path

def hill(parameters, seed):
    with (Path(__file__).parent / "calls").open("a") as calls:
        calls.write(os.environ.get("JOB_ID", "none") + "\\n")
    return {"angle": 20 + 40 * parameters["friction"] + random.Random(seed).gauss(0, 0.3)}
"""
#: A scheduler of one node in a file: jobs are started at once, and end with their script.
STUB = """#!{python}
import json, os, signal, subprocess, sys
from pathlib import Path

name, given = Path(sys.argv[0]).name, sys.argv[1:]
jobs = Path(__file__).parent / "jobs"
jobs.mkdir(exist_ok=True)

def alive(job):
    try:
        os.killpg(int((jobs / job).read_text()), 0)
        return True
    except OSError:
        return False

if name in ("qsub", "bsub"):
    script = Path(given[-1]).read_text() if name == "qsub" else sys.stdin.read()
    (jobs.parent / "script").write_text(script)
    if "nope" in given or "-q nope" in script:
        sys.exit("qsub: Unknown queue" if name == "qsub" else "nope: No such queue.")
    job = str(100 + len(list(jobs.iterdir())))
    with open(jobs.parent / "output", "ab") as output:
        started = subprocess.Popen(
            ["bash", "-c", script], stdout=output, stderr=output, start_new_session=True
        )
    (jobs / job).write_text(str(started.pid))
    print(f"{{job}}.server" if name == "qsub" else f"Job <{{job}}> is submitted to queue <normal>.")
elif name == "qstat" and "json" in given:
    wanted = [one for one in given if one[0].isdigit()]
    states = {{one: {{"job_state": "R" if alive(one.split(".")[0]) else "F"}} for one in wanted}}
    print(json.dumps({{"Jobs": states}}))
elif name == "qstat":
    for one in [job.name for job in jobs.iterdir()]:
        if alive(one):
            print(f"{{one}}.server hill root 0 R workq")
elif name == "bjobs":
    for one in [job.name for job in jobs.iterdir()]:
        if alive(one):
            print(one if "jobid" in given else f"{{one}} RUN")
elif name in ("qdel", "bkill"):
    for one in given:
        try:
            os.killpg(int((jobs / one.split(".")[0]).read_text()), signal.SIGTERM)
        except OSError:
            pass
"""


@pytest.fixture(scope="module")
def _grid_engine() -> Iterator[Path]:
    packages = "gridengine-master gridengine-exec"
    with started("Grid Engine", "gridengine", PROGRAMS, packages, 2) as folder:
        yield folder


@pytest.fixture
def grid_engine(_grid_engine: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[ClusterOptions]:
    """Options of a Grid Engine whose commands work here, and that has no job afterwards."""
    for line in (_grid_engine / "environment").read_text().split():
        monkeypatch.setenv(*line.split("="))
    yield ClusterOptions("sge", partition="short", walltime=600.0, runs_per_job=2)
    assert qstat() == ""


def qstat() -> str:
    return subprocess.run(["qstat"], capture_output=True, text=True, check=True).stdout


@pytest.fixture(autouse=True)
def _quick(monkeypatch: pytest.MonkeyPatch) -> None:
    for name, seconds in (("HEARTBEAT", 2), ("LOST", 6), ("STATUS", 2), ("LOOK", 1)):
        home = followed if name == "STATUS" else parsl_executor
        monkeypatch.setattr(home, f"_{name}_SECONDS", seconds)
    monkeypatch.setattr(slurm_jobs, "_FAILED_START_SECONDS", 3.0)


def commands_like(scheduler: str, folder: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Put commands that answer like those of a scheduler first on the path."""
    folder.mkdir()
    for name in {"pbs": ("qsub", "qstat", "qdel"), "lsf": ("bsub", "bjobs", "bkill")}[scheduler]:
        (folder / name).write_text(STUB.format(python=sys.executable))
        (folder / name).chmod(0o755)
    monkeypatch.setenv("PATH", f"{folder}{os.pathsep}{os.environ['PATH']}")
    return folder


def calibrate(folder: Path, options: ClusterOptions | None) -> Result:
    folder.mkdir()
    (folder / "hill.py").write_text(HILL)
    problem = gf.Problem(
        [gf.Parameter("friction", 0.1, 0.9)], [gf.Target("angle", 36.0, uncertainty=0.4)]
    )
    solver = PythonCallable.from_file(f"{folder}/hill.py:hill", ["angle"])

    def calibrated(executor: Executor | None) -> Result:
        strategy = gf.Sequential(design_runs=4)
        given = {"max_runs": 8, "seed": 3, "verification_runs": 2, "workers": 1}
        return gf.calibrate(
            problem, solver, workdir=folder / "work", strategy=strategy, executor=executor, **given
        )

    if options is None:
        return calibrated(None)
    with cluster_executor(options, folder / "work") as executor:
        return calibrated(executor)


def test_grid_engine_gives_what_this_machine_gives(
    grid_engine: ClusterOptions, tmp_path: Path
) -> None:
    here = calibrate(tmp_path / "here", None)
    there = calibrate(tmp_path / "there", grid_engine)

    assert (there.status, there.parameters) == (here.status, here.parameters)
    assert there.responses == here.responses
    jobs = set((tmp_path / "there" / "calls").read_text().split())
    assert len(jobs) == 1
    assert jobs.pop().isdigit()
    [script] = (tmp_path / "there" / "work" / "parsl").rglob("*.submit")
    text = script.read_text()
    assert "#$ -pe smp 2\n" in text
    assert "#$ -l h_rt=00:10:00\n" in text


def test_grid_engine_says_why_no_job_starts(grid_engine: ClusterOptions, tmp_path: Path) -> None:
    for number, (change, words) in enumerate(
        (
            ({"partition": "nope"}, 'requests unknown queue "nope"'),
            ({"setup": ("echo no such module >&2; exit 3",)}, "no such module"),
            ({"account": "nope"}, 'the requested project "nope" does not exist'),
        )
    ):
        given = {**vars(grid_engine), **change}
        started = time.monotonic()
        with pytest.raises(ExecutorError) as caught:
            calibrate(tmp_path / str(number), ClusterOptions(**given))
        assert time.monotonic() - started < 60
        assert messages.NO_JOB_STARTS.is_in(str(caught.value))
        assert words in str(caught.value)


@pytest.mark.parametrize(
    ("scheduler", "option", "lines"),
    [
        ("pbs", ":mem=4gb", ("#PBS -l select=1:ncpus=2:mem=4gb", "#PBS -l walltime=00:10:00")),
        ("lsf", '-R "rusage[mem=4096]"', ("#BSUB -n 2", "#BSUB -q normal", "#BSUB -W 10")),
    ],
)
def test_commands_of_pbs_and_lsf_are_those_of_their_manuals(
    scheduler: str,
    option: str,
    lines: tuple[str, ...],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    stub = commands_like(scheduler, tmp_path / "bin", monkeypatch)
    given = {"walltime": 600.0, "runs_per_job": 2, "options": (option,)}

    done = calibrate(tmp_path / "there", ClusterOptions(scheduler, partition="normal", **given))

    here = calibrate(tmp_path / "here", None)
    assert (done.parameters, done.responses) == (here.parameters, here.responses)
    script = (stub / "script").read_text().splitlines()
    for line in lines:
        assert line in script
    with pytest.raises(ExecutorError, match=r"Unknown queue|No such queue"):
        calibrate(tmp_path / "nope", ClusterOptions(scheduler, partition="nope", **given))
