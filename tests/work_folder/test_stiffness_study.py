"""`grainfit stiffness` and `gf.stiffness_study`: responses at several Young's moduli."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import pytest
from typer.testing import CliRunner

import grainfit as gf
from grainfit.analysis import messages as of_analysis
from grainfit.analysis.modulus_plan import ModulusPlan, simulate_moduli
from grainfit.analysis.modulus_study import ModulusRow
from grainfit.campaign.batch import ExpectedWork
from grainfit.campaign.store.records import RunRecord
from grainfit.cli import messages as of_cli
from grainfit.cli.app import app
from grainfit.testing.materials import GLASS_BEADS
from grainfit.work_folder import messages
from grainfit.work_folder.solvers_of_runs import solver_of_run

MODEL = """\
from pathlib import Path
from typing import Any

def simulate(parameters, seed):
    modulus = parameters["particle.youngs_modulus"]
    with open("calls", "a") as calls:
        calls.write(f"{modulus} {seed}\\n")
    if modulus > 9e7:
        raise ValueError("the time step is too small")
    density = 1500 * (1 + 100 / modulus ** 0.5) * parameters["friction"]
    return {"bulk_density": density + seed % 3, "angle": 30 + 0.1 * (seed % 2)}
"""
FILE = """\
name = "my sand"
[particle]
youngs_modulus = "1 MPa"
[parameters]
friction = { min = 0.5, max = 1.5 }
[[test]]
type = "python"
function = "model.py:simulate"
targets.bulk_density = { value = 1500, tolerance = 40, unit = "kg/m^3" }
targets.angle = { value = 30, tolerance = 1 }
"""


@pytest.fixture
def sand(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    (tmp_path / "model.py").write_text(MODEL)
    (tmp_path / "sand.toml").write_text(FILE)
    monkeypatch.chdir(tmp_path)
    return tmp_path


def calls() -> list[str]:
    return Path("calls").read_text().splitlines()


def moduli(rows: tuple[ModulusRow, ...]) -> list[float]:
    return [row.modulus for row in rows]


@pytest.mark.usefixtures("sand")
def test_the_smallest_modulus_that_agrees_with_the_stiffest_is_named() -> None:
    # 150, 75, 37.5 and 18.75 above stiff particles: only the last two differ by less than 40.
    study = gf.stiffness_study("sand.toml", factors=[1, 4, 16, 64])
    assert moduli(study.rows) == pytest.approx([1e6, 4e6, 16e6, 64e6])
    assert study.smallest_sufficient is not None
    assert study.smallest_sufficient.modulus == 16e6
    assert study.difference(study.rows[0], "bulk_density")[0] == pytest.approx(131.25)
    found = study.rows[0].responses["bulk_density"]
    # Seeds 1, 2, 3 add 1, 2, 0 at every modulus.
    assert found.mean == pytest.approx(1651.0)
    assert found.standard_error == pytest.approx(1 / 3**0.5)
    text = str(study)
    assert "16 MPa is enough" in text
    assert "1651.00 ± 0.58" in text
    assert study.in_doubt == ()
    assert "<table" in study._repr_html_()


@pytest.mark.usefixtures("sand")
def test_only_the_stiffest_is_no_proof_that_it_is_stiff_enough() -> None:
    study = gf.stiffness_study("sand.toml", factors=[1, 4])
    assert study.smallest_sufficient is None
    text = str(study)
    assert of_analysis.NO_SMALLER_MODULUS.is_in(text, top="4 MPa")
    assert "bulk_density differs by 75 kg/m³ at 1 MPa, 40 kg/m³ are accepted" in text


def test_scatter_leaves_open_what_the_means_do_not_show(sand: Path) -> None:
    noisy = MODEL.replace("+ 0.1 * (seed % 2)", "+ 3 * (seed % 2) + modulus / 5e7")
    (sand / "model.py").write_text(noisy)
    # The angles at 16 and 64 MPa differ by 0.96, and scatter by 1.7: 0.96 +- 2.8.
    study = gf.stiffness_study("sand.toml", factors=[16, 64])
    assert study.smallest_sufficient is not None
    assert study.in_doubt == ("angle",)
    assert of_analysis.MODULUS_IN_DOUBT.is_in(
        str(study),
        modulus="16 MPa",
        responses="angle",
        verb="is",
        top="64 MPa",
        sure="; bulk_density is",
    )


@pytest.mark.usefixtures("sand")
def test_a_second_call_makes_only_the_runs_that_are_missing() -> None:
    works: list[ExpectedWork] = []
    gf.stiffness_study("sand.toml", factors=[1, 4], seeds=2, on_start=works.append)
    done: list[tuple[int, int]] = []
    study = gf.stiffness_study(
        "sand.toml",
        factors=[1, 4, 16],
        seeds=3,
        on_start=works.append,
        on_progress=lambda *counts: done.append(counts),
    )
    assert [(work.runs, work.known) for work in works] == [(4, 0), (5, 4)]
    assert len(calls()) == len(set(calls())) == 9
    assert done[-1] == (9, 9)
    assert len(study.rows) == 3


@pytest.mark.usefixtures("sand")
def test_failed_moduli_are_named_and_the_others_compared() -> None:
    study = gf.stiffness_study("sand.toml", factors=[16, 64, 256])
    assert study.stiffest.modulus == 64e6
    assert study.smallest_sufficient is not None
    assert study.smallest_sufficient.modulus == 16e6
    assert "step is too small" in str(study)
    with pytest.raises(gf.RunFailedError, match="step is too small"):
        gf.stiffness_study("sand.toml", factors=[256, 512])


@pytest.mark.usefixtures("sand")
def test_failed_runs_are_known_and_not_made_again() -> None:
    works: list[ExpectedWork] = []
    for _ in range(2):
        gf.stiffness_study("sand.toml", factors=[16, 256], seeds=2, on_start=works.append)
    assert [(work.runs, work.known) for work in works] == [(4, 0), (0, 4)]
    assert len(calls()) == 4


def density_only(parameters: dict[str, float], seed: int) -> dict[str, float]:
    return {"bulk_density": 1500 + 1e8 / parameters["particle.youngs_modulus"] + seed}


def test_old_runs_without_a_response_that_is_no_target_are_known(tmp_path: Path) -> None:
    old = gf.solvers.PythonCallable(density_only)
    new = gf.solvers.PythonCallable(density_only, ["bulk_density", "angle"])
    parameter = gf.Parameter("particle.youngs_modulus", 1e5, 1e8)
    targets = [gf.Target(name, 1500, tolerance=40) for name in ("bulk_density", "angle")]
    works: list[ExpectedWork] = []
    for solver, wanted in ((old, targets[:1]), (new, targets[:1]), (new, targets)):
        plan = ModulusPlan(
            {"sand": solver}, gf.Problem([parameter], wanted), {parameter.name: 1e6}, (1, 4), 2
        )
        simulate_moduli(plan, tmp_path, works.append)
    assert [(work.runs, work.known) for work in works] == [(4, 0), (0, 4), (4, 0)]


def test_a_time_below_a_second_is_not_said() -> None:
    assert str(ExpectedWork(2, 1, 0.2)) == "2 runs to make, 1 known already"
    assert str(ExpectedWork(2, 1, 90.0)) == "2 runs to make, 1 known already; about 1 min 30 s"


def test_ctrl_c_keeps_what_has_finished(sand: Path) -> None:
    def stop(done: int, _count: int) -> None:
        if done >= 3:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        gf.stiffness_study("sand.toml", workers=1, on_progress=stop)
    works: list[ExpectedWork] = []
    gf.stiffness_study("sand.toml", workers=1, on_start=works.append)
    assert works[0].known >= 3
    assert (sand / "sand.grainfit").is_dir()


def command(*arguments: str) -> Any:
    return CliRunner().invoke(app, ["stiffness", *arguments])


@pytest.mark.usefixtures("sand")
def test_the_command_says_the_work_and_prints_the_table() -> None:
    done = command("sand.toml", "--factors", "16,64", "--set", "friction=1.2", "--seeds", "2")
    assert done.exit_code == 0
    assert "4 runs to make, 0 known already" in done.stderr
    assert "bulk_density in kg/m³" in done.stdout
    # 1500 * (1 + 100 / 4000) * 1.2 + 1.5
    assert "1846.50" in done.stdout
    assert "enough" in done.stdout


@pytest.mark.usefixtures("sand")
@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["sand.toml", "--factors", "1,many"], "factors: 'many' is not a number"),
        (["sand.toml", "--factors", "0,1"], "factors: 0 is no factor"),
        (["sand.toml", "--factors", "nan,1"], "factors: nan is no factor"),
        (["sand.toml", "--factors", "4,4"], "factors: 1 given"),
        (["sand.toml", "--factors", "1,1e12"], r"particle\.youngs_modulus: 1e\+18 is outside"),
        (["sand.toml", "--set", "fiction=1"], "friction"),
        (["nowhere.toml"], r"nowhere\.toml"),
        (["."], "work folder"),
    ],
)
def test_bad_input_is_named(arguments: list[str], message: str) -> None:
    error = command(*arguments).exception
    assert isinstance(error, gf.GrainfitError)
    assert re.search(message, str(error))


def test_ctrl_c_is_answered_with_what_is_kept(sand: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def interrupted(*_arguments: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr("grainfit.work_folder.stiffness_study.simulate_moduli", interrupted)
    done = command(str(sand / "sand.toml"))
    assert done.exit_code == 130
    assert of_cli.STOPPED.is_in(done.stderr)


def test_a_material_without_a_modulus_has_no_stiffness(sand: Path) -> None:
    text = FILE.replace("[particle]\n", "").replace('youngs_modulus = "1 MPa"\n', "")
    (sand / "sand.toml").write_text(text)
    with pytest.raises(gf.InputError, match=messages.NO_MODULUS.pattern):
        gf.stiffness_study("sand.toml")


def test_springs_that_are_given_have_no_modulus_to_study(sand: Path) -> None:
    given = FILE.replace("[parameters]", "[particle_wall]\nnormal_stiffness = 900\n[parameters]")
    (sand / "sand.toml").write_text(given)
    with pytest.raises(gf.InputError, match=messages.GIVEN_STIFFNESS.pattern):
        gf.stiffness_study("sand.toml")


def test_the_answer_of_a_model_of_the_user_needs_its_file(sand: Path) -> None:
    gf.load("sand.toml").calibrate(max_runs=14)
    with pytest.raises(gf.InputError, match=messages.GIVE_FILE_AND_ANSWER.pattern):
        gf.stiffness_study(sand / "sand.grainfit")
    with pytest.raises(gf.InputError, match=messages.SET_BESIDE_ANSWER.pattern):
        gf.stiffness_study(sand / "sand.grainfit", settings=["friction=1"])


@pytest.mark.slow
def test_the_answer_of_a_calibration_is_simulated_with_stiffer_beads(tmp_path: Path) -> None:
    packing = gf.tests.Packing(diameter="10 mm", cylinder_radius="35 mm", fill_height="80 mm")
    material = {name: value for name, value in GLASS_BEADS.items() if name != "particle.density"}
    problem = gf.Problem(
        [gf.Parameter("particle.density", 2000, 2600, unit="kg/m^3")],
        [gf.Target("bulk_density", 1450.0, tolerance=15.0, unit="kg/m^3")],
    )
    folder = tmp_path / "beads"
    result = gf.calibrate(
        problem, gf.solvers.Lammps(packing, material), workdir=folder, max_runs=14, seed=1
    )
    works: list[ExpectedWork] = []
    study = gf.stiffness_study(folder, factors=[1, 8], seeds=2, on_start=works.append)
    assert study.parameters["particle.density"] == result.parameters["particle.density"]
    assert moduli(study.rows) == pytest.approx([3.6e5, 2.88e6])
    assert works[0].seconds is not None
    soft, stiff = (row.responses["bulk_density"].mean for row in study.rows)
    # Soft beads overlap: the bed of the stiff ones is about 8 % looser.
    assert 1.04 < soft / stiff < 1.14
    steps = [row.time_step for row in study.rows]
    assert steps[0] is not None
    assert steps[1] is not None
    assert steps[0] / steps[1] == pytest.approx(8**0.5)
    assert gf.open(folder).result == result


def test_tests_rebuilt_from_runs_keep_their_contact_models(tmp_path: Path) -> None:
    heap = gf.tests.Heap(diameter="10 mm")
    damping = "particle_particle.rolling_damping", "particle_wall.rolling_damping"
    material = {name: value for name, value in GLASS_BEADS.items() if name not in damping}
    solver = gf.solvers.Lammps(heap, material, contact_models=["epsd2"])
    run = RunRecord("a", "heap", "finished", solver.definition({}, seed=1))
    assert solver_of_run(run, set()).definition({}, seed=1) == run.definition
