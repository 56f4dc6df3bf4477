"""Glass beads on the real solvers, through the command line, from the example files."""

import json
import os
import re
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import pytest

from benchmarks import chromium
from benchmarks.axe import violations_in

EXAMPLES = Path(__file__).parents[2] / "examples" / "glass_beads"
pytestmark = pytest.mark.slow

needs_liggghts = pytest.mark.skipif(
    shutil.which("liggghts") is None, reason="LIGGGHTS is not installed: apt-get install liggghts"
)


def example(folder: Path, name: str, **changes: str) -> Path:
    """Copy an example, with parts of it replaced."""
    text = (EXAMPLES / name).read_text(encoding="utf-8")
    for old, new in changes.items():
        text, count = re.subn(rf"^{old} = .*$", f"{old} = {new}", text, flags=re.MULTILINE)
        assert count, f"{name} has no key {old}"
    file = folder / name
    file.write_text(text, encoding="utf-8")
    return file


def command(*arguments: str | Path) -> list[str]:
    return [sys.executable, "-m", "grainfit", *map(str, arguments)]


def calibrate(
    folder: Path, file: Path, *options: str
) -> tuple[subprocess.CompletedProcess[str], dict[str, Any]]:
    done = subprocess.run(
        command("run", file, "--workdir", folder / "work", *options),
        capture_output=True,
        text=True,
        check=False,
    )
    return done, json.loads((folder / "work" / "result.json").read_text())


@pytest.mark.thorough
def test_glass_beads_are_calibrated_with_few_runs(tmp_path: Path) -> None:
    # One run at a time: with more, what is asked depends on which run comes back first.
    file = example(tmp_path, "calibration.toml")
    done, result = calibrate(tmp_path, file, "--workers", "1")
    assert done.returncode == 0, done.stdout + done.stderr
    assert result["status"] == "calibrated"
    runs = result["runs"]
    assert runs["design"] == 5
    # One seed's figure: about half of all calibrations take 16 runs at most, nine of ten 22.
    assert runs["design"] + runs["optimisation"] <= 22
    assert runs["failed"] == 0
    assert result["probability_all_met"] >= 0.95
    # The study's own calibration by hand ended near 2310 kg/m^3.
    assert result["parameters"]["particle.density"] == pytest.approx(2310, rel=0.01)
    # Five seeds leave a standard error of 0.36 degrees, 1.6 %.
    for name, tolerance in (("bulk_density", 0.8), ("angle_of_repose", 2.3)):
        assert abs(result["responses"][name]["deviation_percent"]) <= tolerance
    folders = [path for path in (tmp_path / "work" / "runs").iterdir() if path.is_dir()]
    assert len(folders) == runs["total"]
    assert all((path / "heap.png").stat().st_size > 1000 for path in folders)
    if chromium.EXECUTABLE:
        assert violations_in(tmp_path / "work" / "report.html") == []


@needs_liggghts
@pytest.mark.thorough
def test_the_density_of_beads_in_a_packing_is_calibrated_on_liggghts(tmp_path: Path) -> None:
    # A narrower container takes half the time; its wall loosens the bed by a percent.
    small = '"liggghts"\\ncylinder_radius = "45 mm"'
    file = example(tmp_path, "calibration.toml", type='"packing"', solver=small)
    text = file.read_text().replace("{ min = 0.449, max = 0.891 }", "0.67")
    heap_only = ("targets.angle", "plate_")
    file.write_text("".join(x for x in text.splitlines(True) if not x.startswith(heap_only)))
    done, result = calibrate(tmp_path, file, "--workers", "1")
    assert done.returncode == 0, done.stdout + done.stderr
    assert result["status"] == "calibrated"
    # The packing test is the filling of a heap, and agrees with that within half a percent.
    assert result["parameters"]["particle.density"] == pytest.approx(2310, rel=0.02)


@pytest.mark.thorough
def test_a_narrow_interval_is_recognised_as_out_of_reach(tmp_path: Path) -> None:
    # A narrower cylinder takes half the time; its wall loosens the bed by a percent.
    small = '"lammps"\\ncylinder_radius = "45 mm"'
    file = example(tmp_path, "narrow_interval.toml", solver=small)
    file.write_text(file.read_text() + "\n[strategy]\nverification_runs = 3\n")
    done, result = calibrate(tmp_path, file, "--workers", "2")
    assert done.returncode == 3, done.stdout + done.stderr
    assert result["status"] == "unreachable"
    assert result["runs"]["design"] + result["runs"]["optimisation"] <= 8
    # An idle worker would halve it.
    assert result["utilisation"] > 0.75
    [miss] = result["out_of_reach"]
    assert (miss["target"], miss["parameter"], miss["bound"]) == (
        "bulk_density",
        "particle.density",
        "max",
    )
    assert miss["suggestion"] == pytest.approx(2360, abs=40)
    assert result["responses"]["bulk_density"]["deviation_percent"] == pytest.approx(-5.7, abs=1)
    # Lines are wrapped to the width of the terminal.
    assert "particle.density.max = 2205" in " ".join(done.stdout.split())


@pytest.mark.thorough
def test_kill_dash_nine_in_mid_run_loses_no_finished_simulation(tmp_path: Path) -> None:
    file = example(tmp_path, "calibration.toml")
    text = file.read_text() + "\n[strategy]\ndesign_runs = 5\nmax_runs = 8\nverification_runs = 2\n"
    # A small heap: this is about runs, not about heaps.
    small = 'solver = "lammps"\ncylinder_radius = "40 mm"'
    file.write_text(text.replace('solver = "lammps"', small))
    runs = tmp_path / "work" / "runs"
    process = subprocess.Popen(
        command("run", file, "--workdir", tmp_path / "work", "--workers", "2"),
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    )
    while not [path for path in runs.glob("*") if path.suffix != ".partial"]:
        assert process.poll() is None
        time.sleep(0.05)
    os.kill(process.pid, signal.SIGKILL)
    process.wait()
    finished = {path.name for path in runs.glob("*") if path.suffix != ".partial"}
    done, result = calibrate(tmp_path, file, "--workers", "2")
    assert result["runs"]["reused"] == len(finished), done.stdout + done.stderr
    folders = {path.name for path in runs.iterdir()}
    assert len(folders) == result["runs"]["total"], "nothing is left of the runs that were killed"
    assert finished <= folders
