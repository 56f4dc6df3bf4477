"""A calibration file becomes solvers that run with what it says."""

from __future__ import annotations

from pathlib import Path

import pytest

from grainfit.calibration.calibrate import calibrate
from grainfit.calibration_file.build import CalibrationSetup, build_calibration
from grainfit.calibration_file.load import load_calibration_file
from grainfit.errors import InputError
from grainfit.evaluation import scalars
from grainfit.materials.time_step import rayleigh_time_step
from grainfit.run_definition import without_defaults
from grainfit.solvers.base import Workspace
from grainfit.solvers.parameters_for import ParametersFor
from grainfit.strategies import messages as of_strategies
from grainfit.strategies.sequential.strategy import Sequential
from grainfit.strategies.staged.strategy import Staged

EXAMPLES = Path(__file__).parents[2] / "examples"
GLASS_BEADS = (EXAMPLES / "glass_beads" / "calibration.toml").read_text(encoding="utf-8")

MODEL = """
def simulate(parameters, seed):
    return {"angle": 10 * parameters["cohesion"] + parameters["gap"], "other": 1.0}
"""

OWN = """
name = "own"

[particle]
density = 2000

[parameters]
cohesion = { min = "1 kJ/m^3", max = "3 kJ/m^3", unit = "kJ/m^3" }
gap = 4

[[test]]
type = "python"
function = "model.py:simulate"
targets.angle = { value = 24.0, tolerance = 0.1 }
"""


def assembled(folder: Path, text: str, **files: str) -> CalibrationSetup:
    for name, content in files.items():
        stem, _, suffix = name.rpartition("_")
        (folder / f"{stem}.{suffix}").write_text(content, encoding="utf-8")
    path = folder / "calibration.toml"
    path.write_text(text, encoding="utf-8")
    return build_calibration(load_calibration_file(path))


def run(setup: CalibrationSetup, test: str, folder: Path, **parameters: float) -> dict[str, float]:
    folder.mkdir()
    responses = setup.solvers[test].run(parameters, 7, Workspace(folder))
    return {name: response.value for name, response in scalars(responses).items()}


def test_the_glass_beads() -> None:
    setup = build_calibration(load_calibration_file(EXAMPLES / "glass_beads" / "calibration.toml"))
    problem = setup.problem
    assert [p.name for p in problem.parameters] == [
        "particle.density",
        "particle_particle.rolling_friction",
    ]
    assert [t.name for t in problem.targets] == ["bulk_density", "angle_of_repose"]
    values = {"particle.density": 2100.0, "particle_particle.rolling_friction": 0.67}
    assert problem.rayleigh_time_step(values) == rayleigh_time_step(0.005, 2100.0, 3.6e5, 0.22)
    [solver] = setup.solvers.values()
    assert solver.name == "lammps"
    material = solver.run_parameters(values)
    assert without_defaults(material, solver.defaults) == {**setup.file.fixed, **values}


def test_several_tests_give_their_names_to_their_responses(tmp_path: Path) -> None:
    second = GLASS_BEADS[GLASS_BEADS.index("[[test]]") :].replace(
        '"lammps"', '"liggghts"\nname = "small"\ncylinder_radius = "50 mm"\ntimeout = "1 min"'
    )
    setup = assembled(tmp_path, GLASS_BEADS + second)
    assert [target.name for target in setup.problem.targets] == [
        "heap.bulk_density",
        "heap.angle_of_repose",
        "small.bulk_density",
        "small.angle_of_repose",
    ]
    assert [solver.name for solver in setup.solvers.values()] == ["lammps", "liggghts"]
    assert setup.solvers["small"].test.setup.cylinder_radius == 0.05
    assert setup.timeouts["small"] == 60.0
    assert 600 < setup.timeouts["heap"] < 3600, "a solver that hangs is ended all the same"


def test_a_python_model_is_calibrated(tmp_path: Path) -> None:
    setup = assembled(tmp_path, OWN + "[strategy]\nseed = 3\nmax_runs = 40", model_py=MODEL)
    result = calibrate(setup.problem, setup.solvers, name=setup.name, **setup.options(workers=1))
    assert result.status == "calibrated"
    # 10 cohesion + gap = 24, in the model's own units
    assert result.parameters["cohesion"] == pytest.approx(2.0, abs=0.01)
    assert result.runs.total <= 40


def test_own_models_get_fixed_parameters_and_what_is_set(tmp_path: Path) -> None:
    setup = assembled(tmp_path, OWN, model_py=MODEL)
    assert run(setup, "python", tmp_path / "a", cohesion=1.5)["angle"] == 19.0
    values = setup.values(["gap=5", "cohesion=2500 J/m^3"])
    assert values == {"cohesion": 2.5, "gap": 5.0}
    assert run(setup, "python", tmp_path / "b", **values)["angle"] == 30.0


def test_a_command_gets_all_parameters(tmp_path: Path) -> None:
    text = OWN.replace(
        'type = "python"\nfunction = "model.py:simulate"',
        'type = "command"\nfolder = "model"\ncommand = ["python3", "run.py", "{{ cohesion }}"]',
    )
    (tmp_path / "model").mkdir()
    (tmp_path / "model" / "run.py").write_text(
        "import json, sys\n"
        "given = json.load(open('parameters.json'))\n"
        "angle = given['particle.density'] + given['gap'] + float(sys.argv[1])\n"
        "json.dump({'angle': angle}, open('responses.json', 'w'))\n",
        encoding="utf-8",
    )
    setup = assembled(tmp_path, text)
    setup.solvers["command"].check()
    assert run(setup, "command", tmp_path / "run", cohesion=1.5) == {"angle": 2005.5}


def test_a_table_is_looked_up_by_the_free_parameters(tmp_path: Path) -> None:
    text = OWN.replace(
        'type = "python"\nfunction = "model.py:simulate"', 'type = "table"\nfile = "runs.csv"'
    )
    setup = assembled(tmp_path, text, runs_csv="cohesion,angle\n1,14\n2,24\n")
    assert run(setup, "table", tmp_path / "run", cohesion=2.0) == {"angle": 24.0}


def test_own_parameters_do_not_reach_the_heap(tmp_path: Path) -> None:
    own = OWN[OWN.index("[[test]]") :]
    text = GLASS_BEADS.replace("[wall]", "[parameters]\ncohesion = { min = 1, max = 3 }\n[wall]")
    setup = assembled(tmp_path, text + own, model_py=MODEL)
    values = setup.problem.from_unit([0.5] * 3)
    solver = setup.solvers["heap"]
    assert isinstance(solver, ParametersFor)
    assert set(solver._taken(values)) == {"particle.density", "particle_particle.rolling_friction"}


def test_faults_of_a_solver_say_of_which_test(tmp_path: Path) -> None:
    text = OWN.replace(
        'type = "python"\nfunction = "model.py:simulate"', 'type = "table"\nfile = "runs.csv"'
    )
    with pytest.raises(InputError) as caught:
        assembled(tmp_path, text, runs_csv="cohesion,angel\n1,14\n")
    [fault] = caught.value.faults
    assert fault.key == "test[0]"
    assert "runs.csv" in str(fault)
    assert "angle" in str(fault)


def test_what_is_set_must_be_possible() -> None:
    setup = build_calibration(load_calibration_file(EXAMPLES / "glass_beads" / "calibration.toml"))
    values = setup.values([])
    assert values["particle.density"] == pytest.approx(2100)
    values = setup.values(["particle.density=2.3 g/cm^3", "particle_wall.restitution = 0.5"])
    assert values["particle.density"] == 2300
    assert values["particle_wall.restitution"] == 0.5
    with pytest.raises(InputError) as caught:
        setup.values(
            ["particle.densty=1", "particle.density", "particle.density=-1", "wall.density=1 m", ""]
        )
    assert len(caught.value.faults) == 5
    assert "particle.density" in caught.value.faults[0].remedy


def test_what_the_command_line_says_wins_over_the_file(tmp_path: Path) -> None:
    text = GLASS_BEADS + '[strategy]\nname = "staged"\nseed = 4\nworkers = 3\n'
    text += "rayleigh_weight = 0.5\n"
    setup = assembled(tmp_path, text)
    assert setup.options() == {"strategy": Staged(), "seed": 4, "workers": 3}
    assert setup.options(seed=0, max_runs=9) == {
        "strategy": Staged(),
        "seed": 0,
        "workers": 3,
        "max_runs": 9,
    }
    assert setup.problem.rayleigh_weight == 0.5


def test_options_of_the_strategy_are_given_on_the_command_line_too(tmp_path: Path) -> None:
    text = OWN + '[strategy]\nprefer = "accuracy"\ndesign_runs = 7\n'
    setup = assembled(tmp_path, text, model_py=MODEL)
    assert setup.options()["strategy"] == Sequential(design_runs=7, prefer="accuracy")
    changed = setup.options(prefer="time_step", confidence="0.99", keep="results")
    assert changed["strategy"] == Sequential(design_runs=7, confidence=0.99)
    assert changed["keep"] == "results"
    with pytest.raises(
        InputError, match=f"prefer: {of_strategies.FOREIGN_OPTION.matching(strategy='staged')}"
    ):
        setup.options("staged")
    with pytest.raises(InputError, match="strategy: 'magic' is unknown"):
        setup.options("magic")
