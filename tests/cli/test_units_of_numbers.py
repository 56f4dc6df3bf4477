"""Every number that a command shows has its unit, on a real work folder."""

from __future__ import annotations

import html
import re
from collections.abc import Iterator
from pathlib import Path

import pytest

from commands import grainfit_here
from grainfit.watch.rows import parameter_rows
from grainfit.work_folder.saved_calibration import SavedCalibration

FILE = """
name = "sand"

[particle]
diameter = "10 mm"
youngs_modulus = "1 MPa"
poissons_ratio = 0.22
density = { min = "1400 kg/m^3", max = "2800 kg/m^3" }

[wall]
youngs_modulus = "211 GPa"
poissons_ratio = 0.30
density = "7700 kg/m^3"

[particle_particle]
sliding_friction = 0.4
rolling_friction = 0.1
restitution = 0.6
rolling_damping = 0

[particle_wall]
sliding_friction = 0.3
rolling_friction = 0.005
restitution = 0.6
rolling_damping = 0

[[test]]
type = "packing"
cylinder_radius = "25 mm"
solver = "lammps"
targets.bulk_density = { value = "1200 kg/m^3", uncertainty = "10 %" }
"""
#: Units by quantity, as any of the faces writes them.
UNITS = {
    "particle.density": ("kg/m³", "kg/m^3"),
    "bulk_density": ("kg/m³", "kg/m^3"),
    "particle.youngs_modulus": ("Pa",),
    "wall.youngs_modulus": ("Pa",),
    "wall.density": ("kg/m³", "kg/m^3"),
}


@pytest.fixture(scope="module")
def place(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with a calibration on LAMMPS that has ended."""
    folder = tmp_path_factory.mktemp("units")
    (folder / "sand.toml").write_text(FILE, encoding="utf-8")
    done = shown(folder, "run", "sand.toml", "--max-runs", "8", "--verbose")
    assert "particle.density = " in done
    assert [*without_unit(done)] == []
    return folder


def shown(folder: Path, *words: str) -> str:
    done = grainfit_here(folder, *words)
    assert done.returncode in (0, 3), done.stderr
    return done.stdout + done.stderr


def without_unit(text: str) -> Iterator[str]:
    """Yield the lines with a quantity and a number, and without the quantity's unit."""
    for line in text.splitlines():
        for name, units in UNITS.items():
            stated = re.search(rf"(?<![.\w]){re.escape(name)}( in \S+)?( =)? +[-+]?\d", line)
            if stated and not any(unit in line for unit in units):
                yield line


def test_a_line_without_a_unit_is_found() -> None:
    assert [*without_unit("particle.density = 2308.8 (determined)\nbulk_density  1361  4.1")] == [
        "particle.density = 2308.8 (determined)",
        "bulk_density  1361  4.1",
    ]
    assert [*without_unit("bulk_density in kg/m³  1361")] == []


@pytest.mark.parametrize(
    ("words", "quantity"),
    [
        (("check", "sand.toml"), "particle.density"),
        (("status", "sand.grainfit"), "particle.density = "),
        (("result", "sand.grainfit"), "particle.density "),
        (("simulate", "sand.toml"), "bulk_density "),
        (("simulate", "sand.toml", "--repeat", "2"), "bulk_density "),
        (("analyse", "sand.toml", "--runs", "sand.grainfit"), "particle.density "),
    ],
)
def test_every_number_has_its_unit(place: Path, words: tuple[str, ...], quantity: str) -> None:
    text = shown(place, *words)
    assert quantity in text
    assert [*without_unit(text)] == []


def test_a_run_is_shown_with_units_and_no_more_digits_than_it_deserves(place: Path) -> None:
    [folder, *_] = (place / "sand.grainfit" / "runs").iterdir()
    text = shown(place, "runs", "show", "sand.grainfit", folder.name)
    values = text.partition("definition, ")[0]
    assert "particle.youngs_modulus = 1·10⁶ Pa" in values
    assert [*without_unit(values)] == []
    assert not re.search(r"\d\.\d{7}", values)
    assert "in SI units:" in text
    measured = shown(place, "measure", str(folder))
    assert "bulk_density in kg/m³" in measured


def test_columns_of_runs_have_their_units(place: Path) -> None:
    listed = shown(place, "runs", "list", "sand.grainfit")
    assert listed.count("in kg/m³") == 2
    shown(place, "runs", "export", "sand.grainfit", "runs.csv", "--force")
    head, *runs = (place / "runs.csv").read_text(encoding="utf-8").splitlines()
    for name, (*_, unit) in UNITS.items():
        assert f"{name} [{unit}]" in head.split(",")
    # What was exported is read again.
    assert f"{len(runs)} runs" in shown(place, "analyse", "sand.toml", "--runs", "runs.csv")


def test_pages_have_units(place: Path) -> None:
    shown(place, "preview", "sand.toml", "--output", "preview.html")
    shown(place, "simulate", "sand.toml", "--animate", "--frames", "5")
    [animation] = place.rglob("animation.html")
    for page in (place / "preview.html", animation):
        text = html.unescape(page.read_text(encoding="utf-8"))
        assert "particle.density = 2100 kg/m³" in text
    saved = SavedCalibration.open(place / "sand.grainfit")
    assert {row["unit"] for row in parameter_rows(saved, saved.result)} == {"kg/m³"}
