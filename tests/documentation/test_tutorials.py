"""Files, commands and Python of the tutorials work as they stand on the pages."""

from __future__ import annotations

import contextlib
import io
import re
import shlex
import shutil
import tomllib
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from pages_of_tutorials import ROOT, marked_blocks
from typer.testing import CliRunner

import grainfit as gf
from grainfit.cli.app import app
from grainfit.report.sections.photographs.comparison import compared
from grainfit.solvers.registry import DEM_PROGRAMS
from tests.photographs.drawn_pictures import cone
from tests.photographs.rendered_pictures import Shot, save

runner = CliRunner(env={"COLUMNS": "200"})


def run_commands(text: str) -> str:
    """Run every command of a block, and return what they print."""
    printed = ""
    for line in text.splitlines():
        program, *arguments = shlex.split(line)
        assert program == "grainfit", line
        result = runner.invoke(app, arguments)
        assert result.exit_code == 0, f"{line}\n{result.output}"
        printed += result.output
    return printed


def test_the_file_of_the_first_tutorial_is_the_example_that_is_calibrated() -> None:
    (file,) = [b for b in marked_blocks("tutorials/glass_beads.md") if b.mark.startswith("file")]
    example = (ROOT / "examples" / "glass_beads" / "calibration.toml").read_text(encoding="utf-8")
    assert tomllib.loads(file.text) == tomllib.loads(example)


def test_the_first_tutorial_checks_and_draws_its_test(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    printed = ""
    for block in marked_blocks("tutorials/glass_beads.md"):
        if block.mark.startswith("file: "):
            Path(block.mark.removeprefix("file: ")).write_text(block.text, encoding="utf-8")
        else:
            printed += run_commands(block.text)

    assert (tmp_path / "beads.preview.html").is_file()
    page = (ROOT / "docs" / "tutorials" / "glass_beads.md").read_text(encoding="utf-8")
    for quoted in ("about 5,938 steps", "E/(ρ g d) = 1750"):
        assert quoted in page
        assert quoted in printed


@pytest.mark.skipif(
    shutil.which("liggghts") is None, reason="LIGGGHTS is not installed: apt-get install liggghts"
)
def test_the_file_of_the_pellets_is_written_changed_and_checked(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    new, targets, check = marked_blocks("tutorials/pellets.md")
    assert [new.mark, targets.mark, check.mark] == ["run", "targets", "run"]

    printed = run_commands(new.text)
    lines = Path("pellets.toml").read_text(encoding="utf-8").splitlines(keepends=True)
    first = next(i for i, line in enumerate(lines) if line.startswith("targets."))
    kept = [line for line in lines if not line.startswith("targets.")]
    Path("pellets.toml").write_text("".join([*kept[:first], targets.text, *kept[first:]]))
    printed += run_commands(check.text)

    assert Path("pellets.preview.html").is_file()
    page = (ROOT / "docs" / "tutorials" / "pellets.md").read_text(encoding="utf-8")
    for quoted in ("particle.density is free, 850 kg/m^3 to 1050 kg/m^3", "about 29,373 steps"):
        assert quoted in page
        assert quoted in printed


@pytest.mark.parametrize(("page", "solver"), [("lammps_deck", "lammps"), ("yade_script", "yade")])
def test_a_model_of_the_user_is_checked_and_simulated(
    page: str, solver: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    if shutil.which("yade") is None and solver == "yade":
        pytest.skip("YADE is not installed: apt-get install yade")
    assert solver in DEM_PROGRAMS
    (block,) = [b for b in marked_blocks(f"tutorials/{page}.md") if b.mark.startswith("run in")]
    folder = block.mark.removeprefix("run in: ").partition(";")[0]
    shutil.copytree(ROOT / folder, tmp_path / "model")
    monkeypatch.chdir(tmp_path / "model")

    printed = run_commands(block.text)

    # A restitution of 0.9 from 200 mm, which scatter by 2 %.
    height = float(re.findall(r"rebound_height in m +([\d.e+-]+)", printed)[-1])
    assert height == pytest.approx(0.9**2 * 0.2, rel=0.035)


def test_the_tables_of_the_pages_on_own_models_are_those_of_the_examples() -> None:
    (file,) = [b for b in marked_blocks("tutorials/lammps_deck.md") if b.mark.startswith("file")]
    example = (ROOT / "examples" / "own_model" / "calibration.toml").read_text(encoding="utf-8")
    assert tomllib.loads(file.text) == tomllib.loads(example)


def test_photographs_are_measured(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    shot = Shot(cone(25.0, 10.0, 1), elevation=6.0, distance=1.1, plate_radius=0.31)
    (tmp_path / "heap_1").mkdir()
    for azimuth in (0, 90):
        save(replace(shot, azimuth=azimuth), tmp_path / "heap_1" / f"{azimuth}.jpg", exif=True)
    save(replace(shot, azimuth=45), tmp_path / "heap_2.jpg", exif=True)
    monkeypatch.chdir(tmp_path)
    (block,) = marked_blocks("photos.md")
    names: dict[str, Any] = {}
    with contextlib.redirect_stdout(io.StringIO()) as printed:
        exec(compile(block.text, "<photos.md>", "exec", dont_inherit=True), names)

    assert names["found"].angle_of_repose.value == pytest.approx(25.0, abs=1.0)
    assert "targets.angle_of_repose" in printed.getvalue()


@pytest.mark.skipif(
    shutil.which("liggghts") is None, reason="LIGGGHTS is not installed: apt-get install liggghts"
)
def test_photographs_video_and_records_become_a_material(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    example, recorded = ROOT / "examples" / "phone", ROOT / "docs" / "recorded"
    sheet, targets, check, export = marked_blocks("tutorials/phone.md")
    page = (ROOT / "docs" / "tutorials" / "phone.md").read_text(encoding="utf-8")
    lines = (example / "calibration.toml").read_text(encoding="utf-8").splitlines()
    assert [line for line in lines if line.startswith("targets.")] == targets.text.splitlines()

    monkeypatch.chdir(Path(shutil.copytree(example, tmp_path / "phone")))
    run_commands(sheet.text)
    assert Path("sheet.pdf").read_bytes().startswith(b"%PDF")
    printed = run_commands(check.text)
    assert "pictures: 5, heaps: 1" in printed
    # What was photographed, filmed and weighed; a heap of three sides is known within 0.7 degrees.
    for pattern, truth, error in (
        (r"angle_of_repose: ([\d.]+) ±", 22.76, 1.4),
        (r"dynamic angle: ([\d.]+) ±", 42.03, 1.9),
        (r"discharge.mass_flow +([\d.]+) kg/s", 0.02345, 0.0003),
    ):
        (found,) = re.findall(pattern, printed)
        assert float(found) == pytest.approx(truth, abs=error)

    monkeypatch.chdir(Path(shutil.copytree(recorded, tmp_path / "recorded")))
    run_commands(export.text)
    assert "coefficientFriction" in Path("pellets.liggghts").read_text(encoding="utf-8")
    saved = gf.open("phone")
    assert all(f"{value:.4g}" in page for value in saved.result.parameters.values())
    intervals = saved.result.intervals
    for name, truth in (("sliding", 0.45), ("rolling", 0.2)):
        interval = intervals[f"particle_particle.{name}_friction"]
        assert interval.low <= truth <= interval.high
    # Neither originals nor runs are there.
    (shown,) = compared(saved)
    assert len(shown.gone) == len(shown.pictures) == 5
    assert all(picture.image and picture.simulated for picture in shown.pictures)
