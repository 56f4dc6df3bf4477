"""Damage single cells of a store, and use its work folder with every command.

A disk, a copy or a person may change any cell of ``runs.sqlite``. Whatever it contains, a command
answers, or ends with a message that names the file.
"""

from __future__ import annotations

import json
import random
import shutil
import sqlite3
from collections.abc import Callable, Iterator, Mapping
from contextlib import closing, redirect_stdout
from io import StringIO
from pathlib import Path
from typing import Any

from grainfit.calibration.calibrate import calibrate
from grainfit.campaign.store.store import STORE_NAME
from grainfit.cli.app import app
from grainfit.errors import GrainfitError
from grainfit.problem import CurveTarget, Parameter, Problem, Target
from grainfit.report.page import write_report
from grainfit.result import Result
from grainfit.work_folder.saved_calibration import SavedCalibration

PROBLEM = Problem(
    [Parameter("friction", 0.1, 0.9), Parameter("restitution", 0.2, 0.8)],
    [Target("angle", 26.0, 1.0)],
    curves=[CurveTarget("strain", [1.0, 2.0, 3.0], [0.5, 0.7, 0.8], uncertainty=0.05)],
)
_MOST_RUNS = 9
_HUGE = 3_000_000


def model(parameters: dict[str, float], seed: int) -> dict[str, Any]:
    """Return the responses of a run; a corner of the parameters has none."""
    friction, restitution = parameters["friction"], parameters["restitution"]
    if friction > 0.8:
        raise ValueError("the heap collapsed")
    strain = [0.5 * stress**0.4 * (1.2 - 0.4 * restitution) for stress in (1.0, 2.0, 3.0)]
    return {
        "angle": 10 + 50 * friction**2 + seed % 101 / 101,
        "strain": {"coordinates": [1.0, 2.0, 3.0], "values": strain},
    }


def finished_calibration(folder: Path) -> Path:
    """Calibrate in a folder, and return it; its store accepts any content in any cell."""
    _calibrate(folder)
    with closing(sqlite3.connect(folder / STORE_NAME)) as store:
        store.execute("PRAGMA journal_mode = DELETE")
        store.execute("PRAGMA writable_schema = ON")
        store.execute("UPDATE sqlite_master SET sql = replace(sql, 'NOT NULL', '')")
        store.commit()
    return folder


def damage_cell(store: Path, chance: random.Random) -> str:
    """Change one cell of a store, and return a description of it."""
    with closing(sqlite3.connect(store)) as database:
        tables = [
            row[0]
            for row in database.execute(
                "SELECT name FROM sqlite_master WHERE type = 'table' ORDER BY name"
            )
        ]
        table = chance.choice(tables)
        columns = [row[1] for row in database.execute(f"PRAGMA table_info({table})")]
        column = chance.choice(columns)
        rows = database.execute(f"SELECT rowid, {column} FROM {table} ORDER BY rowid").fetchall()
        row, old = chance.choice(rows)
        kind, new = chance.choice(list(_damages(old, chance).items()))
        if column == "schema_version":
            # SQLite keeps nothing else in it.
            kind, new = "number", chance.choice([-1, 0, 1, 2, 3, 4, 6, 2**62])
        database.execute(f"UPDATE OR REPLACE {table} SET {column} = ? WHERE rowid = ?", (new, row))
        database.commit()
    return f"{table}.{column} of row {row}: {kind}, {str(new)[:60]!r}"


def _damages(old: object, chance: random.Random) -> dict[str, Any]:
    """Return contents that a cell could have instead, by kind of damage."""
    found: dict[str, Any] = {
        "nothing": None,
        "number": chance.choice([0, -1, 5, 2**62, 0.5, 1e308, float("inf")]),
        "text": chance.choice(["", "x", "running", "1e999", "NaN", "\0", "5", "[]", "{}", '"a"']),
        "bytes": b"\xff\xfe\x00",
        "huge": "x" * _HUGE,
        "deep": "[" * 100_000,
    }
    if isinstance(old, str):
        found["cut"] = old[: chance.randrange(len(old) + 1)]
        found["JSON"] = _with_other_leaf(old, chance)
    return found


def _with_other_leaf(old: str, chance: random.Random) -> str:
    """Return JSON in which one value is another."""
    try:
        data = {"": json.loads(old)}
    except ValueError:
        return f"{old}?"
    places = list(_places(data))
    inside, key = chance.choice(places)
    inside[key] = chance.choice([None, True, -3, 1e308, 5e-324, "x", [], {}, [1], {"a": {}}, ""])
    return json.dumps(data[""])


def _places(data: Any) -> Iterator[tuple[Any, Any]]:
    keys = data if isinstance(data, dict) else range(len(data)) if isinstance(data, list) else ()
    for key in keys:
        yield data, key
        yield from _places(data[key])


def _calibrate(folder: Path) -> None:
    calibrate(PROBLEM, model, workdir=folder, max_runs=_MOST_RUNS)


def _command(*words: str) -> Callable[[Path], None]:
    def call(folder: Path) -> None:
        with redirect_stdout(StringIO()):
            app([word.format(folder) for word in words], standalone_mode=False)

    return call


def _summarise(folder: Path) -> None:
    saved = SavedCalibration.open(folder)
    str(saved)
    saved.runs()


def _read_result(folder: Path) -> None:
    Result.from_json(folder / "result.json")


#: Uses of a work folder that only read, all but the slow report.
READING: Mapping[str, Callable[[Path], None]] = {
    "status": _command("status", "{}"),
    "runs list": _command("runs", "list", "{}"),
    "runs export": _command("runs", "export", "{}", "{}/runs.csv", "--force"),
    "open": _summarise,
    "result": _read_result,
}
#: All uses; the run is the last, because it writes.
USES: Mapping[str, Callable[[Path], Any]] = {**READING, "report": write_report, "run": _calibrate}


def complaints(
    original: Path,
    place: Path,
    seed: int,
    uses: Mapping[str, Callable[[Path], Any]],
) -> Iterator[str]:
    """Damage a cell in a copy of a work folder, and yield every use that ends badly.

    Parameters
    ----------
    original : Path
        From `finished_calibration`.
    place : Path
        Folder for the copy.
    seed : int
        Decides the damage.
    uses : mapping of str to callable
        Uses of the copy, by name.
    """
    copy = place / str(seed)
    shutil.copytree(original, copy)
    damage = damage_cell(copy / STORE_NAME, random.Random(seed))
    for name, use in uses.items():
        fault = _fault_of(use, copy)
        if fault:
            yield f"seed {seed}, {damage}; {name}: {fault}"
    shutil.rmtree(copy)


def _fault_of(use: Callable[[Path], Any], folder: Path) -> str:
    """Return how a use ends badly; "" if it answers, or names the file in its message."""
    try:
        use(folder)
    except GrainfitError as error:
        message = str(error)
        if STORE_NAME not in message:
            return f"does not name the file: {message[:500]}"
        return f"a long message: {message[:500]}" if len(message) > 1000 else ""
    except (Exception, SystemExit) as error:
        return f"{type(error).__name__}: {error}"[:500]
    return ""
