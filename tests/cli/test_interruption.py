"""Ctrl-C, SIGTERM and a closed terminal end a command in order: solvers, result, one line."""

from __future__ import annotations

import json
import os
import pty
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

#: Notes its number outside its folder, leaves it, and simulates for ever.
FILE = """
name = "sand"

[parameters]
friction = { min = 0.1, max = 0.9 }

[[test]]
type = "command"
folder = "model"
command = ["sh", "-c", "echo $$ >> PIDS; cd /; exec sleep 600", "{{ friction }}"]
targets.angle = { value = 36, uncertainty = 0.4 }
"""
#: Takes the terminal of its standard input as its own, as a shell does.
IN_TERMINAL = (
    "import fcntl, os, sys, termios; fcntl.ioctl(0, termios.TIOCSCTTY, 0);"
    "os.execv(sys.argv[1], sys.argv[1:])"
)
#: A report whose libraries are interrupted in the middle.
REPORT = """
import os, sys, time, types
from grainfit.cli.main import main

class Reference:
    def __del__(self):
        os.kill(os.getpid(), NUMBER)
        time.sleep(60)

def write_report(*_given, **_options):
    BODY

# The real one takes seconds to import.
sys.modules["grainfit.report.page"] = types.SimpleNamespace(write_report=write_report)
sys.argv = ["grainfit", "report", "."]
main()
"""
INTERRUPTED_AT = {
    "work": "os.kill(os.getpid(), NUMBER); time.sleep(60)",
    "an import": """
    try:
        os.kill(os.getpid(), NUMBER)
        time.sleep(60)
    except KeyboardInterrupt:
        raise ImportError("a part of the library is missing")""",
    "a destructor": "Reference(); time.sleep(60)",
}


@pytest.fixture(autouse=True)
def _all_signals(ctrl_c: None) -> Iterator[None]:
    """Let SIGHUP end the children of a test, also under ``nohup``."""
    before = signal.signal(signal.SIGHUP, signal.SIG_DFL)
    yield
    signal.signal(signal.SIGHUP, before)


def calibration(folder: Path) -> Path:
    (folder / "model").mkdir()
    (folder / "model" / "deck").write_text("")
    file = folder / "sand.toml"
    file.write_text(FILE.replace("PIDS", str(folder / "pids")))
    return file


def wait_for(condition: Callable[[], bool], seconds: float = 60.0) -> bool:
    deadline = time.monotonic() + seconds
    while time.monotonic() < deadline:
        if condition():
            return True
        time.sleep(0.05)
    return False


def solvers(folder: Path) -> list[int]:
    try:
        return [int(pid) for pid in (folder / "pids").read_text().split()]
    except FileNotFoundError:
        return []


def start(folder: Path, *arguments: str, terminal: int | None = None) -> subprocess.Popen[str]:
    """Start a command with two workers, in a terminal of its own if there is one."""
    command = [sys.executable, "-m", "grainfit", *arguments, "--workers", "2"]
    if terminal is not None:
        command = [sys.executable, "-c", IN_TERMINAL, *command]
    process = subprocess.Popen(
        command,
        cwd=folder,
        stdin=terminal,
        stdout=subprocess.PIPE if terminal is None else terminal,
        stderr=subprocess.PIPE if terminal is None else terminal,
        start_new_session=terminal is not None,
        text=True,
    )
    assert wait_for(lambda: len(solvers(folder)) == 2 or process.poll() is not None)
    assert process.poll() is None
    return process


def test_a_closed_terminal_ends_the_solvers_and_leaves_a_result(tmp_path: Path) -> None:
    file = calibration(tmp_path)
    screen, terminal = pty.openpty()
    process = start(tmp_path, "run", file.name, "--no-report", terminal=terminal)
    os.close(terminal)
    os.close(screen)

    assert process.wait(60) == 130
    assert not any(Path(f"/proc/{pid}").exists() for pid in solvers(tmp_path))
    result = json.loads((tmp_path / "sand.grainfit" / "result.json").read_text())
    assert result["status"] == "interrupted"


def test_a_simulation_ends_its_solvers_when_its_session_ends(tmp_path: Path) -> None:
    file = calibration(tmp_path)
    process = start(tmp_path, "simulate", file.name, "--repeat", "2")
    # A session that ends sends both at once: they are one request.
    for number in (signal.SIGTERM, signal.SIGHUP):
        process.send_signal(number)
    _, error = process.communicate(timeout=60)

    assert process.returncode == 130
    assert error.splitlines()[-1].startswith("Interrupted. Finished runs are kept")
    assert "Traceback" not in error
    assert not any(Path(f"/proc/{pid}").exists() for pid in solvers(tmp_path))


def test_a_command_that_ignores_closed_terminals_goes_on(tmp_path: Path) -> None:
    file = calibration(tmp_path)
    signal.signal(signal.SIGHUP, signal.SIG_IGN)
    process = start(tmp_path, "simulate", file.name, "--repeat", "2")
    process.send_signal(signal.SIGHUP)
    time.sleep(0.5)
    assert process.poll() is None
    process.send_signal(signal.SIGTERM)
    process.communicate(timeout=60)
    assert process.returncode == 130


@pytest.mark.parametrize(
    ("place", "number"),
    [
        ("work", signal.SIGTERM),
        ("work", signal.SIGINT),
        ("an import", signal.SIGTERM),
        ("a destructor", signal.SIGINT),
    ],
)
def test_an_interrupted_report_ends_with_one_line(
    tmp_path: Path, place: str, number: signal.Signals
) -> None:
    done = report(tmp_path, INTERRUPTED_AT[place], number)

    assert done.returncode == 130
    assert done.stderr == "Interrupted.\n"
    assert done.stdout == ""


def test_an_interrupt_that_was_handled_leaves_the_exit_code(tmp_path: Path) -> None:
    body = """
    try:
        exec("raise KeyboardInterrupt")
    except KeyboardInterrupt:
        return "page.html"
"""
    done = report(tmp_path, body, signal.SIGINT)

    assert done.returncode == 0
    assert done.stdout == "Report: page.html\n"


def report(folder: Path, body: str, number: signal.Signals) -> subprocess.CompletedProcess[str]:
    """Run ``grainfit report`` with this code in place of its work."""
    code = REPORT.replace("BODY", body).replace("NUMBER", str(int(number)))
    (folder / "interrupted_report.py").write_text(code)
    return subprocess.run(
        [sys.executable, "-m", "interrupted_report"],
        cwd=folder,
        capture_output=True,
        text=True,
        timeout=30,
        check=False,
    )
