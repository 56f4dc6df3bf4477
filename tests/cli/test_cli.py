"""The command line as a person uses it: exit codes, messages, files."""

import json
import os
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path
from unittest.mock import Mock

import pytest
from PIL import Image
from typer.main import get_command
from typer.testing import CliRunner

from grainfit import Parameter, Problem, Progress, Target, calibrate, design, estimate
from grainfit.calibration_file import messages as of_calibration_file
from grainfit.calibration_file.build import load_calibration
from grainfit.calibration_file.plan import describe_plan
from grainfit.calibration_file.starter import starter_file
from grainfit.campaign import messages as of_campaign
from grainfit.campaign.folder_lock import hold
from grainfit.campaign.store.store import RunStore
from grainfit.cli import messages as cli_messages
from grainfit.cli.app import app
from grainfit.cli.options import require_free
from grainfit.errors import StoreError
from grainfit.ground_messages import CANNOT_BE_WRITTEN
from grainfit.materials import messages as of_materials
from grainfit.photographs.overlay import overlay_places, write_page
from grainfit.report import verdict_messages as messages
from grainfit.verdict import messages as of_verdict
from grainfit.work_folder.status import read_status
from tests.commands import grainfit_here

GLASS_BEADS = Path(__file__).parents[2] / "examples" / "glass_beads" / "calibration.toml"
THREE_TESTS = Path(__file__).parents[2] / "examples" / "three_tests" / "calibration.toml"
MODEL = """
import random
import time

def drum(parameters, seed):
    time.sleep(PAUSE)
    if parameters["friction"] > BREAKS:
        raise ValueError("the drum broke")
    noise = random.Random(seed).gauss(0, 0.3)
    return {"angle": 20 + 40 * parameters["friction"] + noise}
"""

FILE = """
name = "../sand 'n' [gravel]"

[parameters]
friction = {{ min = 0.1, max = {high} }}

[[test]]
type = "python"
function = "model.py:drum"
targets.angle = {{ value = 36, uncertainty = 0.4 }}
"""


def calibration(folder: Path, high: float = 0.9, pause: float = 0.0, breaks: float = 9.0) -> Path:
    folder.mkdir(exist_ok=True)
    text = MODEL.replace("PAUSE", str(pause)).replace("BREAKS", str(breaks))
    (folder / "model.py").write_text(text)
    file = folder / "my sand.toml"
    file.write_text(FILE.format(high=high))
    return file


def command(*arguments: str | Path) -> list[str]:
    return [sys.executable, "-m", "grainfit", *map(str, arguments)]


def grainfit(
    *arguments: str | Path, folder: Path, code: int = 0
) -> subprocess.CompletedProcess[str]:
    return checked(grainfit_here(folder, *arguments), code)


def checked(
    done: subprocess.CompletedProcess[str], code: int = 0
) -> subprocess.CompletedProcess[str]:
    assert "\nTraceback" not in f"\n{done.stdout}\n{done.stderr}"
    assert done.returncode == code, done.stdout + done.stderr
    return done


def in_own_process(
    *arguments: str | Path, folder: Path, code: int = 0
) -> subprocess.CompletedProcess[str]:
    done = subprocess.run(
        command(*arguments), cwd=folder, capture_output=True, text=True, timeout=120, check=False
    )
    return checked(done, code)


def test_run_calibrates_and_leaves_its_result_where_it_says(tmp_path: Path) -> None:
    file = calibration(tmp_path)
    done = in_own_process("run", file, "--seed", "4", folder=tmp_path)
    assert "calibrated" in done.stdout
    assert "sand 'n' [gravel]" in done.stdout
    assert "design" in done.stderr, "progress is shown without a terminal too"
    result = json.loads((tmp_path / "my sand.grainfit" / "result.json").read_text())
    assert result["status"] == "calibrated"
    assert result["parameters"]["friction"] == pytest.approx(0.4, abs=0.02)
    assert done.stdout.splitlines()[-1] == "Report: my sand.grainfit/report.html"
    assert "Calibrated" in (tmp_path / "my sand.grainfit" / "report.html").read_text()
    again = grainfit("run", file, "--seed", "4", "--no-report", folder=tmp_path)
    assert f"{result['runs']['total']} reused" in again.stdout
    shown = grainfit("status", "my sand.grainfit", folder=tmp_path)
    assert "calibrated" in shown.stdout
    assert "friction" in shown.stdout


def test_a_report_that_cannot_be_written_costs_no_result(tmp_path: Path) -> None:
    file = calibration(tmp_path)
    (tmp_path / "work" / "report.html").mkdir(parents=True)
    done = grainfit("run", file, "--workdir", "work", folder=tmp_path)
    assert cli_messages.NO_REPORT.is_in(done.stderr)
    assert "work/report.html" in done.stderr
    assert json.loads((tmp_path / "work" / "result.json").read_text())["status"] == "calibrated"
    elsewhere = grainfit("report", "work", "--output", "sand.html", folder=tmp_path)
    assert elsewhere.stdout == "Report: sand.html\n"
    assert "Calibrated" in (tmp_path / "sand.html").read_text()
    assert elsewhere.stderr == ""
    (tmp_path / "work" / "result.json").write_text("{")
    damaged = grainfit("report", "work", "--output", "again.html", folder=tmp_path)
    assert "is damaged" in damaged.stderr


def test_out_of_reach_exits_with_three_and_names_the_bound(tmp_path: Path) -> None:
    done = in_own_process(
        "run", calibration(tmp_path, high=0.3), "--no-report", folder=tmp_path, code=3
    )
    assert "friction.max = 0.3" in done.stdout
    assert "out of reach" in done.stdout


def test_undecided_exits_with_three_and_says_what_would_help(tmp_path: Path) -> None:
    file = calibration(tmp_path)
    (tmp_path / "model.py").write_text(
        MODEL.replace("PAUSE", "0").replace("0.3)", "3.0)").replace("BREAKS", "9")
    )
    done = grainfit("run", file, "--max-runs", "16", folder=tmp_path, code=3)
    shown = " ".join(done.stdout.split())
    assert "undecided: the runs" in shown
    assert of_verdict.RUNS_NEEDED.is_in(shown)
    assert "answer: one run scatters" in shown
    assert "in doubt" in shown
    result = json.loads((tmp_path / "my sand.grainfit" / "result.json").read_text())
    assert result["status"] == "undecided"
    assert result["responses"]["angle"]["verdict"] == "in doubt"
    assert 0.05 < result["responses"]["angle"]["probability"] < 0.95
    status = grainfit("status", "my sand.grainfit", folder=tmp_path)
    assert "undecided" in status.stdout
    card = grainfit("export", "my sand.grainfit", "--to", "json", folder=tmp_path)
    assert json.loads(card.stdout)["status"] == "undecided"
    dash = grainfit("export", "my sand.grainfit", "--to", "json", "-o", "-", folder=tmp_path)
    assert dash.stdout == card.stdout
    assert not (tmp_path / "-").exists()
    assert "Undecided" in (tmp_path / "my sand.grainfit" / "report.html").read_text()


def test_runs_that_all_fail_exit_with_one_and_the_reason(tmp_path: Path) -> None:
    done = in_own_process("run", calibration(tmp_path, breaks=0.0), folder=tmp_path, code=1)
    assert "the drum broke" in done.stderr
    assert done.stdout == "Report: my sand.grainfit/report.html\n"
    page = (tmp_path / "my sand.grainfit" / "report.html").read_text()
    assert messages.STOPPED() in page
    assert "the drum broke" in page
    assert "the drum broke" in grainfit("status", "my sand.grainfit", folder=tmp_path).stdout


def test_budget_and_strategy_can_be_given_on_the_command_line(tmp_path: Path) -> None:
    file = calibration(tmp_path)
    options = ("--max-runs", "12", "--workdir", "here", "--no-report")
    grainfit("run", file, *options, folder=tmp_path)
    result = json.loads((tmp_path / "here" / "result.json").read_text())
    assert result["runs"]["total"] <= 12
    done = grainfit("run", file, "--strategy", "magic", folder=tmp_path, code=1)
    assert "magic" in done.stderr


def runs_made(folder: Path) -> int:
    try:
        return sum(read_status(folder).finished.values())
    except StoreError:
        # It is not there yet, or not complete.
        return 0


@pytest.mark.usefixtures("ctrl_c")
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_ctrl_c_exits_with_130_and_the_next_start_goes_on(
    tmp_path: Path, number: signal.Signals
) -> None:
    file = calibration(tmp_path, pause=0.15)
    process = subprocess.Popen(
        command("run", file, "--workers", "1"),
        cwd=tmp_path,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    deadline = time.monotonic() + 60
    while runs_made(tmp_path / "my sand.grainfit") < 2 and time.monotonic() < deadline:
        time.sleep(0.05)
    process.send_signal(number)
    out, error = process.communicate(timeout=60)
    assert process.returncode == 130
    assert "Traceback" not in out + error
    assert "interrupted" in out
    assert out.splitlines()[-1] == "Report: my sand.grainfit/report.html"
    shown = grainfit("status", "my sand.grainfit", folder=tmp_path)
    assert "interrupted" in shown.stdout
    done = grainfit("run", file, "--workers", "1", "--no-report", folder=tmp_path)
    assert ", 0 reused" not in done.stdout


def test_a_work_folder_in_use_is_refused_and_shown_as_running(tmp_path: Path) -> None:
    file = calibration(tmp_path)
    grainfit("simulate", file, "--workdir", "my sand.grainfit", folder=tmp_path)
    with hold(tmp_path / "my sand.grainfit"):
        busy = in_own_process("run", file, folder=tmp_path, code=1)
        shown = in_own_process("status", "my sand.grainfit", folder=tmp_path)
    assert of_campaign.FOLDER_IN_USE.is_in(busy.stderr, process=os.getpid())
    assert "running" in shown.stdout


def test_new_writes_a_file_that_check_understands(tmp_path: Path) -> None:
    grainfit("new", "beads.toml", folder=tmp_path)
    # Whether its solver is installed is another matter than whether the file is right.
    done = grainfit_here(tmp_path, "check", "beads.toml")
    assert "free parameter" in done.stdout
    refused = grainfit("new", "beads.toml", folder=tmp_path, code=1)
    assert cli_messages.EXISTS.is_in(refused.stderr)
    grainfit("new", "two.toml", "--test", "heap", "--test", "heap", folder=tmp_path)
    assert (tmp_path / "two.toml").read_text().count("[[test]]\n") == 2
    refused = grainfit("new", "three.toml", "--test", "no such", folder=tmp_path, code=1)
    assert of_calibration_file.NO_BULK_TEST.is_in(refused.stderr, name="no such")
    assert "Use one of" in refused.stderr.replace("\n", " ")
    assert not (tmp_path / "three.toml").exists()
    grainfit("new", "wheat.toml", "--material", "wheat", "--test", "drum", folder=tmp_path)
    written = (tmp_path / "wheat.toml").read_text()
    assert "STARTING VALUES for wheat" in written
    assert 'type = "drum"' in written
    refused = grainfit("new", "four.toml", "--material", "wood", folder=tmp_path, code=1)
    assert of_materials.NEAR_MATERIALS.is_in(refused.stderr.replace("\n", " "))
    assert not (tmp_path / "four.toml").exists()


def test_simulate_makes_one_run_at_the_values_that_are_set(tmp_path: Path) -> None:
    file = calibration(tmp_path)
    done = grainfit("simulate", file, "--set", "friction=0.5", "--seed", "3", folder=tmp_path)
    assert "angle" in done.stdout
    assert "outside" not in done.stderr
    failed = grainfit(
        "simulate",
        calibration(tmp_path, breaks=0.2),
        "--set",
        "friction=0.5",
        folder=tmp_path,
        code=1,
    )
    assert "the drum broke" in failed.stdout


def test_simulate_notes_a_value_outside_of_its_interval(tmp_path: Path) -> None:
    file = calibration(tmp_path)
    done = grainfit("simulate", file, "--set", "friction=1.5", folder=tmp_path)
    note = "Note: friction = 1.5 is outside of its interval, 0.1 to 0.9."
    assert note in " ".join(done.stderr.split())
    assert "angle" in done.stdout


@pytest.mark.parametrize(
    ("arguments", "word"),
    [
        (["run", "my sand.toml", "--max-runs", "many"], "max-runs"),
        (["frobnicate"], "frobnicate"),
        (["run"], "FILE"),
        (["status", "--frobnicate", "."], "frobnicate"),
        (["status", "-q", "-v", "."], "exclude each other"),
    ],
)
def test_wrong_usage_exits_with_two(tmp_path: Path, arguments: list[str], word: str) -> None:
    calibration(tmp_path)
    done = grainfit(*arguments, folder=tmp_path, code=2)
    assert word in done.stderr
    assert done.stdout == ""


@pytest.mark.parametrize(
    ("arguments", "word"),
    [
        (["run", "missing.toml"], "missing.toml"),
        (["run", "my sand.toml", "--max-runs", "3"], "max_runs"),
        (["run", "my sand.toml", "--workdir", "model.py"], "model.py"),
        (["status", "nowhere"], "nowhere"),
        (["report", "nowhere"], "nowhere"),
        (["measure", "nowhere"], "nowhere"),
        (["measure", "model.py"], "model.py"),
        (["measure", "."], "run folder"),
        (["simulate", "my sand.toml", "--set", "fiction=0.5"], "friction"),
        (["simulate", "my sand.toml", "--set", "friction"], "friction"),
        (["new", "no/such/folder/x.toml"], "cannot be written"),
    ],
)
def test_what_cannot_be_done_is_said_in_one_message(
    tmp_path: Path, arguments: list[str], word: str
) -> None:
    calibration(tmp_path)
    done = grainfit(*arguments, folder=tmp_path, code=1)
    assert word in done.stderr


def test_help_and_status_do_not_wait_for_libraries_that_they_do_not_need(tmp_path: Path) -> None:
    (tmp_path / "work").mkdir()
    RunStore.in_folder(tmp_path / "work").close()
    program = (
        "import sys\n"
        "from grainfit.cli.app import app\n"
        "app(sys.argv[1:], standalone_mode=False)\n"
        "print(*sorted({name.partition('.')[0] for name in sys.modules}))"
    )
    slow = {"jinja2", "numpy", "pandas", "pint", "PIL", "plotly", "psutil", "scipy"}
    reading = (["status", "work"], ["runs", "list", "work"])
    for arguments in (["--help"], ["runs", "--help"], *reading):
        done = subprocess.run(
            [sys.executable, "-c", program, *arguments],
            cwd=tmp_path,
            capture_output=True,
            text=True,
            check=True,
        )
        modules = set(done.stdout.splitlines()[-1].split())
        assert "grainfit" in modules
        assert not slow & modules
        assert ("sqlalchemy" in modules) == ("work" in arguments)


def test_check_loads_no_library_that_it_does_not_need(tmp_path: Path) -> None:
    shutil.copy(GLASS_BEADS, tmp_path)
    program = (
        "import sys\n"
        "from grainfit.cli.app import app\n"
        "app(['check', 'calibration.toml'], standalone_mode=False)\n"
        "print(*sys.modules)"
    )
    done = subprocess.run(
        [sys.executable, "-c", program], cwd=tmp_path, capture_output=True, text=True, check=True
    )
    modules = set(done.stdout.splitlines()[-1].split())
    assert "grainfit.calibration_file.plan" in modules
    slow = {"emcee", "pandas", "pint", "plotly", "sqlalchemy"}
    assert not (slow | {"scipy.optimize", "scipy.stats"}) & modules


@pytest.mark.parametrize(
    "answer",
    [
        lambda: describe_plan(load_calibration(GLASS_BEADS)).notes,
        lambda: estimate(THREE_TESTS),
        lambda: design(GLASS_BEADS),
    ],
    ids=["check", "estimate", "design"],
)
def test_threads_of_linear_algebra_are_limited_once(
    answer: Callable[[], object], thread_limits: Mock
) -> None:
    assert answer()
    thread_limits.assert_called_once()


def test_everything_public_is_there_when_it_is_first_used() -> None:
    program = (
        "import grainfit, grainfit.calibration.calibrate, inspect\n"
        "missing = set(grainfit.__all__) - set(dir(grainfit))\n"
        "assert not missing, missing\n"
        "assert inspect.isfunction(grainfit.calibrate)\n"
        "from grainfit import *\n"
        "assert calibrate is grainfit.calibration.calibrate.calibrate\n"
        "assert StoreError is grainfit.errors.StoreError\n"
        "assert not hasattr(grainfit, 'calibrat')\n"
    )
    subprocess.run([sys.executable, "-c", program], check=True)


@pytest.mark.parametrize(
    "arguments",
    [
        ["estimate", "--diameter", "3mm", "--density", "900", "--angle", "30deg", "-o"],
        ["atlas", "--output"],
        ["size", "heap.toml", "-o"],
        ["ask"],
    ],
    ids=["estimate", "atlas", "size", "ask"],
)
@pytest.mark.parametrize("place", ["no folder/it.png", "."])
def test_a_place_that_cannot_be_written_is_named_before_anything_is_done(
    tmp_path: Path, arguments: list[str], place: str
) -> None:
    done = grainfit(*arguments, place, folder=tmp_path, code=1)

    assert CANNOT_BE_WRITTEN.is_in(done.stderr, path=place)
    assert "Traceback" not in done.stderr
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    ("arguments", "name", "kind"),
    [
        (["compare", "one", "other", "-o"], "mine.toml", ".html"),
        (["atlas", "-o"], "atlas.pdf", ".html"),
        (["size", "heap.toml", "-o"], "study.html", ".png"),
        (["report", "work", "-o"], "sand.pdf", ".html"),
        (["report", "work", "--sheet", "-o"], "sand.html", ".pdf"),
        (["ask", "mine.toml", "--sheet"], "mine.toml", ".pdf"),
    ],
    ids=["compare", "atlas", "size", "report", "sheet", "ask"],
)
def test_a_file_is_not_written_with_the_ending_of_another_kind(
    tmp_path: Path, arguments: list[str], name: str, kind: str
) -> None:
    mine = tmp_path / name
    mine.write_text("name = 'sand'", encoding="utf-8")

    done = grainfit(*arguments, name, folder=tmp_path, code=1)

    assert cli_messages.OTHER_KIND.is_in(done.stderr, kind=kind)
    assert mine.read_text(encoding="utf-8") == "name = 'sand'"


@pytest.mark.parametrize(
    ("arguments", "name"),
    [
        (["atlas", "-o"], "mine.html"),
        (["estimate", "--diameter", "3mm", "--density", "900", "--angle", "30deg", "-o"], "e.png"),
        (["size", "heap.toml", "-o"], "e.png"),
        (["preview", "heap.toml", "-o"], "e.png"),
        (["ask", "heap.toml", "--sheet"], "a.pdf"),
        (["photo", "--marker"], "a.pdf"),
        (["report", "work", "-o"], "mine.html"),
    ],
    ids=["atlas", "estimate", "size", "preview", "ask", "photo", "report"],
)
def test_a_file_of_the_user_is_replaced_when_asked_only(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, arguments: list[str], name: str
) -> None:
    monkeypatch.chdir(tmp_path)
    Path(name).write_text("mine", encoding="utf-8")
    done = CliRunner().invoke(app, [*arguments, name])

    assert cli_messages.NOT_REPLACED.is_in(str(done.exception))
    assert Path(name).read_text(encoding="utf-8") == "mine"
    if name.endswith(".png"):
        beside = CliRunner().invoke(app, ["preview", "heap.toml", "-o", "e.html"])
        assert cli_messages.NOT_REPLACED.is_in(str(beside.exception), file=name)


@pytest.mark.parametrize(
    ("arguments", "name"),
    [
        (["atlas"], "grainfit-atlas.html"),
        (["compare", "one", "other", "--open"], "compared.html"),
        (["size", "heap.toml"], "heap.size.png"),
        (["preview", "heap.toml"], "heap.preview.png"),
        (["preview", "heap.toml"], "heap.preview.html"),
        (["photo", "heap.jpg"], "overlays/heap_measured.png"),
        (["photo", "--test", "drum", "stills", "--overlays", "."], "1_refused.png"),
    ],
)
def test_a_file_of_the_user_with_a_default_name_stays(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, arguments: list[str], name: str
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("stills").mkdir()
    Path("stills/1.jpg").touch()
    Path(name).parent.mkdir(exist_ok=True)
    Path(name).write_text("mine", encoding="utf-8")
    done = CliRunner().invoke(app, arguments)

    assert cli_messages.NOT_REPLACED.is_in(str(done.exception), file=name)
    assert Path(name).read_text(encoding="utf-8") == "mine"


def test_other_files_beside_pictures_have_no_overlay_to_replace(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("stills").mkdir()
    for name in ("stills/1.jpg", "stills/notes.txt", "notes_measured.png"):
        Path(name).touch()
    done = CliRunner().invoke(app, ["photo", "--test", "slope", "stills", "--overlays", "."])
    assert not cli_messages.NOT_REPLACED.is_in(str(done.exception))


@pytest.mark.parametrize(
    "arguments",
    [
        ["atlas"],
        ["preview", "heap.toml"],
        ["estimate", "--diameter", "3mm", "--density", "900", "--angle", "30deg", "-o", "e.png"],
    ],
    ids=["atlas", "preview", "estimate"],
)
def test_a_page_or_a_picture_is_made_again(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, arguments: list[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("heap.toml").write_text(starter_file(["packing"]), encoding="utf-8")
    for _ in range(2):
        done = CliRunner().invoke(app, arguments)
        assert done.exit_code == 0, done.output


def test_an_overlay_is_made_again(tmp_path: Path) -> None:
    place, _ = overlay_places(tmp_path, Path("heap.jpg"))
    write_page(Image.new("RGB", (40, 30)), "31.0", place)

    require_free(place, force=False)


def test_commands_that_write_a_named_file_have_the_option_that_replaces_one() -> None:
    found = {
        name: {option for parameter in command.params for option in parameter.opts}
        for name, command in get_command(app).commands.items()
    }
    writing = {name for name, options in found.items() if options & {"--output", "--marker"}}

    assert {"report", "photo", "preview"} <= writing
    assert {name for name in writing if "--force" not in found[name]} == set()


@pytest.mark.parametrize("is_interrupted", [True, False])
def test_a_report_without_an_answer_says_so_in_the_terminal(
    tmp_path: Path, is_interrupted: bool
) -> None:
    def stop(progress: Progress) -> None:
        if is_interrupted and progress.done:
            raise KeyboardInterrupt

    wanted = Problem([Parameter("x", 0.1, 0.9)], [Target("angle", 30.0, tolerance=1)])
    calibrate(wanted, lambda p: {"angle": 60 * p["x"]}, workdir=tmp_path, on_progress=stop)
    with_answer = CliRunner().invoke(app, ["report", str(tmp_path)])
    (tmp_path / "result.json").unlink()
    without = CliRunner().invoke(app, ["report", str(tmp_path)])

    missing = messages.INTERRUPTED_EARLY if is_interrupted else messages.RESULT_MISSING
    assert missing.is_in(with_answer.stderr) is is_interrupted
    assert missing.is_in(without.stderr)
    assert messages.NO_ANSWER.is_in(without.stderr, state="calibrated") is not is_interrupted


def test_full_size_without_twins_is_refused(tmp_path: Path) -> None:
    calibration(tmp_path)
    done = grainfit("run", "my sand.toml", "--full-size", folder=tmp_path, code=1)
    assert cli_messages.FULL_SIZE_OF_NOTHING.is_in(done.stderr)


def test_a_crash_of_a_users_function_shows_its_stack_and_the_next_start_names_the_run(
    tmp_path: Path,
) -> None:
    model = "import ctypes\n\ndef simulate(parameters):\n    ctypes.string_at(0)\n"
    (tmp_path / "model.py").write_text(model)
    (tmp_path / "sand.toml").write_text(
        'name = "sand"\nparameters.friction = { min = 0.1, max = 0.9 }\n[[test]]\n'
        'type = "python"\nfunction = "model.py:simulate"\ntargets.angle = { value = 30, '
        "uncertainty = 0.5 }\n"
    )
    done = subprocess.run(
        command("run", "sand.toml"), cwd=tmp_path, capture_output=True, text=True, check=False
    )
    assert done.returncode == -signal.SIGSEGV
    assert 'model.py", line 4 in simulate' in done.stderr
    (tmp_path / "model.py").write_text(
        model.replace("ctypes.string_at(0)", "return {'angle': 50 * parameters['friction']}")
    )
    again = in_own_process("run", "sand.toml", "--no-report", folder=tmp_path)
    cut_off = cli_messages.CUT_OFF
    assert cut_off.is_in(again.stderr, others="")
    assert "python at friction = " in again.stderr
    third = in_own_process("run", "sand.toml", "--no-report", folder=tmp_path)
    assert not cut_off.is_in(third.stderr)
