"""The Python interface as README and documentation show it."""

from __future__ import annotations

import json
import pickle
from pathlib import Path

import pandas as pd
import plotly.graph_objects as go
import pytest

import grainfit as gf
from grainfit.errors import Fault, InputError, RunFailedError
from grainfit.testing.materials import GLASS_BEADS, ROUGH_PLATE

FILE = """\
name = "my sand"
[parameters]
friction = { min = 0.1, max = 0.9 }
[[test]]
type = "python"
function = "model.py:simulate"
targets.angle = { value = 30.0, tolerance = 0.5 }
"""
MODEL = """\
def simulate(parameters, seed):
    return {"angle": 10 + 40 * parameters["friction"] + 0.2 * ((seed % 1009) / 1009 - 0.5)}
"""


@pytest.fixture
def beads(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    (tmp_path / "model.py").write_text(MODEL)
    (tmp_path / "beads.toml").write_text(FILE)
    monkeypatch.chdir(tmp_path)
    return tmp_path


def test_a_file_is_loaded_calibrated_and_opened(beads: Path) -> None:
    result = gf.load("beads.toml").calibrate(progress=True)

    assert result.status == "calibrated"
    saved = gf.open("beads.grainfit")
    assert saved.result == result
    assert len(saved.evaluations) == len(result.history)
    runs = saved.runs()
    assert isinstance(runs, pd.DataFrame)
    assert len(runs) == result.runs.total
    assert {"friction", "angle", "seed"} <= set(runs.columns)
    assert saved.analyse().posterior is not None
    written = saved.card().write("json", beads / "card.json")
    assert json.loads(written.read_text())["name"] == "my sand"
    for draw in (gf.plots.convergence, gf.plots.posterior, gf.plots.predicted):
        assert isinstance(draw(saved), go.Figure)
    assert isinstance(gf.plots.sensitivity(saved), go.Figure)
    assert "friction" in str(result)
    assert "<table" in result._repr_html_()


def test_a_file_is_calibrated_as_by_the_command_line(beads: Path) -> None:
    setup = gf.load(beads / "beads.toml")
    result = setup.calibrate(beads / "here", max_runs=20, seed=3, strategy="staged", design_runs=6)

    assert (result.strategy, result.seed, result.runs.design) == ("staged", 3, 6)
    saved = gf.open(beads / "here")
    assert saved.source == "beads.toml"
    assert saved.max_runs == 20
    other = setup.calibrate(beads / "there", strategy=gf.Sequential(prefer="accuracy"), max_runs=20)
    assert other.strategy == "sequential"


def test_a_strategy_is_asked_and_told() -> None:
    problem = gf.Problem([gf.Parameter("friction", 0.1, 0.9)], [gf.Target("angle", "30 deg")])
    search = gf.Sequential().start(problem, seed=1)
    proposal = search.ask()
    assert proposal is not None
    search.tell(proposal, {"angle": 31.2})
    assert search.ask() is not None


def test_tests_and_solvers_take_quantities() -> None:
    heap = gf.tests.Heap(diameter="10 mm", lift_speed="50 mm/s", **ROUGH_PLATE)
    assert heap.lift_speed == 0.05
    material = {name: value for name, value in GLASS_BEADS.items() if name != "particle.density"}
    solver = gf.solvers.Lammps(heap, {**material, "particle.youngs_modulus": "0.36 MPa"})
    assert solver.material["particle.youngs_modulus"] == 0.36e6
    with pytest.raises(gf.InputError, match=r"particle\.youngs_modulus: .*Pa"):
        gf.solvers.Liggghts(heap, {**material, "particle.youngs_modulus": "0.36 m"})


@pytest.mark.slow
def test_a_packing_is_calibrated_from_python(tmp_path: Path) -> None:
    packing = gf.tests.Packing(diameter="10 mm", cylinder_radius="40 mm", fill_height="70 mm")
    material = {name: value for name, value in GLASS_BEADS.items() if name != "particle.density"}
    problem = gf.Problem(
        [gf.Parameter("particle.density", "2 g/cm^3", "2.6 g/cm^3")],
        [gf.Target("bulk_density", "1450 kg/m^3", tolerance="1 %")],
    )
    result = gf.calibrate(
        problem,
        gf.solvers.Lammps(packing, material),
        workdir=tmp_path / "beads",
        strategy=gf.Sequential(prefer="accuracy"),
        workers=2,
        max_runs=14,
        verification_runs=3,
    )

    assert result.status == "calibrated"
    saved = gf.open(tmp_path / "beads")
    text = saved.card().write("liggghts", tmp_path / "beads.liggghts").read_text()
    assert "property/global" in text or "variable" in text
    assert saved.report().is_file()
    assert saved.runs().attrs["units"]["bulk_density"] == "kg/m^3"


@pytest.mark.parametrize(
    "error",
    [
        InputError([Fault("x.min", "is too large"), Fault("", "y is missing")], "a.toml"),
        RunFailedError("no heap", "last line", "evaluation"),
    ],
)
def test_an_error_comes_whole_from_another_process(error: Exception) -> None:
    found = pickle.loads(pickle.dumps(error))
    assert (str(found), vars(found)) == (str(error), vars(error))
