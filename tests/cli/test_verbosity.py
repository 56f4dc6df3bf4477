"""Output for terminals and pipes, --quiet and --verbose, version and completion."""

from __future__ import annotations

import contextlib
import os
import pty
import re
import subprocess
import sys
from importlib.metadata import version
from pathlib import Path

import pytest
from typer.testing import CliRunner, Result

from grainfit.cli import messages
from grainfit.cli.app import app

MODEL = """
import time

def drum(parameters, seed):
    time.sleep(0.3)
    return {"angle": 20 + 40 * parameters["friction"] + seed % 7 * 0.01}
"""

FILE = """
name = "sand"

[parameters]
friction = { min = 0.123456, max = 0.987654 }

[[test]]
type = "python"
function = "model.py:drum"
targets.angle = { value = 36, uncertainty = 0.4, unit = "deg" }
"""


@pytest.fixture(scope="module")
def sand(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with a calibration file, and its work folder after ``grainfit run``."""
    folder = tmp_path_factory.mktemp("sand")
    (folder / "sand.toml").write_text(FILE)
    (folder / "model.py").write_text(MODEL.replace("0.3", "0"))
    with contextlib.chdir(folder):
        grainfit("run", "sand.toml", "--no-report")
    return folder


@pytest.fixture
def in_sand(sand: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(sand)


def grainfit(*arguments: str, **env: str) -> Result:
    done = CliRunner().invoke(app, arguments, env=env)
    assert done.exit_code == 0, done.output
    return done


def on_terminal(*arguments: str, folder: Path, answers: str = "") -> str:
    """Return what a terminal of 100 columns is sent by a command, which reads some answers."""
    master, slave = pty.openpty()
    process = subprocess.Popen(
        [sys.executable, "-m", "grainfit", *arguments],
        cwd=folder,
        stdin=slave,
        stdout=slave,
        stderr=slave,
        env={**os.environ, "COLUMNS": "100", "TERM": "xterm"},
    )
    os.close(slave)
    os.write(master, answers.encode())
    sent = b""
    try:
        while chunk := os.read(master, 65536):
            sent += chunk
    except OSError:
        # The terminal of a process that has ended cannot be read.
        pass
    os.close(master)
    assert process.wait(timeout=60) == 0, sent.decode()
    return sent.decode()


def test_version_is_that_of_the_package() -> None:
    assert grainfit("--version").stdout == f"grainfit {version('grainfit')}\n"


@pytest.mark.usefixtures("in_sand")
@pytest.mark.parametrize("arguments", [("-q", "run"), ("run", "--quiet")])
def test_quiet_calibration_prints_only_how_it_ended(arguments: tuple[str, ...]) -> None:
    done = grainfit(*arguments, "sand.toml", "--no-report")
    assert done.stdout == "sand: calibrated: every target is met within its tolerance\n"
    assert done.stderr == ""
    assert "DEM runs" in grainfit("run", "sand.toml", "--no-report").stdout


@pytest.mark.usefixtures("in_sand")
def test_verbose_calibration_prints_every_run() -> None:
    usual = grainfit("run", "sand.toml", "--no-report")
    verbose = grainfit("run", "-v", "sand.toml", "--no-report")
    runs = re.findall(
        r"^\w+ run ([0-9a-f]{7}): friction = \S+ -> angle = \S+ ", verbose.stderr, re.M
    )
    listed = grainfit("runs", "list", "sand.grainfit").stdout
    assert set(runs) == set(re.findall(r"^[0-9a-f]{7}\b", listed, re.M))
    assert " -> " not in usual.stderr


@pytest.mark.usefixtures("in_sand")
@pytest.mark.parametrize(
    "command",
    [
        ["check", "sand.toml"],
        ["status", "sand.grainfit"],
        ["run", "sand.toml", "--no-report"],
        ["analyse", "sand.toml", "--runs", "sand.grainfit"],
    ],
)
def test_output_that_is_no_terminal_breaks_no_line_and_cuts_no_number(command: list[str]) -> None:
    narrow, wide = (grainfit(*command, COLUMNS=columns).stdout for columns in ("40", "400"))
    without_time = re.compile(r"\d+ s, workers busy \d+%")
    assert without_time.sub("", narrow) == without_time.sub("", wide)
    assert "…" not in narrow
    if command[0] == "check":
        assert re.search(r"^friction +0\.1235 +0\.9877 +linear", narrow, re.M)


def test_terminal_shows_a_bar_with_stage_runs_deviation_and_time(tmp_path: Path) -> None:
    (tmp_path / "sand.toml").write_text(FILE)
    (tmp_path / "model.py").write_text(MODEL)
    sent = on_terminal("run", "sand.toml", "--no-report", "--workers", "1", folder=tmp_path)
    drawn = " ".join(re.sub(r"\x1b\[[0-9;?]*[A-Za-z]", " ", sent).split())
    assert "━━━━" in drawn
    assert re.search(
        r"optimisation: \d+ done, 1 running, 0 failed, (about )?\d+ (\(\d+ to \d+\) )?to come",
        drawn,
    )
    assert re.search(r"answer expected within \d+\.\d%", drawn)
    assert re.search(r"(\d+ s to|about) \d+ s left", drawn)


@pytest.mark.usefixtures("in_sand")
def test_without_a_terminal_progress_is_plain_lines() -> None:
    done = grainfit("run", "sand.toml", "--no-report", "--workdir", "again")
    assert done.stderr.startswith("design: 0 done")
    assert not set("\x1b\r━") & set(done.output)


def completed(words: str, folder: Path) -> list[str]:
    """Return what bash offers for the last word."""
    done = subprocess.run(
        [Path(sys.executable).with_name("grainfit")],
        cwd=folder,
        env={
            **os.environ,
            "_GRAINFIT_COMPLETE": "complete_bash",
            "COMP_WORDS": words,
            "COMP_CWORD": str(words.count(" ")),
        },
        capture_output=True,
        text=True,
        check=True,
    )
    return done.stdout.split()


def test_bash_completes_commands_runs_parameters_and_materials(sand: Path) -> None:
    assert completed("grainfit st", sand) == ["start", "status", "stiffness"]
    with contextlib.chdir(sand):
        listed = grainfit("runs", "list", "sand.grainfit").stdout
    runs = sorted(re.findall(r"^[0-9a-f]{7}\b", listed, re.M))
    assert completed("grainfit runs show sand.grainfit ", sand) == runs
    assert completed(f"grainfit runs show sand.grainfit {runs[0][:4]}", sand) == [runs[0]]
    assert completed("grainfit runs show nowhere ", sand) == []
    assert completed("grainfit simulate sand.toml --set fr", sand) == ["friction="]
    (sand / "marked.toml").write_text(FILE, encoding="utf-8-sig")
    assert completed("grainfit simulate marked.toml --set fr", sand) == ["friction="]
    assert completed("grainfit new x.toml --material pl", sand) == ["plastic_pellets"]


def test_new_asks_for_material_and_tests_on_a_terminal(tmp_path: Path) -> None:
    sent = on_terminal(
        "new", "p.toml", folder=tmp_path, answers="wood\nplastic\nheap, 99\nheap, 4\n"
    )
    written = (tmp_path / "p.toml").read_text()
    assert sent.count(messages.NOT_IN_LIST()) == 2, sent
    assert "STARTING VALUES for plastic pellets" in written
    assert re.findall(r'^type = "(\w+)"', written, re.M) == ["heap", "drum"]
    shown = " ".join(sent.split())
    assert "particle.density is free, 850 kg/m^3 to 1050 kg/m^3. Polyethylene" in shown
