"""Calibrations that tests watch: they stop and go as the test wants, and end within seconds."""

from __future__ import annotations

import os
import re
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

from grainfit.local_pages.server import listen
from grainfit.watch.server import WatchServer

#: Every run waits for the file GO; beyond BREAKS it fails.
FILE = """
name = "sand & <b>gravel</b>"

[parameters]
friction = { min = 0.1, max = 0.9 }

[strategy]
workers = 2

[[test]]
type = "command"
folder = "model"
command = ["sh", "simulate.sh", "{{ friction }}", "{{ seed }}"]
targets.angle = { value = 36, uncertainty = 0.4 }
"""
SCRIPT = """
while [ ! -e GO ]; do sleep 0.05; done
awk -v f=$1 -v seed=$2 'BEGIN { if (f > BREAKS) { print "the drum <i>broke</i>"; exit 3 }
    noise = 0.4 * ((seed * 7919 % 1009) / 1009 - 0.5)
    printf "{\\"angle\\": %.6f}", 20 + 40 * f + noise > "responses.json" }'
"""
NAME = "sand & <b>gravel</b>"


def wait_for(condition: Callable[[], object], seconds: float = 60.0) -> None:
    deadline = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < deadline, "waited in vain"
        time.sleep(0.05)


def calibration(folder: Path, breaks: float = 0.85) -> Path:
    """Write a calibration file whose runs wait until `go` is called."""
    (folder / "model").mkdir()
    script = SCRIPT.replace("GO", str(folder / "go")).replace("BREAKS", str(breaks))
    (folder / "model" / "simulate.sh").write_text(script)
    file = folder / "sand.toml"
    file.write_text(FILE)
    return file


def go(folder: Path) -> None:
    (folder / "go").touch()


@contextmanager
def run(file: Path, *options: str) -> Iterator[subprocess.Popen[str]]:
    """Start ``grainfit run``, and wait until two runs are under way."""
    work = file.parent / "sand.grainfit"
    with (file.parent / "errors").open("w") as errors:
        process = subprocess.Popen(
            [sys.executable, "-m", "grainfit", "run", file.name, "--no-report", *options],
            cwd=file.parent,
            stdout=subprocess.PIPE,
            stderr=errors,
            text=True,
        )
    try:
        wait_for(lambda: len(list(work.glob("runs/*.partial"))) == 2 or process.poll() is not None)
        yield process
    finally:
        if process.poll() is None:
            process.send_signal(signal.SIGTERM)
            process.communicate(timeout=60)
        # Solvers of a killed one would wait without end.
        go(file.parent)


def address(file: Path) -> str:
    """Return the address that a run has printed."""
    found = re.search(r"Watch: (\S+)", (file.parent / "errors").read_text())
    assert found
    return found[1]


@contextmanager
def served(folder: Path) -> Iterator[WatchServer]:
    """Serve the page of a folder in this process."""
    server = WatchServer(folder, listen(0))
    server.serve()
    try:
        yield server
    finally:
        server.follower.end()
        server.shutdown()
        server.server_close()


def is_alive(process: int) -> bool:
    try:
        os.kill(process, 0)
    except ProcessLookupError:
        return False
    return True
