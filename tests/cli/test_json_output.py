"""Documents of ``--json``: keys as in docs/command_line.md, on standard output alone."""

from __future__ import annotations

import json
import os
import re
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
from sand_files import FILE

from grainfit.calibration_file.starter import starter_file
from tests.commands import grainfit_here

DOCS = Path(__file__).parents[2] / "docs" / "command_line.md"

MODEL = """
import random

def drum(parameters, seed):
    if parameters["friction"] > 0.75:
        raise ValueError("the \\x1b[31mdrum broke")
    return {"angle": 20 + 40 * parameters["friction"] + random.Random(seed).gauss(0, 0.3)}
"""


def grainfit(folder: Path, *arguments: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [Path(sys.executable).with_name("grainfit"), *arguments],
        cwd=folder,
        capture_output=True,
        text=True,
        check=False,
        env=os.environ,
    )


def document(folder: Path, *arguments: str, code: int = 0) -> dict[str, Any]:
    done = grainfit_here(folder, *arguments, "--json")
    assert done.returncode == code, done.stdout + done.stderr
    assert done.stderr == ""
    found: dict[str, Any] = json.loads(done.stdout)
    assert found["document_version"] == 1
    assert {*found} - {"document", "document_version"} == documented(found["document"])
    return found


def documented(kind: str) -> set[str]:
    """Return the keys that the table of a document lists."""
    [section] = re.findall(
        rf"^### `{kind}`$(.*?)(?=^##|\Z)", DOCS.read_text(encoding="utf-8"), re.M | re.S
    )
    cells = re.findall(r"^\| (`[^|]+) \|", section, re.M)
    return {name for cell in cells for name in re.findall(r"`(\w+)`", cell)}


@pytest.fixture(scope="module")
def sand(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with a calibration that has ended; one of its runs failed."""
    folder = tmp_path_factory.mktemp("json")
    (folder / "sand.toml").write_text(FILE)
    (folder / "model.py").write_text(MODEL)
    done = grainfit(folder, "run", "-q", "sand.toml", "--no-report")
    assert done.returncode == 0, done.stdout + done.stderr
    return folder


def test_status_document_has_progress_and_values(sand: Path) -> None:
    status = document(sand, "status", "sand.grainfit")
    assert (status["document"], status["state"]) == ("status", "calibrated")
    assert status["stages"]["design"]["ended"] == status["stages"]["design"]["asked"] > 0
    assert [run["reason"] for run in status["failed"]] == ["ValueError: the \x1b[31mdrum broke"]
    found = status["parameters"]["friction"]
    assert found["low"] < found["value"] < found["high"]


def test_estimate_document_says_that_nothing_was_simulated(tmp_path: Path) -> None:
    heap = ("--diameter", "3mm", "--bulk-density", "540", "--angle", "34deg")
    found = document(tmp_path, "estimate", *heap)
    assert found["status"] == "estimate: not simulated"
    density = found["parameters"]["particle.density"]
    assert density["low"] < density["value"] < density["high"]
    angle = found["responses"]["angle_of_repose"]
    assert angle["measured"] == {"value": 34.0, "tolerance": 1.0}
    assert (angle["is_in_reach"], angle["agrees"]) == (True, True)


def test_an_estimate_that_is_less_sure_says_so_as_a_document_too(tmp_path: Path) -> None:
    heap = 'type = "heap"'
    file = starter_file(["heap"]).replace(heap, f'{heap}\nlift_speed = "500 mm/s"')
    (tmp_path / "fast.toml").write_text(file)

    found = document(tmp_path, "estimate", "fast.toml")

    assert all("lift_speed" in found["less_sure"][name] for name in found["responses"])


def test_result_document_is_the_result_file(sand: Path) -> None:
    result = document(sand, "result", "sand.grainfit")
    assert result["result"] == json.loads((sand / "sand.grainfit" / "result.json").read_text())
    shown = grainfit(sand, "result", "sand.grainfit").stdout
    assert shown.startswith("sand: calibrated: every target is met within its tolerance\n")
    assert "DEM runs: " in shown


def test_runs_documents_have_every_run(sand: Path) -> None:
    runs = document(sand, "runs", "list", "sand.grainfit")
    assert runs["total"] == len(runs["runs"]) > 5
    few = document(sand, "runs", "list", "sand.grainfit", "--limit", "2", "--status", "finished")
    assert (len(few["runs"]), few["total"]) == (2, runs["total"])
    [first, _] = few["runs"]
    shown = document(sand, "runs", "show", "sand.grainfit", first["identity"])
    assert first.items() <= shown["run"].items()
    assert first["responses"]["angle"]["value"] == pytest.approx(
        20 + 40 * first["parameters"]["friction"], abs=1.5
    )
    assert shown["run"]["folder"] is None, "a Python function has no run folder"


def test_check_document_says_whether_it_can_run(sand: Path) -> None:
    plan = document(sand, "check", "sand.toml")
    assert plan["is_ready"] is True
    assert 0 < plan["runs"][0] <= plan["runs"][1]
    assert plan["parameters"][0] == {
        "name": "friction",
        "minimum": 0.1,
        "maximum": 0.9,
        "scale": "linear",
        "unit": "",
    }


def test_errors_are_documents_and_keep_the_exit_code(tmp_path: Path) -> None:
    (tmp_path / "bad.toml").write_text(FILE.replace("max = 0.9", "max = 0.05"))
    fault = document(tmp_path, "check", "bad.toml", code=1)
    assert (fault["document"], fault["exit_code"], fault["kind"]) == ("error", 1, "InputError")
    assert fault["source"] == "bad.toml"
    one = next(one for one in fault["faults"] if one["key"] == "parameters.friction")
    assert one["line"] == 5
    assert "swapped" in one["message"]
    assert document(tmp_path, "status", "nowhere", code=1)["kind"] == "StoreError"
    for arguments in (["status"], ["status", "--what", "."], ["frobnicate"]):
        usage = document(tmp_path, *arguments, code=2)
        assert (usage["document"], usage["exit_code"]) == ("error", 2)
    assert "runs.sqlite" in document(tmp_path, "result", ".", code=1)["message"]
