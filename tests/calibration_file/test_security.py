"""A calibration file from somebody else: what checking it must not do, and what it must show."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Callable
from io import StringIO
from pathlib import Path

import pytest
from rich.console import Console

from grainfit.calibration_file.build import build_calibration
from grainfit.calibration_file.load import load_calibration_file
from grainfit.calibration_file.plan import describe_plan
from grainfit.cli.console import print_error, print_plan, print_status
from grainfit.errors import GrainfitError, InputError, RunFailedError
from grainfit.options import messages
from grainfit.solvers.base import Workspace
from grainfit.solvers.own_model import model_folder
from grainfit.solvers.own_model.command import Command
from grainfit.work_folder.status import FailedRun, WorkdirStatus

MATERIAL = """
[particle]
diameter = "10 mm"
youngs_modulus = "0.36 MPa"
poissons_ratio = 0.22
density = { min = "1400 kg/m^3", max = "2800 kg/m^3" }
[wall]
youngs_modulus = "211 GPa"
poissons_ratio = 0.30
density = "7700 kg/m^3"
[particle_particle]
sliding_friction = 0.18
rolling_friction = 0.5
restitution = 0.79
rolling_damping = 0.25
[particle_wall]
sliding_friction = 0.27
rolling_friction = 0.005
restitution = 0.82
rolling_damping = 0.25
"""
HEAP = """
[[test]]
name = "{solver}"
type = "heap"
solver = "{solver}"
executable = "model/trap"
ranks = 2
targets.bulk_density = {{ value = 1500 }}
"""
OWN = """
[[test]]
name = "own"
type = "command"
folder = "model"
command = ["./trap", "{{ 9**(9**9) }}", "{{ ''.__class__.__mro__ }}", "; ./trap"]
evaluate = "trap.py:measure"
targets.angle = { value = 30, unit = "[red]°<b>" }
"""
FUNCTION = """
[[test]]
name = "function"
type = "python"
function = "model/trap.py:measure"
targets.angle = { value = 30 }
"""
NAME = "[red]\"Körner\" & 'Söhne' <script>alert(1)</script>[/red] $(./trap) `./trap` :skull: 50 %"

Trap = Callable[[], bool]


@pytest.fixture
def sprung(tmp_path: Path) -> Trap:
    """A folder in which whatever is executed leaves a trace; says whether something was."""
    trace = tmp_path / "trace"
    folder = tmp_path / "model"
    folder.mkdir()
    code = f"open({str(trace)!r}, 'w').close()\ndef measure(*arguments): return {{}}\n"
    for name in ("trap.py", "conftest.py", "sitecustomize.py"):
        (folder / name).write_text(code)
    # Modules that grainfit itself imports.
    for name in ("numpy.py", "jinja2.py", "typer.py", "gpmp.py"):
        (tmp_path / name).write_text(code)
    for name in ("trap", "mpiexec", "mpiexec.hydra", "mpiexec.openmpi", "lmp", "python3"):
        (folder / name).write_text(f"#!/bin/sh\ntouch '{trace}'\n")
        (folder / name).chmod(0o755)
    (folder / "in.deck.j2").write_text(
        "{{ 9**(9**9) }} {{ cycler.__init__.__globals__.os }}{% include '/etc/passwd' %}"
        "{{ particle.density }}"
    )
    for command in (["./trap"], [sys.executable, "trap.py"]):
        subprocess.run(command, cwd=folder, check=True)
        assert trace.exists(), "a trap that cannot spring shows nothing"
        trace.unlink()
    return trace.exists


def written(folder: Path, *parts: str, name: str = NAME) -> Path:
    path = folder / "calibration.toml"
    path.write_text("\n".join([f"name = '''{name}'''", *parts]), encoding="utf-8")
    return path


def check(path: Path) -> str:
    """What `grainfit check` shows, without its process."""
    text = StringIO()
    console = Console(file=text, width=500)
    try:
        print_plan(console, describe_plan(build_calibration(load_calibration_file(path))))
    except GrainfitError as error:
        print_error(console, error)
    return text.getvalue()


def test_check_executes_nothing_of_the_file_and_shows_what_a_run_would(
    tmp_path: Path, sprung: Trap
) -> None:
    heaps = [HEAP.format(solver=solver) for solver in ("lammps", "liggghts")]
    path = written(tmp_path, MATERIAL, *heaps, OWN, FUNCTION)
    before = sorted(tmp_path.rglob("*"))
    model = tmp_path / "model"

    done = subprocess.run(
        [sys.executable, "-m", "grainfit", "check", path.name],
        cwd=tmp_path,
        # What is looked up by name is found among the traps: no other MPI has to be installed.
        env={**os.environ, "COLUMNS": "500", "PATH": f"{model}{os.pathsep}{os.environ['PATH']}"},
        capture_output=True,
        text=True,
        timeout=60,
        check=False,
    )

    assert not sprung()
    assert done.returncode == 0, done.stdout + done.stderr
    assert sorted(tmp_path.rglob("*")) == before
    assert NAME in done.stdout
    assert "[red]°<b>" in done.stdout
    assert "\x1b" not in done.stdout
    shown = done.stdout.partition("A run will execute, with your rights and without a shell:")[2]
    for expected in (
        f"test lammps: {model}/mpiexec.hydra -n 2 {model}/trap -in in.lammps",
        f"test liggghts: {model}/mpiexec.openmpi -n 2",
        f"{model}/trap -in in.liggghts",
        "test own: ./trap '{{ 9**(9**9) }}'",
        "'; ./trap'",
        f"(in a copy of {model})",
        f"test own: {model}/trap.py:measure",
        f"test function: {model}/trap.py:measure",
    ):
        assert expected in shown


def test_check_says_whether_a_named_executable_can_be_executed(
    tmp_path: Path, sprung: Trap
) -> None:
    path = written(tmp_path, MATERIAL, HEAP.format(solver="lammps"))
    (tmp_path / "model" / "trap").chmod(0o644)
    assert "is not found" in check(path)
    (tmp_path / "model" / "trap").chmod(0o755)
    assert "lammps is found" in check(path)
    assert not sprung()


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ('"trap.py:', '"../numpy.py:', "test 1, evaluate: is '../numpy.py:measure', which is out"),
        ('"trap.py:', '"linked.py:', "which is outside the model's folder"),
        ('evaluate = "trap.py:measure"', 'responses = "../../r.json"', "outside the run's folder"),
        ('evaluate = "trap.py:measure"', 'responses = "/tmp/r.json"', "outside the run's folder"),
        ('["./trap"', '["../model/trap"', "outside the model's folder"),
        ('name = "own"', 'name = "../own"', "test 1, name: '../own' cannot be a name"),
        ("targets.angle", 'targets."../angle"', "cannot be a name"),
        ("[wall]", '[parameters]\n"../x" = 1\n[wall]', "cannot be a name"),
        (f"'''{NAME}'''", '"\\u001b[31m\\n"', "name: is '\\x1b[31m\\n'. Write one line"),
    ],
)
def test_names_never_lead_out_of_the_folder(
    tmp_path: Path, sprung: Trap, old: str, new: str, message: str
) -> None:
    path = written(tmp_path, MATERIAL, OWN)
    (tmp_path / "model" / "linked.py").symlink_to(tmp_path / "numpy.py")
    text = path.read_text(encoding="utf-8")
    assert text.count(old) == 1
    path.write_text(text.replace(old, new), encoding="utf-8")
    shown = check(path)
    assert message in shown
    assert "\x1b" not in shown
    assert not sprung()


def test_links_that_leave_the_models_folder_are_refused(tmp_path: Path, sprung: Trap) -> None:
    path = written(tmp_path, MATERIAL, OWN)
    folder = tmp_path / "model"
    (folder / "mine").symlink_to("trap.py")
    (folder / "\x1b[31m[bold]yours").symlink_to("/etc/passwd")
    (folder / "around").symlink_to("around")
    shown = check(path)
    assert r"\x1b[31m[bold]yours: is a link to /etc/passwd, which is outside" in shown
    assert "around: is a broken link" in shown
    assert "mine" not in shown
    assert "\x1b" not in shown
    with pytest.raises(InputError, match="outside"):
        Command(folder, ["true"]).definition({"passwd": 1.0}, 1)


@pytest.mark.parametrize(
    "template",
    [
        "{% include '/etc/passwd' %}",
        "{% include '../secret' %}",
        "{% include 'link' %}",
        "{{ ''.__class__.__mro__ }}",
        "{{ cycler.__init__.__globals__.os }}",
    ],
)
def test_a_template_reaches_nothing_outside_the_folder_in_a_run_either(
    tmp_path: Path, template: str
) -> None:
    (tmp_path / "secret").write_text("secret")
    folder, run = tmp_path / "model", tmp_path / "run"
    folder.mkdir()
    run.mkdir()
    (folder / ".hidden").symlink_to(tmp_path / "secret")
    (folder / "in.deck.j2").write_text(f"parameters.json {template.replace('link', '.hidden')}")
    solver = Command(folder, ["true"])
    solver.check()
    with pytest.raises(InputError, match=r"in\.deck\.j2"):
        solver.run({"x": 1.0}, 1, Workspace(run))
    assert not (run / "in.deck").exists()


def test_what_programs_and_files_say_cannot_steer_the_terminal() -> None:
    hostile = "[red]\x1b]0;title\x07\x9b31m\r\u202eevil \ud800 ü"
    shown = StringIO()
    console = Console(file=shown, width=200)
    print_error(console, RunFailedError(hostile, log_tail=hostile))
    failed = FailedRun(hostile, hostile, hostile)
    print_status(console, WorkdirStatus(hostile, "failed", {}, {}, 0, (failed,), 0, None))
    assert shown.getvalue().count("[red]") == 5
    assert all(sign.isprintable() or sign == "\n" for sign in shown.getvalue())
    assert "ü" in shown.getvalue()


@pytest.mark.parametrize(
    ("key", "message"),
    [
        (".".join("a" * 100_000) + " = 1", "key of too many parts"),
        (".".join(['"\\"."'] * 100_000) + " = 1", "key of too many parts"),
        ("[" + ".".join("a" * 100_000) + "]", "key of too many parts"),
        ("x = { " + " . ".join("a" * 100_000) + " = 1 }", "key of too many parts"),
    ],
)
def test_a_key_that_would_take_hours_is_refused(tmp_path: Path, key: str, message: str) -> None:
    path = tmp_path / "calibration.toml"
    path.write_text(f'name = "x"\n{key}\n')
    with pytest.raises(InputError, match=message) as caught:
        load_calibration_file(path)
    assert "line 2" in str(caught.value)


def test_a_folder_that_is_no_model_is_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(model_folder, "MOST_MODEL_FILES", 3)
    for number in range(4):
        (tmp_path / f"{number}").touch()
    with pytest.raises(InputError, match="more than 3 files"):
        Command(tmp_path, ["true"]).check()


def test_python_that_no_parser_can_take_is_said(tmp_path: Path) -> None:
    (tmp_path / "model.py").write_text("x = " + "-" * 200_000 + "1\ndef measure(p, s): ...\n")
    function = FUNCTION.replace("model/trap.py", "model.py")
    parameters = "[parameters]\nx = { min = 1, max = 2 }"
    assert messages.NESTED_TOO_DEEPLY.is_in(check(written(tmp_path, parameters, function)))
