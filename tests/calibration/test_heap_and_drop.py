"""The example of a heap and an own model in one file calibrates, with a small heap."""

from __future__ import annotations

import shutil
from collections import Counter
from pathlib import Path

import pytest

import grainfit as gf
from grainfit.calibration_file.plan import describe_plan

EXAMPLE = Path(__file__).parents[2] / "examples" / "own_model"
FRICTION, RESTITUTION = "particle_particle.sliding_friction", "particle_wall.restitution"
SMALL = 'solver = "lammps"\ncylinder_radius = "40 mm"\nstrike_off_height = "75 mm"'


def test_the_example_is_ready_and_the_drop_depends_on_the_restitution_alone() -> None:
    setup = gf.load(EXAMPLE / "heap_and_drop.toml")
    assert describe_plan(setup).problems == ()
    assert {scope.name: scope.parameters for scope in setup.problem.tests} == {
        "heap": (FRICTION, RESTITUTION),
        "drop": (RESTITUTION,),
    }


@pytest.mark.slow
def test_heap_and_own_drop_calibrate_from_one_file(tmp_path: Path) -> None:
    shutil.copytree(EXAMPLE, tmp_path / "example")
    path = tmp_path / "example" / "heap_and_drop.toml"
    text = path.read_text(encoding="utf-8")
    text = text.replace('solver = "lammps"', f'{SMALL}\nbulk_density_top = "60 mm"')
    # Soft particles take few time steps, and a wide tolerance few runs.
    text = text.replace('"1 MPa"', '"0.25 MPa"').replace('"1 deg"', '"3 deg"')
    text = text.replace('"22 deg"', '"25 deg"').replace("min = 0.05", "min = 0.2")
    text = text.replace('"2 %"', '"6 %"')
    path.write_text(text, encoding="utf-8")
    result = gf.load(path).calibrate(tmp_path / "work", workers=1, max_runs=40)
    assert result.status == "calibrated"
    # The bead rebounds to the square of its coefficient of restitution.
    assert result.parameters[RESTITUTION] == pytest.approx((0.120 / 0.200) ** 0.5, rel=0.06)
    runs = Counter(test for run in result.history for test in run.runs)
    assert runs["heap"] + runs["drop"] == result.runs.total
    # No drop was run twice at one restitution and seed, at whatever friction.
    drops = {run.runs["drop"] for run in result.history if "drop" in run.runs}
    assert len(drops) == runs["drop"]
