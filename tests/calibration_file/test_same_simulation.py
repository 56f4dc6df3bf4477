"""Tests that simulate the same: those that differ in their evaluation share each simulation."""

from __future__ import annotations

from pathlib import Path

import pytest

import grainfit as gf
from grainfit.calibration_file.checks import messages
from grainfit.calibration_file.load import load_calibration_file
from grainfit.errors import InputError, RunFailedError
from grainfit.evaluation import Response
from grainfit.solvers.base import Workspace
from grainfit.solvers.own_model.command import Command

FILE = """\
name = "sand"
[parameters]
friction = {{ min = 0.1, max = 0.9 }}
[[test]]
name = "angle"
type = "command"
folder = "model"
command = ["sh", "drum.sh", "{{{{ friction }}}}"]
evaluate = "angle.py:measure"
timeout = "60 s"
targets.angle = {{ value = 20, tolerance = 0.5 }}
[[test]]
name = "flow"
type = "command"
folder = "{folder}"
command = ["sh", "{script}", "{{{{ friction }}}}"]
evaluate = {evaluate}
timeout = "90 s"
{more}
targets.{response} = {{ value = 2, tolerance = 0.05 }}
"""
GIVEN = {
    "folder": "model",
    "script": "drum.sh",
    "evaluate": '"flow.py:measure"',
    "more": "",
    "response": "flow",
}
#: It counts how often it runs.
DRUM = "echo once >> ../../simulations\necho $1 > friction\n"
MEASURE = """
def measure(folder):
    friction = float((folder / "friction").read_text())
    return {{"{name}": {value}, "{other}": {other_value}}}
"""


def measure(name: str, value: str, other: str = "friction", other_value: str = "friction") -> str:
    return MEASURE.format(name=name, value=value, other=other, other_value=other_value)


def write(place: Path, flow: str = "4 * friction", **changes: str) -> Path:
    for name in ("model", "other"):
        (place / name).mkdir()
        for script in ("drum.sh", "fast.sh"):
            (place / name / script).write_text(DRUM)
        (place / name / "angle.py").write_text(measure("angle", "40 * friction"))
        (place / name / "flow.py").write_text(measure("flow", flow))
    (place / "sand.toml").write_text(FILE.format(**{**GIVEN, **changes}))
    return place / "sand.toml"


def notes_of(file: Path) -> list[str]:
    return [note for note in gf.load(file).notes() if note.startswith("Tests ")]


def test_tests_that_differ_in_their_evaluation_share_each_simulation(tmp_path: Path) -> None:
    setup = gf.load(write(tmp_path))
    result = setup.calibrate(tmp_path / "sand.grainfit", workers=1)
    assert result.status == "calibrated"
    assert set(result.responses) == {"angle", "flow"}
    assert result.parameters["friction"] == pytest.approx(0.5, abs=0.02)
    simulations = (tmp_path / "sand.grainfit" / "simulations").read_text().split()
    assert len(simulations) == result.runs.total


def test_joined_tests_are_named_by_check_and_have_the_larger_time_out(tmp_path: Path) -> None:
    file = write(tmp_path)
    [joined] = load_calibration_file(file).tests
    assert (joined.name, joined.responses) == ("angle_and_flow", ("angle", "flow"))
    assert joined.options["timeout"] == 90.0
    [note] = notes_of(file)
    assert messages.SHARED_SIMULATION.is_in(note, tests="angle and flow")


def test_beside_another_test_joined_ones_have_one_name(tmp_path: Path) -> None:
    file = write(tmp_path, evaluate='["flow.py:measure"]')
    (tmp_path / "push.py").write_text("def push(parameters, seed):\n    return {'force': 1.0}\n")
    other = '[[test]]\ntype = "python"\nfunction = "push.py:push"\ntargets.force = { value = 1 }\n'
    file.write_text(file.read_text() + other)
    setup = gf.load(file)
    assert [target.name for target in setup.problem.targets] == [
        "angle_and_flow.angle",
        "angle_and_flow.flow",
        "python.force",
    ]


def test_a_test_that_has_the_name_of_joined_ones_keeps_it(tmp_path: Path) -> None:
    file = write(tmp_path)
    (tmp_path / "push.py").write_text("def push(parameters, seed):\n    return {'force': 1.0}\n")
    third = '[[test]]\nname = "angle_and_flow"\ntype = "python"\nfunction = "push.py:push"\n'
    file.write_text(file.read_text() + third + "targets.force = { value = 1 }\n")
    assert gf.load(file).problem.responses == ("angle.angle", "flow.flow", "angle_and_flow.force")
    [note] = notes_of(file)
    assert messages.REPEATED_SIMULATION.is_in(note)


def test_a_fault_after_joined_tests_names_the_table_of_the_file(tmp_path: Path) -> None:
    file = write(tmp_path)
    third = '[[test]]\ntype = "python"\nfunction = "push.py:push"\nparameters = ["fiction"]\n'
    (tmp_path / "push.py").write_text("def push(parameters, seed):\n    return {'force': 1.0}\n")
    file.write_text(file.read_text() + third + "targets.force = { value = 1 }\n")
    with pytest.raises(InputError, match="test 3, parameters: name 'fiction'"):
        gf.load(file)


@pytest.mark.parametrize(
    "change",
    [{"folder": "other"}, {"script": "fast.sh"}, {"more": 'parameters = ["friction"]'}],
)
def test_tests_with_another_simulation_are_left_alone(
    tmp_path: Path, change: dict[str, str]
) -> None:
    assert notes_of(write(tmp_path, **change)) == []


@pytest.mark.parametrize("change", [{"response": "angle"}, {"more": "repeats = 2"}])
def test_tests_that_cannot_be_joined_are_noted(tmp_path: Path, change: dict[str, str]) -> None:
    [note] = notes_of(write(tmp_path, **change))
    assert messages.REPEATED_SIMULATION.is_in(note, one="angle", other="flow")
    assert messages.ONE_FUNCTION.is_in(note, key="evaluate")


def test_a_list_of_functions_evaluates_a_run(tmp_path: Path) -> None:
    write(tmp_path)
    evaluate = ["angle.py:measure", "flow.py:measure"]
    command = ["sh", "drum.sh", "{{ friction }}"]
    names = ["angle", "flow"]
    solver = Command(tmp_path / "model", command, evaluate=evaluate, response_names=names)
    assert [line.split()[0].rpartition("/")[2] for line in solver.executes()[1:]] == evaluate
    workspace = Workspace(tmp_path / "a" / "b" / "run")
    workspace.folder.mkdir(parents=True)
    found = solver.run({"friction": 0.5}, 1, workspace)
    assert found == {n: Response(v) for n, v in (("angle", 20.0), ("flow", 2.0), ("friction", 0.5))}
    one = Command(tmp_path / "model", command, evaluate=evaluate[0])
    assert solver.model()["evaluate"] == [
        one.model()["evaluate"],
        Command(tmp_path / "model", command, evaluate=evaluate[1]).model()["evaluate"],
    ]


def test_functions_that_disagree_on_a_response_fail_the_run(tmp_path: Path) -> None:
    write(tmp_path)
    (tmp_path / "model" / "flow.py").write_text(measure("flow", "1.0", "angle", "7.0"))
    evaluate = ["angle.py:measure", "flow.py:measure"]
    solver = Command(tmp_path / "model", ["sh", "drum.sh", "{{ friction }}"], evaluate=evaluate)
    workspace = Workspace(tmp_path / "a" / "b" / "run")
    workspace.folder.mkdir(parents=True)
    with pytest.raises(RunFailedError, match=r"both angle.py:measure and flow.py:measure return"):
        solver.run({"friction": 0.5}, 1, workspace)


def test_a_response_that_nobody_needs_may_differ_and_is_left_out(tmp_path: Path) -> None:
    write(tmp_path)
    (tmp_path / "model" / "angle.py").write_text(measure("angle", "20.0", "mass", "1.0"))
    (tmp_path / "model" / "flow.py").write_text(measure("flow", "2.0", "mass", "7.0"))
    solver = Command(
        tmp_path / "model",
        ["sh", "drum.sh", "{{ friction }}"],
        evaluate=["angle.py:measure", "flow.py:measure"],
        response_names=["angle", "flow"],
    )
    workspace = Workspace(tmp_path / "a" / "b" / "run")
    workspace.folder.mkdir(parents=True)
    found = solver.run({"friction": 0.5}, 1, workspace)
    assert found == {"angle": Response(20.0), "flow": Response(2.0)}


def test_each_function_of_a_list_has_a_log_which_is_no_part_of_the_model(tmp_path: Path) -> None:
    write(tmp_path)
    model = tmp_path / "model"
    for name in ("angle", "flow"):
        code = f"    print('about the {name}')\n    return {{'{name}': 1.0}}\n"
        (model / f"{name}.py").write_text(f"def measure(folder):\n{code}")
    command = ["sh", "drum.sh", "{{ friction }}"]
    evaluate = ["angle.py:measure", "flow.py:measure"]
    solver = Command(model, command, evaluate=evaluate)
    folder = tmp_path / "a" / "b" / "run"
    folder.mkdir(parents=True)
    solver.run({"friction": 0.5}, 1, Workspace(folder))
    logs = {"evaluation.log": "about the angle\n", "evaluation_2.log": "about the flow\n"}
    for name, text in logs.items():
        assert (folder / name).read_text() == text
        (model / name).write_text("of a run by hand")
    assert Command(model, command, evaluate=evaluate).model() == solver.model()


def test_a_faulty_entry_of_a_list_of_functions_is_named(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"missing\.py"):
        gf.load(write(tmp_path, evaluate='["flow.py:measure", "missing.py:measure"]'))
