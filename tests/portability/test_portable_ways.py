"""Ways that Windows and macOS have as well: everything but runs of DEM programs.

On Linux, grainfit is shown what Python has on the other system (`elsewhere/sitecustomize.py`).
"""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
from collections.abc import Callable, Iterator
from contextlib import suppress
from pathlib import Path

import pytest

from grainfit.campaign import messages as of_campaign
from grainfit.solvers.dem import messages as of_dem
from grainfit.watch import messages
from tests.cli.sand_files import FILE, MODEL

ROOT = Path(__file__).parents[2]
BEADS = ROOT / "examples" / "glass_beads" / "calibration.toml"
HERE = sys.platform in ("win32", "darwin")
SYSTEMS = [sys.platform] if HERE else ["win32", pytest.param("darwin", marks=pytest.mark.thorough)]
Start = Callable[..., subprocess.Popen[str]]

pytestmark = pytest.mark.portable

#: Many commands in one process: most of their time is that of imports.
COMMANDS = """
import json, sys
from typer.testing import CliRunner
from grainfit.cli.app import app

for arguments in json.loads(sys.argv[1]):
    done = CliRunner().invoke(app, arguments)
    print(done.output.encode("ascii", "replace").decode())
    print("exit code", done.exit_code)
    assert isinstance(done.exception, SystemExit | None), (arguments, done.exception)
"""
PAGE = """
from pathlib import Path
from urllib.request import urlopen
from grainfit.local_pages.server import listen
from grainfit.watch.server import WatchServer

server = WatchServer(Path("sand.grainfit"), listen(0))
server.serve()
print("page:", urlopen(server.address, timeout=60).status)
"""
#: The page of a run has a process of its own, which is given no socket on Windows.
PAGE_OF_A_RUN = """
from pathlib import Path
from urllib.request import urlopen
from grainfit.local_pages.server import address_of, listen, new_token
from grainfit.watch.child import WatchProcess

listening, token = listen(0), new_token()
address = address_of(listening, token)
process = WatchProcess(Path("beads"), listening, token, new_token())
print("page:", urlopen(address, timeout=60).status)
process.end()
assert process._process.wait(60) == 0
"""
HOLD = """
import sys
from pathlib import Path
from grainfit.campaign.folder_lock import hold
from grainfit.errors import StoreError

try:
    with hold(Path("work")):
        print("held", flush=True)
        sys.stdin.read()
except StoreError as error:
    print(error, flush=True)
"""
STOP = """
from pathlib import Path
from grainfit.watch.stopping import why_not_to_be_stopped

print(why_not_to_be_stopped(Path("work")))
"""
PROGRAMS = """
import sys, threading
from pathlib import Path
from grainfit.errors import RunFailedError
from grainfit.solvers.base import Workspace
from grainfit.solvers.process.process import recorded_faults, run_process

Path("run").mkdir()
for seconds in (0, 100):
    child = "import sys, time; print('begun', flush=True); time.sleep(float(sys.argv[1]))"
    program = "import subprocess, sys; subprocess.run([sys.executable, *sys.argv[1:]])"
    command = [sys.executable, "-c", program, "-c", child, str(seconds)]
    workspace = Workspace(Path("run"), timeout=3.0)
    try:
        with recorded_faults(workspace):
            run_process(command, workspace)
        print("ended", flush=True)
    except RunFailedError as error:
        print(error.kind, error.log_tail, flush=True)
"""


@pytest.fixture(params=SYSTEMS)
def system(request: pytest.FixtureRequest) -> str:
    """System that grainfit sees, as `sys.platform` has it."""
    return str(request.param)


@pytest.fixture
def start(system: str, tmp_path: Path) -> Iterator[Start]:
    """Start Python in a folder, as on another system."""
    variables = {**os.environ, "PATH": str(tmp_path), "OMP_NUM_THREADS": "1"}
    if HERE:
        variables["PATH"] = os.environ["PATH"]
    else:
        elsewhere = Path(__file__).with_name("elsewhere")
        paths = [str(elsewhere), os.environ.get("PYTHONPATH", "")]
        variables["PYTHONPATH"] = os.pathsep.join(filter(None, paths))
        variables["SYSTEM_OF_THE_TESTS"] = system
    started: list[subprocess.Popen[str]] = []

    def start(*arguments: str) -> subprocess.Popen[str]:
        process = subprocess.Popen(
            [sys.executable, *arguments],
            cwd=tmp_path,
            env=variables,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            encoding="utf-8",
            errors="replace",
        )
        started.append(process)
        return process

    yield start
    for process in started:
        process.kill()
        with suppress(ValueError):
            process.communicate()


def said_by(process: subprocess.Popen[str], code: int = 0) -> str:
    said = process.communicate(timeout=300)[0]
    assert process.returncode == code, said
    return said


@pytest.fixture
def sand(tmp_path: Path) -> Path:
    (tmp_path / "model.py").write_text(MODEL, encoding="utf-8")
    (tmp_path / "sand.toml").write_text(FILE, encoding="utf-8")
    return tmp_path / "sand.grainfit"


def test_own_python_model_is_calibrated_reported_and_watched(
    system: str, start: Start, sand: Path, tmp_path: Path
) -> None:
    (tmp_path / "beads.toml").write_text(
        BEADS.read_text(encoding="utf-8").replace('"lammps"', '"liggghts"'), encoding="utf-8"
    )
    commands = [
        ["run", "sand.toml", "--no-report"],
        ["report", "sand.grainfit"],
        ["check", "beads.toml"],
    ]
    said = said_by(start("-c", COMMANDS + PAGE, json.dumps(commands)))

    assert [line for line in said.splitlines() if line.startswith("exit code")] == [
        "exit code 0",
        "exit code 0",
        "exit code 1",
    ]
    assert json.loads((sand / "result.json").read_text(encoding="utf-8"))["status"] == "calibrated"
    assert (sand / "report.html").stat().st_size > 1_000_000
    assert said.splitlines()[-1] == "page: 200"
    words = " ".join(said.split())
    assert "LIGGGHTS (liggghts) is not found" in words
    if system == "win32":
        assert of_dem.NOT_FOUND_ON_WINDOWS.is_in(words)


def test_a_work_folder_is_of_one_process_until_its_death(start: Start) -> None:
    first = start("-c", HOLD)
    assert first.stdout is not None
    assert first.stdout.readline().strip() == "held"

    assert of_campaign.FOLDER_IN_USE.is_in(said_by(start("-c", HOLD)), process=first.pid)
    assert messages.NO_SIGNALS.is_in(said_by(start("-c", STOP)))
    first.kill()
    first.wait()
    third = start("-c", HOLD)
    assert said_by(third) == "held\n"


@pytest.mark.thorough
def test_programs_are_run_and_ended_with_all_that_they_started(start: Start) -> None:
    ended, _, timeout = said_by(start("-c", PROGRAMS)).partition("\n")

    assert ended == "ended"
    assert timeout == "timeout begun\n"


@pytest.mark.thorough
def test_estimate_photograph_report_and_page_of_a_recorded_calibration(
    start: Start, tmp_path: Path
) -> None:
    shutil.copytree(ROOT / "docs" / "recorded" / "beads", tmp_path / "beads")
    shutil.copy(ROOT / "examples" / "phone" / "heap" / "side_1.jpg", tmp_path)
    commands = [
        ["estimate", "--diameter", "3mm", "--bulk-density", "540", "--angle", "34deg"],
        ["photo", "side_1.jpg"],
        ["report", "beads"],
    ]
    said = said_by(start("-c", COMMANDS + PAGE_OF_A_RUN, json.dumps(commands)))

    assert said.count("exit code 0") == len(commands)
    assert said.splitlines()[-1] == "page: 200"
    assert "particle_particle.rolling_friction" in said
    assert "angle_of_repose" in said
    assert (tmp_path / "beads" / "report.html").stat().st_size > 1_000_000
