"""The command that is executed at the end of a run."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import time
from pathlib import Path

import pytest

from grainfit.cli import messages, notification
from grainfit.cli.notification import notifying

FILE = """
name = "sand $(touch executed)"

[parameters]
friction = { min = 0.1, max = 0.9 }

[[test]]
type = "python"
function = "model.py:drum"
targets.angle = { value = 36, tolerance = 0.4 }
"""
MODEL = """
import os, signal, time

def drum(parameters, seed):
    BODY
    return {"angle": 20 + 40 * parameters["friction"]}
"""
INTERRUPT = "os.kill(os.getpid(), signal.SIGTERM); time.sleep(60)"
FAIL = "raise ValueError('the drum broke')"
#: Writes what it was told.
TELL = (
    f"{sys.executable} -c 'import json, os; json.dump({{k: v for k, v in os.environ.items() "
    'if k.startswith("GRAINFIT_")}, open("told.json", "w"))\''
)


def grainfit(folder: Path, command: str, body: str = "") -> subprocess.CompletedProcess[str]:
    (folder / "model.py").write_text(MODEL.replace("BODY", body or "pass"))
    (folder / "sand.toml").write_text(FILE)
    return subprocess.run(
        [sys.executable, "-m", "grainfit", "run", "sand.toml", "--no-report", "--notify", command],
        cwd=folder,
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
    )


def told(folder: Path) -> dict[str, str]:
    found: dict[str, str] = json.loads((folder / "told.json").read_text())
    return found


def test_the_command_is_told_the_result(tmp_path: Path) -> None:
    done = grainfit(tmp_path, TELL)
    assert done.returncode == 0
    work = tmp_path / "sand.grainfit"
    assert told(tmp_path) == {
        "GRAINFIT_STATUS": "calibrated",
        "GRAINFIT_HEADLINE": "sand $(touch executed): calibrated: every target is met within its "
        "tolerance",
        "GRAINFIT_WORKDIR": str(work),
        "GRAINFIT_RESULT": str(work / "result.json"),
        "GRAINFIT_REPORT": "",
    }
    assert not (tmp_path / "executed").exists()


@pytest.mark.parametrize(
    ("body", "code", "status", "words"),
    [
        (INTERRUPT, 130, "interrupted", "interrupted: start it again"),
        (FAIL, 1, "failed", "the drum broke"),
    ],
)
def test_the_command_is_told_of_a_run_that_did_not_end_well(
    tmp_path: Path, body: str, code: int, status: str, words: str
) -> None:
    done = grainfit(tmp_path, TELL, body)
    assert done.returncode == code
    assert told(tmp_path)["GRAINFIT_STATUS"] == status
    assert words in told(tmp_path)["GRAINFIT_HEADLINE"]


def test_a_command_that_fails_is_a_warning(tmp_path: Path) -> None:
    done = grainfit(tmp_path, "echo told; exit 7")
    assert done.returncode == 0
    assert "told" in done.stdout
    assert done.stderr.splitlines()[-1] == messages.NOTIFICATION_FAILED(reason="exit code 7")


def test_a_command_that_hangs_is_ended_with_all_that_it_started(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(notification, "LONGEST_SECONDS", 1.0)
    started = time.monotonic()
    with notifying(f"sleep 300 & echo $! > {tmp_path / 'pid'}; wait", tmp_path):
        pass
    # It would go on for five minutes.
    assert time.monotonic() - started < 150
    assert messages.NOTIFICATION_TOO_LONG(seconds=1) in capfd.readouterr().err
    process = Path(f"/proc/{(tmp_path / 'pid').read_text().strip()}/stat")
    deadline = time.monotonic() + 10
    while process.exists() and process.read_text().split()[2] != "Z":
        assert time.monotonic() < deadline
        time.sleep(0.05)


def test_an_interrupt_during_the_command_does_not_change_the_end(
    tmp_path: Path, ctrl_c: None, capfd: pytest.CaptureFixture[str]
) -> None:
    with notifying(f"kill -INT {os.getpid()}; sleep 300", tmp_path):
        pass
    assert "it was interrupted" in capfd.readouterr().err


def test_an_error_is_passed_on_after_the_command(tmp_path: Path) -> None:
    with (
        pytest.raises(ValueError, match="no"),
        notifying(f"echo $GRAINFIT_HEADLINE > {tmp_path / 'words'}; exit 1", tmp_path),
    ):
        raise ValueError("no\nlicence")
    assert (tmp_path / "words").read_text() == "no licence\n"
