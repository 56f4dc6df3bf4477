"""Runs of others are used, and runs are listed, shown, exported, imported and pruned."""

import csv
import io
import json
import random
import sys
from dataclasses import replace
from pathlib import Path

import pyarrow.parquet
import pytest
from rich.console import Console
from sand_files import MODEL
from typer.testing import CliRunner, Result

from grainfit import ground_messages
from grainfit.calibration.calibrate import calibrate
from grainfit.calibration_file.build import CalibrationSetup, build_calibration
from grainfit.calibration_file.load import load_calibration_file
from grainfit.campaign import messages
from grainfit.campaign.folder_lock import hold
from grainfit.campaign.reuse import runs_of
from grainfit.campaign.store.records import RunRecord
from grainfit.campaign.store.store import RunStore
from grainfit.campaign.work_folder import RECORD_NAME
from grainfit.cli.app import app
from grainfit.cli.runs_console import print_runs, size
from grainfit.errors import GrainfitError, InputError, SolverNotFoundError, StoreError
from grainfit.evaluation import Response
from grainfit.formatting import from_spreadsheet_text, spreadsheet_text
from grainfit.problem import Parameter, Problem, Target
from grainfit.run_definition import RunDefinition
from grainfit.solvers.base import Workspace
from grainfit.solvers.own_model.command import Command
from grainfit.solvers.own_model.python_callable import PythonCallable
from grainfit.solvers.own_model.recorded_table import RecordedTable
from grainfit.table_files.table import read_table
from grainfit.work_folder import messages as of_work_folder
from grainfit.work_folder.disk_use import disk_use
from grainfit.work_folder.prune import prune_runs
from grainfit.work_folder.run_columns import run_columns
from grainfit.work_folder.run_import import FIRST_SEED, Imported, import_runs
from grainfit.work_folder.run_selection import select_runs
from grainfit.work_folder.run_table import runs_table
from grainfit.work_folder.saved_calibration import SavedCalibration

EXAMPLES = Path(__file__).parents[2] / "examples"


FILE = """
name = "sand"

[parameters]
friction = { min = 0.1, max = 0.9 }
blades = 4

[[test]]
type = "python"
function = "model.py:drum"
targets.angle = { value = 36, uncertainty = 0.4, unit = "deg" }
"""

#: What a terminal would obey and Rich would style.
NASTY = "it \x1b[31mbroke\x1b[0m [bold]here[/bold] [/]"


@pytest.fixture
def sand(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A calibration file, in the current folder."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.delenv("GRAINFIT_STORE", raising=False)
    (tmp_path / "model.py").write_text(MODEL)
    file = tmp_path / "sand.toml"
    file.write_text(FILE)
    return file


def assembly_of(file: Path) -> CalibrationSetup:
    return build_calibration(load_calibration_file(file))


def grainfit(*arguments: str | Path, **env: str) -> Result:
    done = CliRunner().invoke(app, [*map(str, arguments)], env=env)
    if isinstance(done.exception, GrainfitError):
        raise done.exception
    assert done.exception is None or isinstance(done.exception, SystemExit), done.exception
    return done


def record(number: int, **changes: object) -> RunRecord:
    made = RunRecord(
        f"{number:032x}"[::-1],
        "drum",
        "finished",
        RunDefinition(
            {"solver": "lammps", "version": "22 Jul 2025", "test": {"type": "heap"}},
            {"particle.density": 1500.0 + 100 * number, "wall.density": 7700.0},
            number,
        ),
        {"angle_of_repose": Response(20.0 + number, 0.1)},
        seconds=float(number),
        ended=1.7e9 + number,
    )
    return replace(made, **changes)  # type: ignore[arg-type]


def failed(number: int, reason: str = NASTY) -> RunRecord:
    changes = {"status": "failed", "reason": reason, "kind": "simulation", "responses": {}}
    return record(number, **changes, log_tail=f"step 1\nERROR: {NASTY}\n")


def work(folder: Path, *records: RunRecord) -> Path:
    folder.mkdir(exist_ok=True)
    store = RunStore.in_folder(folder)
    store.save_many(records)
    store.close()
    return folder


def stored(folder: Path) -> list[RunRecord]:
    store = RunStore.read_only(folder)
    try:
        return store.runs()
    finally:
        store.close()


# --- grainfit run ---------------------------------------------------------------------------------


def test_a_calibration_says_which_runs_of_others_it_learns_from(sand: Path) -> None:
    first = grainfit("run", sand, "--no-report", "--seed", "2")
    assert "Warm start from" not in first.stderr
    assert "warm start" not in first.stdout
    made = json.loads(Path("sand.grainfit/result.json").read_text())["runs"]["total"]
    sand.write_text(FILE.replace("value = 36", "value = 38"))
    second = grainfit(
        "run", sand, "--no-report", "--workdir", "new", "--runs-from", "sand.grainfit"
    )
    place = Path("sand.grainfit/runs.sqlite").absolute()
    line = f"Warm start from {made} earlier runs: {place} ({made})."
    assert second.stderr.count(line) == 1, second.stderr
    assert f"warm start from {made} earlier runs" in " ".join(second.stdout.split())


def test_the_shared_store_can_be_named_by_the_environment(sand: Path, tmp_path: Path) -> None:
    address = f"sqlite:///{tmp_path / 'shared.sqlite'}"
    grainfit("run", sand, "--no-report", "--workdir", "one", GRAINFIT_STORE=address)
    first = {r.identity for r in stored(Path("one"))}
    grainfit("run", sand, "--no-report", "--workdir", "two", GRAINFIT_STORE=address)
    place = address.removeprefix("sqlite:///")
    assert {r.identity for r in stored(Path("two")) if r.origin == place} == first
    grainfit("runs", "export", address, "all.csv")
    made = {r.identity for folder in ("one", "two") for r in stored(Path(folder))}
    with Path("all.csv").open(newline="") as file:
        assert {line["identity"] for line in csv.DictReader(file)} == made


def test_failed_runs_are_made_again_when_that_is_asked_for_only(tmp_path: Path) -> None:
    problem = Problem([Parameter("x", 0.0, 1.0)], [Target("y", 5.0, tolerance=1.0)])
    limit = {"x": 0.8}
    tried: list[float] = []

    def simulate(parameters: dict[str, float], seed: int) -> dict[str, float]:
        tried.append(parameters["x"])
        if parameters["x"] > limit["x"]:
            raise ValueError("not there")
        return {"y": 10 * parameters["x"] + 0.01 * (seed % 7)}

    def start(retry_failed: bool = False) -> int:
        tried.clear()
        store = f"sqlite:///{tmp_path / 'shared.sqlite'}"
        options = {"workdir": tmp_path / "work", "store": store, "max_runs": 9}
        # What the function looks at is mended outside of it: it stays the same function.
        model = PythonCallable(simulate, identity="model")
        return calibrate(problem, model, **options, retry_failed=retry_failed).runs.failed

    assert start() > 0
    failures = [x for x in tried if x > 0.8]
    assert start() == len(failures)
    assert tried == [], "the same run would only fail again"
    limit["x"] = 2.0
    assert start(retry_failed=True) == 0
    assert set(failures) <= set(tried)


def test_what_stays_of_runs_is_said_in_the_file_or_on_the_command_line(sand: Path) -> None:
    assert "keep" not in assembly_of(sand).options()
    sand.write_text(FILE + '\n[strategy]\nkeep = "results"\n')
    assert assembly_of(sand).options()["keep"] == "results"
    assert assembly_of(sand).options(keep="all")["keep"] == "all"
    sand.write_text(FILE + '\n[strategy]\nkeep = "nothing"\n')
    with pytest.raises(InputError, match=r"strategy.keep: is 'nothing'"):
        load_calibration_file(sand)
    sand.write_text(FILE)
    with pytest.raises(InputError, match=r"keep: is 'nothing'. Possible here: all, results"):
        grainfit("run", sand, "--keep", "nothing")


# --- list and show --------------------------------------------------------------------------------


def test_the_list_shows_the_latest_runs_and_how_many_more_there_are(tmp_path: Path) -> None:
    folder = work(tmp_path / "work", *(record(n) for n in range(1, 300)), failed(300))
    lines = grainfit("runs", "list", folder).stdout.splitlines()
    rows = [line for line in lines if line.split() and line.split()[0][:3].isalnum()]
    assert "300 runs, 1 failed, 270 more than shown: --limit 300 shows all." in lines[-1]
    first = next(line for line in rows if "failed:" in line)
    assert first.startswith(failed(300).identity[:7])
    assert rows.index(first) + 1 == len(rows) - 30
    assert "wall.density" not in "".join(lines), "what is the same in all runs says nothing"
    shortest = grainfit("runs", "list", folder, "--sort", "seconds", "--limit", "1").stdout
    assert record(1).identity[:7] in shortest
    densest = grainfit("runs", "list", folder, "--sort", "-particle.density", "--limit", "1")
    assert failed(300).identity[:7] in densest.stdout


@pytest.mark.parametrize(
    ("conditions", "numbers"),
    [
        (["particle.density > 2 g/cm^3"], [6, 7, 8, 9]),
        (["particle.density >= 2000", "seconds<7"], [5, 6]),
        (["angle_of_repose = 0.4363323129985824 rad"], [5]),
        (["angle_of_repose.standard_error < 0.2", "seed != 3", "seconds <= 4 s"], [1, 2, 4]),
        (["particle.density < 0"], []),
    ],
)
def test_conditions_select_runs_in_any_unit(conditions: list[str], numbers: list[int]) -> None:
    runs = run_columns([*(record(n) for n in range(1, 10)), failed(10)])
    where = [*conditions, "angle_of_repose > 0"]
    assert select_runs(runs, where=where).values["identity"] == [
        record(n).identity for n in numbers
    ]


def test_runs_of_a_smaller_apparatus_are_not_those_of_the_test() -> None:
    real, other = {"type": "heap"}, {"type": "heap", "particle_count": 500}
    smaller = RunDefinition({"test": other}, {}, 2)
    runs = run_columns([record(1), record(2, definition=smaller)], laboratory={"drum": real})
    assert runs.values["test"] == ["drum", "drum (smaller)"]


def test_all_faults_of_the_conditions_are_named_at_once() -> None:
    runs = run_columns([record(1), failed(2)])
    where = [
        "__import__('os').abort()",
        "particle.densty > 3",
        "density > 3",
        "particle.density > 3 m",
        "seconds > nan",
        "angle_of_repose > 1; 2",
        "reason = x",
    ]
    with pytest.raises(InputError) as caught:
        select_runs(runs, status="bad", test="heap", where=where)
    text = str(caught.value)
    assert len(caught.value.faults) == len(where) + 2
    assert of_work_folder.NO_CONDITION.is_in(text, text="__import__('os').abort()")
    assert "Did you mean 'particle.density'?" in text
    assert "Did you mean 'particle.density' or 'wall.density'?" in text
    assert ground_messages.OTHER_UNIT.is_in(text, given="3 m", written="m")
    assert "to kg/m^3" in text
    assert "--status: is 'bad'." in text
    assert "--test: is 'heap'. There are: drum." in text


def test_a_unit_is_not_guessed_for_responses_of_own_models() -> None:
    own = record(1, definition=RunDefinition({"solver": "command"}, {"x": 1.0}, 1))
    with pytest.raises(InputError, match=of_work_folder.COMPARED_AS_IT_IS.pattern):
        select_runs(run_columns([own]), where=["angle_of_repose > 1 rad"])
    assert len(select_runs(run_columns([own]), where=["angle_of_repose > 1"]))


def shown(records: list[RunRecord], width: int) -> list[str]:
    console = Console(file=io.StringIO(), width=width)
    runs = run_columns(records)
    print_runs(console, runs, runs, 30)
    return console.file.getvalue().splitlines()  # type: ignore[attr-defined]


def test_the_list_fits_into_a_terminal_without_cutting_a_number() -> None:
    long = {f"particle_particle.rolling_friction_{n}": 1.0 for n in range(12)}

    def wide(number: int) -> RunRecord:
        values = {name: value + number for name, value in long.items()}
        definition = RunDefinition({"solver": "x"}, values, 899999990 + number)
        return record(number, definition=definition)

    *lines, note, total = shown([*(wide(n) for n in range(1, 4)), failed(4, "no")], 80)
    assert max(map(len, lines)) <= 80
    assert "…" not in "".join(lines)
    assert "899999991" in "".join(lines)
    assert "angle_of_" in "".join(lines), "a response stays in sight"
    assert note.startswith("No room for particle_particle.rolling_friction")
    assert total == "4 runs, 1 failed."


def test_runs_that_no_living_process_makes_are_interrupted(tmp_path: Path) -> None:
    folder = work(tmp_path / "work", record(1), record(2, status="running", responses={}))

    def statuses(*given: str) -> list[str]:
        listed = grainfit("runs", "list", folder, *given, "--json").stdout
        return [run["status"] for run in json.loads(listed)["runs"]]

    with hold(folder):
        assert sorted(statuses()) == ["finished", "running"]
        assert statuses("--status", "interrupted") == []
    assert sorted(statuses()) == ["finished", "interrupted"]
    assert statuses("--status", "interrupted") == ["interrupted"]
    assert statuses("--status", "running") == []
    shown = ("runs", "show", folder, record(2).identity)
    assert "status = interrupted" in grainfit(*shown).stdout
    assert json.loads(grainfit(*shown, "--json").stdout)["run"]["status"] == "interrupted"


def test_text_from_runs_is_shown_as_text(tmp_path: Path) -> None:
    definition = RunDefinition({"solver": NASTY}, {NASTY: 1.0}, 1)
    folder = work(tmp_path / NASTY.replace("/", ""), failed(1), record(2, definition=definition))
    outputs = [
        grainfit("runs", "list", folder).stdout,
        grainfit("runs", "show", folder, failed(1).identity).stdout,
        grainfit("runs", "show", folder, record(2).identity).stdout,
        grainfit("status", folder).stdout,
    ]
    assert all("\x1b" not in text for text in outputs)
    assert r"failed: it \x1b[31mbroke\x1b[0m [bold]here[/bold] [/]" in outputs[0]
    assert r"  | ERROR: it \x1b[31mbroke\x1b[0m [bold]here[/bold] [/]" in outputs[1]
    assert f"{NASTY} = 1".replace("\x1b", r"\x1b") in outputs[2]


def test_show_tells_everything_of_a_run_by_the_beginning_of_its_identity(tmp_path: Path) -> None:
    folder = work(tmp_path / "work", record(1), replace(failed(2), identity="1f" + "0" * 30))
    (folder / "runs" / record(1).identity).mkdir(parents=True)
    text = grainfit("runs", "show", folder, "10").stdout
    for part in ("particle.density = 1600 kg/m³", "angle_of_repose = 21°", "22 Jul 2025"):
        assert part in text
    assert f"folder = {folder / 'runs' / record(1).identity}" in text
    assert '"type": "heap"' in text
    assert "2023-11-14T22:13:21+00:00" in text
    with pytest.raises(
        InputError, match=of_work_folder.SEVERAL_RUNS.matching(identity="1", count=2)
    ):
        grainfit("runs", "show", folder, "1")
    with pytest.raises(InputError, match=of_work_folder.NO_RUN.matching(identity="abc")):
        grainfit("runs", "show", folder, "abc")
    with pytest.raises(InputError, match=messages.NO_WORK_FOLDER.pattern):
        grainfit("runs", "show", tmp_path, "abc")


# --- export ---------------------------------------------------------------------------------------


def test_csv_and_parquet_hold_the_same_runs_in_full_precision(tmp_path: Path) -> None:
    precise = record(3, responses={"angle_of_repose": Response(1 / 3, 1e-17)})
    folder = work(tmp_path / "work", record(1), failed(2, 'a "reason",\nof two lines'), precise)
    assert "Wrote 3 runs" in grainfit("runs", "export", folder, tmp_path / "runs.csv").stdout
    grainfit("runs", "export", folder, tmp_path / "runs.parquet")
    with (tmp_path / "runs.csv").open(newline="") as file:
        lines = list(csv.DictReader(file))
    rows = pyarrow.parquet.read_table(tmp_path / "runs.parquet").to_pylist()
    assert {"particle.density [kg/m^3]", "angle_of_repose.standard_error [deg]"} <= set(lines[0])
    lines = [{name.partition(" [")[0]: cell for name, cell in line.items()} for line in lines]
    assert list(rows[0]) == list(lines[0])
    assert [float(line["angle_of_repose"] or "nan") for line in lines][2] == 1 / 3
    assert rows[2]["angle_of_repose.standard_error"] == 1e-17
    assert rows[1]["angle_of_repose"] is None
    assert lines[1]["angle_of_repose"] == ""
    assert lines[1]["reason"] == rows[1]["reason"] == 'a "reason",\nof two lines'
    assert lines[0]["ended"] == rows[0]["ended"].isoformat() == "2023-11-14T22:13:21+00:00"
    assert {line["particle.density"] for line in lines} == {"1600.0", "1700.0", "1800.0"}
    assert [row["seed"] for row in rows] == [1, 2, 3]
    grainfit("runs", "export", folder, tmp_path / "few.csv", "--status", "failed")
    assert len((tmp_path / "few.csv").read_text().splitlines()) == 1 + 2, "one run, of two lines"


def test_a_table_of_exported_runs_gives_the_same_responses_and_errors(tmp_path: Path) -> None:
    answers = [Response(20.0 + number / 3, 0.1 * number) for number in (1, 2, 3)]
    runs = [record(n, responses={"angle_of_repose": r}) for n, r in enumerate(answers, 1)]
    grainfit("runs", "export", work(tmp_path / "work", *runs), tmp_path / "runs.csv")
    table = RecordedTable(tmp_path / "runs.csv", ["particle.density"], ["angle_of_repose"])
    again = [
        table.run({"particle.density": 1500.0 + 100 * n}, n, Workspace(tmp_path / "run"))
        for n in (1, 2, 3)
    ]
    assert [found["angle_of_repose"] for found in again] == answers


FORMULAS = (
    "=cmd|' /C calc'!A0",
    "+1+1",
    "-x",
    "@SUM(1)",
    "'=1",
    "a;=1",
    'a;"=1',
    "\uff1d1",
)


def test_no_cell_of_an_exported_table_is_a_formula(tmp_path: Path) -> None:
    signs = ("=", "+", "@", "\t", "\r", "\uff1d")
    texts = [*FORMULAS, "\t=1", "\r=1", " =1", '"=1"', "plain", "-5"]
    runs = [
        record(n, test=text, origin=text, responses={text: Response(-2.5)}, kind=text)
        for n, text in enumerate(texts, 1)
    ]
    runs += [replace(failed(99), reason=texts[0])]
    grainfit("runs", "export", work(tmp_path / "work", *runs), tmp_path / "runs.csv")

    with (tmp_path / "runs.csv").open(newline="") as file:
        header, *lines = csv.reader(file)
    starts = [part.strip(' "') for row in (header, *lines) for c in row for part in c.split(";")]
    assert [c for c in starts if c.startswith(signs) or (c[:1] == "-" and not is_number(c))] == []
    assert [line[header.index("plain")] for line in lines if line[1] == "plain"] == ["-2.5"]
    assert {"-5", "plain"} <= {line[header.index("test")] for line in lines}


def is_number(text: str) -> bool:
    return text.replace(".", "").removeprefix("-").isdigit()


@pytest.mark.usefixtures("sand")
def test_an_exported_table_is_read_with_its_original_names() -> None:
    runs = [
        record(n, test=text, responses={text: Response(-2.5)}) for n, text in enumerate(FORMULAS, 1)
    ]
    grainfit("runs", "export", work(Path("work"), *runs), "runs.csv")

    table = read_table(Path("runs.csv"))
    names = [heading.text for heading in table.headings]
    assert names[-2 * len(FORMULAS) :: 2] == list(FORMULAS)
    assert table.cells_of(names.index("test")) == list(FORMULAS)


def test_a_text_is_the_same_after_a_spreadsheet_cell() -> None:
    draw = random.Random(1)
    texts = ["".join(draw.choices("'\"=+-@;\t\r\n 1a", k=draw.randint(0, 7))) for _ in range(5000)]
    assert [from_spreadsheet_text(spreadsheet_text(text)) for text in texts] == texts


def test_an_export_is_whole_or_not_there(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    folder = work(tmp_path / "work", record(1))
    (tmp_path / "busy.csv").mkdir()
    with pytest.raises(InputError, match=r"busy.csv. cannot be written"):
        grainfit("runs", "export", folder, tmp_path / "busy.csv")
    with pytest.raises(InputError, match=of_work_folder.UNKNOWN_FORMAT.pattern):
        grainfit("runs", "export", folder, tmp_path / "runs.xls")
    monkeypatch.setitem(sys.modules, "pyarrow", None)
    monkeypatch.setitem(sys.modules, "pyarrow.parquet", None)
    with pytest.raises(InputError, match=r"pip install 'grainfit\[parquet\]'"):
        grainfit("runs", "export", folder, tmp_path / "runs.parquet")
    assert sorted(path.name for path in tmp_path.iterdir()) == ["busy.csv", "work"]


def test_a_parameter_and_a_response_of_the_same_name_keep_their_columns() -> None:
    definition = RunDefinition({}, {"x": 1.0, "status": 2.0}, 1)
    clash = record(1, definition=definition, responses={"x": Response(3.0)})
    [row] = runs_table([clash]).to_dict("records")
    assert row["x"] == 1.0
    assert row["parameter.status"] == 2.0
    assert row["status"] == "finished"
    assert row["response.x"] == 3.0


# --- import ---------------------------------------------------------------------------------------


def imported(file: Path, table: str, folder: str = "work", test: str | None = None) -> Imported:
    path = file.with_name("table.csv")
    path.write_text(table)
    return import_runs(assembly_of(file), path, Path(folder), test)


def test_the_next_calibration_learns_from_imported_runs(sand: Path) -> None:
    grainfit("run", sand, "--no-report", "--workdir", "theirs")
    grainfit("runs", "export", "theirs", "theirs.csv", "--sort", "-seed")
    done = grainfit("runs", "import", sand, "theirs.csv", "--workdir", "ours")
    total = len(stored(Path("theirs")))
    assert f"Imported {total} runs of the" in done.stdout
    assert "test python; 0 were there already." in done.stdout
    assert f"warm start from {total} parameter sets" in done.stdout
    assert {r.identity for r in stored(Path("ours"))} == {
        r.identity for r in stored(Path("theirs"))
    }, "with its seed, a run is the same run wherever it was made"
    sand.write_text(FILE.replace("value = 36", "value = 37"))
    learnt = grainfit("run", sand, "--no-report", "--workdir", "ours")
    source = f"imported from {Path('theirs.csv').absolute()} ({total})"
    assert f"Warm start from {total} earlier runs: {source}." in learnt.stderr
    again = grainfit("runs", "import", sand, "theirs.csv", "--workdir", "theirs")
    assert "Imported 0 runs of the" in again.stdout
    assert f"test python; {total} were there already." in again.stdout
    assert of_work_folder.NOT_BY_EARLIER_CALIBRATIONS.is_in(again.stdout)


def test_an_exported_table_can_be_calibrated_on_and_imported_as_it_is(sand: Path) -> None:
    model = MODEL.replace('["friction"] + noise}', '["friction"] + noise, 0.25 + abs(noise))}')
    model = model.replace('"angle": 20', '"angle": (20')
    sand.with_name("model.py").write_text(model)
    grainfit("run", sand, "--no-report", "--workdir", "theirs")
    grainfit("runs", "export", "theirs", "theirs.csv", "--status", "finished")
    grainfit("runs", "import", sand, "theirs.csv", "--workdir", "imported")
    made = {r.identity: r.responses for r in stored(Path("theirs"))}
    assert {r.identity: r.responses for r in stored(Path("imported"))} == made
    times = [
        {r.identity: (r.seconds, int(r.ended)) for r in stored(Path(folder))}
        for folder in ("imported", "theirs")
    ]
    assert times[0] == times[1]
    assert all(seconds > 0 for seconds, _ in times[0].values())
    how = 'type = "python"\nfunction = "model.py:drum"'
    table = 'type = "table"\nfile = "theirs.csv"\nnearest = true'
    file = sand.with_name("table.toml")
    file.write_text(FILE.replace(how, table).replace("blades = 4\n", ""))
    grainfit("run", file, "--no-report", "--workdir", "looked_up")
    looked_up = [r.responses["angle"] for r in stored(Path("looked_up"))]
    known = [found["angle"] for found in made.values()]
    assert len(looked_up) > 5
    assert all(response in known for response in looked_up)
    assert len({response.standard_error for response in looked_up}) > 1
    text = Path("theirs.csv").read_text()
    Path("old.csv").write_text(text.replace("angle.standard_error", "angle_std_error"))
    file.write_text(file.read_text().replace("theirs.csv", "old.csv"))
    remedy = r"column angle_std_error: is the name of .* Name it angle.standard_error."
    with pytest.raises(InputError, match=remedy):
        grainfit("run", file, "--no-report", "--workdir", "old")
    with pytest.raises(InputError, match=remedy):
        grainfit("runs", "import", sand, "old.csv", "--workdir", "old")


def test_importing_a_table_again_changes_only_what_was_corrected_in_it(sand: Path) -> None:
    table = "angle,friction\n30,0.3\n31,0.3\n31,0.3\n34,0.4\n"
    first = imported(sand, table)
    assert (first.new, first.known, first.replaced, first.usable) == (4, 0, 0, 4)
    runs = {r.identity: r for r in stored(Path("work"))}
    seeds = sorted(r.definition.seed for r in runs.values())
    assert seeds == [FIRST_SEED, FIRST_SEED, FIRST_SEED + 1, FIRST_SEED + 2]
    assert {r.origin for r in runs.values()} == {f"imported from {sand.with_name('table.csv')}"}
    assert (again := imported(sand, table)).new == again.replaced == 0
    assert again.known == 4
    corrected = imported(sand, table.replace("34", "36"))
    assert (corrected.new, corrected.known, corrected.replaced) == (0, 3, 1)
    assert {r.identity for r in stored(Path("work"))} == runs.keys()
    shorter = imported(sand, "angle,friction\n30,0.3\n")
    assert shorter.known == 1
    assert of_work_folder.EARLIER_IMPORT_STAYS.is_in(str(shorter), runs="3 runs")


def test_runs_of_two_tables_at_the_same_parameters_are_repeats(sand: Path) -> None:
    imported(sand, "friction,angle\n0.3,30\n")
    other = sand.with_name("other.csv")
    other.write_text("friction,angle,seed\n0.3,31,\n0.3,30,\n0.3,35,7\n")
    for new, known in ((2, 1), (0, 3)):
        done = import_runs(assembly_of(sand), other, Path("work"))
        assert (done.new, done.known) == (new, known)
    values = sorted(r.responses["angle"].value for r in stored(Path("work")))
    assert values == [30.0, 31.0, 35.0]
    exported = f"friction,angle,seed\n0.4,41,\n0.4,40,{FIRST_SEED}\n"
    assert imported(sand, exported, "again").new == 2, "a given seed keeps its run"


def test_a_run_that_was_made_here_is_not_replaced_by_a_table(sand: Path) -> None:
    solver = assembly_of(sand).solvers["python"]
    grainfit("simulate", sand, "--set", "friction=0.3", "--seed", "7", "--workdir", "work")
    [made] = stored(Path("work"))
    assert made.definition == solver.definition({"friction": 0.3}, 7)
    done = imported(sand, "friction,angle,seed\n0.3,99,7\n0.3,98,8.0\n")
    assert (done.new, done.known, done.replaced) == (1, 0, 0)
    assert of_work_folder.RUN_STAYS.is_in(str(done), line=2, origin="made here")
    assert made in stored(Path("work"))


def test_every_fault_of_a_table_is_named_with_its_line(sand: Path) -> None:
    with pytest.raises(InputError) as caught:
        imported(
            sand,
            "frction,angle [kg],angle.standard_error,blades,seed,\n"
            "0.3,30,0.1,4,1,\n"
            "\n"
            "0.3,x,-1,5,1.5,\n"
            "0.3,,nan,4,-2,\n"
            '0.3,"30,5",0,4,3,\n'
            "0.3,30\n"
            "0.3,1_000,0,4,1e3,\n",
        )
    text = str(caught.value)
    for part in (
        'line 1, column friction: is missing. Is it "frction"? Name it "friction".',
        "line 1, column angle: '1 kg' has the unit kg, which cannot be converted to deg",
        "line 4, column angle: is 'x', not a number",
        "line 4, column angle.standard_error: is -1",
        "line 4, column blades: is 5, and 4 in the calibration file",
        "line 4, column seed: is '1.5'",
        "line 5, column angle: has no value",
        "line 5, column angle.standard_error: is nan",
        "line 5, column seed: is '-2'",
        "line 6, column angle: is '30,5', where other numbers of the table have the decimal",
        "line 7, column angle.standard_error: has no cell: the row has 2, and the header 6",
        "line 8, column angle: is '1_000', not a number",
        "line 8, column seed: is '1e3'",
    ):
        assert part in text, part
    assert len(caught.value.faults) == 13
    assert not Path("work").exists(), "nothing of a faulty table is taken"
    for table, part in (
        ("friction|angle\n0.3|30\n", "column angle: is missing. There are: friction.angle"),
        ("friction,angle\n", "holds no runs"),
        ("friction,friction,angle\n0.3,0.3,30\n", "is there more than once"),
        ("friction,angle,seed\n0.3,30,7\n0.3,31,7\n", "same parameters and seed as line 2"),
        ("friction [J],angle\n0.3,30\n", "nothing says which unit your model takes"),
        ("friction,angle,angle.standard_eror\n0.3,30,1\n", 'Did you mean "angle.standard_error"'),
        ("", "is empty"),
    ):
        with pytest.raises(InputError, match=part):
            imported(sand, table)
    with pytest.raises(InputError, match="cannot be read"):
        import_runs(assembly_of(sand), Path("nowhere.csv"), Path("work"))


def test_what_is_outside_of_an_interval_is_taken_and_said(sand: Path) -> None:
    # The interval is 0.8 wide, and the half of that beyond it is used.
    done = imported(sand, "friction [-];angle / rad\n1,35;1\n0,3;0,55\n0,95;0,6\n")
    assert (done.new, done.usable) == (3, 2)
    assert done.notices == (
        "Outside of the interval of friction (0.1 to 0.9) by more than 50% of its width, and not "
        "used while it is so: line 2.",
    )
    angles = sorted(r.responses["angle"].value for r in stored(Path("work")))
    assert angles == pytest.approx([31.51267873, 34.37746771, 57.29577951])


def test_runs_of_a_heap_are_imported_in_the_units_of_the_table(tmp_path: Path) -> None:
    file = EXAMPLES / "glass_beads" / "calibration.toml"
    table = tmp_path / "table.csv"
    header = "particle.density [g/cm^3],particle_particle.rolling_friction,"
    table.write_text(
        header + "bulk_density [t/m^3],angle_of_repose [°],particle.youngs_modulus [MPa],"
        "bulk_density.standard_error [g/cm^3]\n"
        "2.1,0.5,1.4,21.5,0.36,0.001\n2.2,0.6,1.45,23,0.36,\n"
    )
    setup = assembly_of(file)
    done = import_runs(setup, table, tmp_path / "work")
    assert (done.new, done.usable) == (2, 2)
    first, _ = runs_of(setup.problem, setup.solvers, stored(tmp_path / "work"))
    assert first.proposal.parameters == {
        "particle.density": 2100.0,
        "particle_particle.rolling_friction": 0.5,
    }
    assert first.responses["bulk_density"] == Response(1400.0, 1.0)
    assert first.responses["angle_of_repose"] == Response(21.5)
    table.write_text(header + "bulk_density,angle_of_repose\n2100,0.5,1400,21.5\n")
    with pytest.raises(InputError, match=r"column particle.density: is 2100000.0. It must be fr"):
        import_runs(setup, table, tmp_path / "work")


def test_importing_runs_of_a_solver_that_is_missing_says_why_it_is_needed(tmp_path: Path) -> None:
    text = (EXAMPLES / "glass_beads" / "calibration.toml").read_text()
    program = tmp_path / "lmp"
    program.write_text("#!/no/such/interpreter\n")
    program.chmod(0o755)
    line = 'solver = "lammps"'
    assert text.count(line) == 1
    file = tmp_path / "calibration.toml"
    file.write_text(text.replace(line, f'{line}\nexecutable = "{program}"'))
    table = "particle.density,particle_particle.rolling_friction,bulk_density,angle_of_repose\n"
    with pytest.raises(SolverNotFoundError, match=of_work_folder.SOLVER_FOR_IMPORT.pattern):
        imported(file, table + "2100,0.5,1400,21\n", str(tmp_path / "work"))


@pytest.fixture
def two_tests(sand: Path) -> Path:
    """A file with a Python test, and a command whose program is not installed."""
    model = sand.with_name("model")
    model.mkdir()
    (model / "deck.j2").write_text("{{ friction }} {{ seed }}")
    sand.write_text(
        FILE
        + '[[test]]\ntype = "command"\nname = "shear"\nfolder = "model"\n'
        + 'command = ["no_such_program", "deck"]\ntargets.force = { value = 3.0 }\n'
    )
    return sand


def test_show_takes_the_number_of_a_run_in_the_report(sand: Path) -> None:
    grainfit("run", sand, "--no-report", "--max-runs", "9")
    saved = SavedCalibration.open(sand.with_suffix(".grainfit"))
    [identity] = saved.evaluations[2].runs.values()
    assert identity in grainfit("runs", "show", saved.folder, "3").stdout
    with pytest.raises(InputError, match=of_work_folder.NO_RUN.matching(identity="9999")):
        grainfit("runs", "show", saved.folder, "9999")


def test_runs_of_several_tests_at_equal_parameters_belong_together(two_tests: Path) -> None:
    with pytest.raises(InputError, match=f"--test: {of_work_folder.TEST_NOT_GIVEN.pattern}"):
        imported(two_tests, "friction,force\n0.3,2\n")
    with pytest.raises(InputError, match="There are: python, shear"):
        imported(two_tests, "friction,force\n0.3,2\n", test="heap")
    assert imported(two_tests, "friction,force\n0.3,2\n0.3,2.1\n", test="shear").usable == 2
    both = imported(two_tests, "friction,angle\n0.3,30\n0.3,31\n0.4,33\n", test="python")
    assert both.usable == 3
    setup = assembly_of(two_tests)
    assert isinstance(setup.solvers["shear"], Command)
    found = runs_of(setup.problem, setup.solvers, stored(Path("work")))
    values = [{name: r.value for name, r in e.responses.items()} for e in found]
    assert values == [
        {"python.angle": 30.0, "shear.force": 2.0},
        {"python.angle": 31.0, "shear.force": 2.1},
        {"python.angle": 33.0},
    ]


# --- prune ----------------------------------------------------------------------------------------


def run_folder(folder: Path, kept: RunRecord) -> Path:
    made = folder / "runs" / kept.identity
    (made / "snapshots").mkdir(parents=True)
    for name in ("in.lammps", "snapshots/heap.dump", "solver.log", "heap.png"):
        (made / name).write_text("x" * 1000)
    (made / RECORD_NAME).write_text(json.dumps(kept.to_json()))
    return made


def names(folder: Path) -> list[str]:
    return sorted(str(path.relative_to(folder)) for path in folder.rglob("*"))


def test_pruning_keeps_record_logs_and_pictures_and_touches_nothing_else(tmp_path: Path) -> None:
    folder = work(tmp_path / "work", record(1), failed(2))
    finished, broken = run_folder(folder, record(1)), run_folder(folder, failed(2))
    outside = run_folder(tmp_path / "elsewhere", record(3))
    (finished / "link").symlink_to(outside)
    (folder / "runs" / record(3).identity).symlink_to(outside)
    partial = folder / "runs" / f"{record(4).identity}.1.partial"
    run_folder(folder, record(4, identity=partial.name))
    mine = folder / "runs" / "my notes"
    mine.mkdir()
    (mine / "notes.txt").write_text("mine")
    untouched = {path: names(path) for path in (broken, outside, partial, mine)}
    with hold(folder), pytest.raises(StoreError, match=messages.FOLDER_IN_USE.pattern) as fault:
        prune_runs(folder)
    assert "--workdir" not in str(fault.value)
    assert "snapshots" in names(finished)
    said = grainfit("runs", "prune", folder).stdout
    assert said == "Freed 2.1 kB in 1 run folder.\n", "a link is as long as where it leads"
    assert names(finished) == ["heap.png", RECORD_NAME, "solver.log"]
    assert {path: names(path) for path in untouched} == untouched
    assert stored(folder) == [record(1), failed(2)]
    assert prune_runs(folder, failed=True).folders == 1
    assert names(broken) == ["heap.png", RECORD_NAME, "solver.log"]
    assert prune_runs(folder, failed=True).freed == 0
    assert names(outside) == untouched[outside]


def test_pruning_refuses_what_is_no_work_folder_and_runs_elsewhere(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=messages.NO_WORK_FOLDER.pattern):
        prune_runs(tmp_path)
    folder = work(tmp_path / "work", record(1))
    outside = run_folder(tmp_path / "elsewhere", record(1))
    (folder / "runs").symlink_to(outside.parent)
    with pytest.raises(InputError, match=of_work_folder.RUNS_ARE_A_LINK.pattern):
        prune_runs(folder)
    assert "in.lammps" in names(outside)


def test_pruning_a_folder_that_cannot_be_written_names_no_other(tmp_path: Path) -> None:
    folder = work(tmp_path / "work", record(1))
    (folder / "lock").mkdir()
    with pytest.raises(StoreError, match=messages.MAKE_WRITABLE.pattern):
        prune_runs(folder)
    with pytest.raises(StoreError, match=messages.ANOTHER_FOLDER.pattern), hold(folder):
        pass


def test_the_list_says_what_the_run_folders_take(tmp_path: Path) -> None:
    folder = work(tmp_path / "work", record(1))
    made = run_folder(folder, record(1))
    (made / "link").symlink_to(tmp_path)
    used = sum(
        path.lstat().st_size for path in made.rglob("*") if not path.is_dir() or path.is_symlink()
    )
    assert disk_use(folder, 10.0) == used
    assert f"Run folders take {size(used)}." in grainfit("runs", "list", folder).stdout
    assert disk_use(folder, -1.0) is None, "it is given up when it takes too long"
