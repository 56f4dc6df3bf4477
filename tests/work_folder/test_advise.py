"""`grainfit advise` and `saved.advise`: which test to do next."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

import grainfit as gf
from grainfit.campaign.batch import ExpectedWork
from grainfit.cli.app import app
from grainfit.testing.materials import GLASS_BEADS, ROUGH_PLATE
from grainfit.which_test import messages
from grainfit.work_folder import messages as of_work_folder

DENSITY, ROLLING = "particle.density", "particle_particle.rolling_friction"


def angle(parameters: dict[str, float], seed: int) -> dict[str, float]:
    random = np.random.default_rng(seed)
    return {"angle": 60 * parameters["friction"] + 0.1 * random.normal()}


def calibrated(folder: Path, target: float = 30.0) -> gf.OpenedCalibration:
    problem = gf.Problem(
        [gf.Parameter("friction", 0.1, 0.9), gf.Parameter("colour", 0.0, 1.0)],
        [gf.Target("angle", target, tolerance=0.5)],
    )
    gf.calibrate(problem, angle, workdir=folder, max_runs=14)
    return gf.open(folder)


@pytest.fixture(scope="module")
def own(tmp_path_factory: pytest.TempPathFactory) -> gf.OpenedCalibration:
    return calibrated(tmp_path_factory.mktemp("own"))


def test_models_of_the_user_have_no_other_tests(own: gf.OpenedCalibration) -> None:
    with pytest.raises(gf.InputError, match=of_work_folder.OWN_MODEL_NOT_IN_RUNS.pattern) as fault:
        own.advise()
    assert of_work_folder.ADVICE_FOR_BULK_TESTS.is_in(str(fault.value))


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"seeds": 0, "simulate": True}, "seeds: is 0"),
        ({"workers": 1.5, "simulate": True}, r"workers: is 1\.5"),
        ({"max_seconds": -1, "simulate": True}, "max_seconds: is -1"),
        ({"seeds": 3}, "seeds: is for"),
        ({"max_seconds": 60}, "max_seconds: is for"),
        ({"accuracies": {"angle_of_repose": "1 kg"}}, r"accuracy\.angle_of_repose"),
        ({"accuracies": {"heap.colour": 1}}, r"heap\.colour: is no response"),
    ],
)
def test_impossible_options_are_named(
    own: gf.OpenedCalibration, options: dict[str, object], message: str
) -> None:
    with pytest.raises(gf.InputError, match=message):
        own.advise(**options)


def test_nothing_is_advised_where_no_parameter_set_agrees(tmp_path: Path) -> None:
    saved = calibrated(tmp_path, target=80.0)
    assert saved.state == "unreachable"
    with pytest.raises(gf.InputError, match=re.escape(messages.NOTHING_AGREES.remedy)):
        saved.advise()


def test_too_few_runs_are_said_by_the_command(tmp_path: Path) -> None:
    problem = gf.Problem([gf.Parameter("friction", 0.1, 0.9)], [gf.Target("angle", 30.0)])

    def fails(_parameters: dict[str, float], _seed: int) -> dict[str, float]:
        raise ValueError("no heap")

    with pytest.raises(gf.RunFailedError):
        gf.calibrate(problem, fails, workdir=tmp_path)
    error = CliRunner().invoke(app, ["advise", str(tmp_path)]).exception
    assert isinstance(error, gf.InputError)
    assert re.search("Let the calibration make more runs first", str(error))


def test_the_command_has_the_workdir_that_a_folder_in_use_asks_for() -> None:
    shown = CliRunner().invoke(app, ["advise", "--help"], env={"COLUMNS": "200"}).output
    assert "--workdir" in shown


@pytest.mark.slow
@pytest.mark.thorough
def test_a_packing_is_recommended_for_the_density_that_an_angle_leaves_open(
    tmp_path: Path,
) -> None:
    heap = gf.tests.Heap(
        diameter="10 mm",
        cylinder_radius="30 mm",
        strike_off_height="80 mm",
        bulk_density_top="70 mm",
        plate_radius="100 mm",
        **ROUGH_PLATE,
    )
    material = {n: v for n, v in GLASS_BEADS.items() if n not in (DENSITY, ROLLING)}
    problem = gf.Problem(
        [gf.Parameter(DENSITY, 1500, 3000, unit="kg/m^3"), gf.Parameter(ROLLING, 0.25, 0.9)],
        [gf.Target("angle_of_repose", 21.0, tolerance=1.0, unit="deg")],
    )
    folder = tmp_path / "beads"
    solver = gf.solvers.Lammps(heap, material)
    gf.calibrate(problem, solver, workdir=folder, max_runs=9, workers=2, seed=1)
    saved = gf.open(folder)
    assert saved.intervals[DENSITY].determination == "not determined"
    works: list[ExpectedWork] = []
    at_once = saved.advise(tests=["packing", "compression"])
    assert at_once.best is not None
    assert at_once.best.name == "packing"
    assert messages.IS_FITTED.is_in(str(saved.advise(tests=["heap"])))
    options = {"tests": ["packing", "compression"], "seeds": 1, "on_start": works.append}
    found = saved.advise(simulate=True, **options)
    assert works[0].runs == 5
    assert works[0].seconds is not None
    assert found.best is not None
    assert found.best.name == "packing"
    # A bulk density measured to 1 % leaves the density about +-2 %, beside what friction changes.
    left = found.best.intervals[DENSITY]
    assert left.determination == "determined"
    assert 0.015 < (left.high - left.low) / (left.high + left.low) < 0.06
    [density] = found.best.tests[0].responses
    assert density.slopes[DENSITY] == pytest.approx(1.07, abs=0.15)
    # The particles are too soft to be compressed: said, not simulated.
    own, remark = found.remarks
    assert own.startswith("Measure bulk_density of heap as well, to 1 %: by the atlas,")
    assert remark.startswith("Not compared: compression.")
    assert "Do next: packing (poured container)." in str(found)
    # A second call makes no run, and says the same.
    done = CliRunner().invoke(
        app, ["advise", str(folder), "--simulate", "--test", "packing", "--seeds", "1", "--yes"]
    )
    assert "All runs are known already" in done.stderr
    assert "Do next: packing (poured container)." in done.stdout
    assert gf.open(folder).result == saved.result
