"""Types of test that run a custom model: command, function, recorded table."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from grainfit.errors import InputError
from grainfit.options.functions import Function, find_function
from grainfit.options.kinds import Flag, ListOf, OneOrMore, Text
from grainfit.options.paths import Located
from grainfit.options.places import Place, show
from grainfit.options.tables import Key, Values
from grainfit.solvers.base import Solver
from grainfit.solvers.file_entry import TIMEOUT_KEY, FileEntry, TestType
from grainfit.solvers.own_model import messages, table_messages
from grainfit.solvers.own_model.command import Command
from grainfit.solvers.own_model.model_folder import is_inside
from grainfit.solvers.own_model.python_callable import PythonCallable
from grainfit.solvers.own_model.recorded_table import RecordedTable
from grainfit.solvers.parameters_for import AllBut, ParametersFor


def _check_command(values: Values, place: Place) -> None:
    if "responses" in values and "evaluate" in values:
        place.at("responses").fault(messages.RESPONSES_TWICE)
    folder, evaluate = values.get("folder"), values.get("evaluate")
    if folder and evaluate:
        at = place.at("evaluate")
        found = tuple(_find_function_inside(function, folder, at) for function in evaluate)
        values["evaluate"] = None if None in found else found


def _find_function_inside(reference: str, folder: Path, place: Place) -> str | None:
    """Find a function like `find_function`, in a file that must be inside the folder.

    Parameters
    ----------
    reference : str
        ``"file.py:function"``.
    folder : Path
        Folder of the model; a run sees only a copy of it.
    place : Place
        Of the reference.
    """
    written = Path(reference.rpartition(":")[0])
    if ".." in written.parts or not is_inside(folder / written, folder):
        place.fault(messages.FUNCTION_OUTSIDE, given=show(reference), folder=folder)
        return None
    return find_function(reference, folder, place)


def _command(entry: FileEntry) -> Solver:
    options = _options_but(entry, TIMEOUT_KEY.name)
    command = Command(**options, parameters=entry.fixed, response_names=entry.responses)
    if _PARAMETERS.name not in entry.options:
        return command
    # The check refuses those that the model does not mention.
    return ParametersFor(command, takes=AllBut(_left_out(entry)), depends_on_all=True)


def _python(entry: FileEntry) -> Solver:
    function = PythonCallable.from_file(entry.options["function"], entry.responses)
    return ParametersFor(function, entry.fixed, AllBut(_left_out(entry)))


def _table(entry: FileEntry) -> Solver:
    options = _options_but(entry, "file")
    if not entry.responses:
        raise InputError(table_messages.NO_RESPONSES.fault("targets"))
    left_out = _left_out(entry)
    columns = [name for name in entry.free if name not in left_out]
    file = entry.options["file"]
    table = RecordedTable(file, columns, entry.responses, **options, units=entry.units)
    return ParametersFor(table, takes=AllBut(left_out)) if left_out else table


def _options_but(entry: FileEntry, *names: str) -> dict[str, Any]:
    """Return the given keys of the solver."""
    others = {*names, _PARAMETERS.name}
    return {key: value for key, value in entry.options.items() if key not in others}


def _left_out(entry: FileEntry) -> frozenset[str]:
    """Return the free parameters that the file says the test does not depend on."""
    given = entry.options.get(_PARAMETERS.name)
    if given is None:
        return frozenset()
    unknown = [name for name in given if name not in entry.free]
    if unknown or not given:
        named = ", ".join(map(repr, unknown)) or "nothing"
        free = ", ".join(entry.free)
        raise InputError(messages.NO_FREE_PARAMETER.fault(_PARAMETERS.name, named=named, free=free))
    return frozenset(entry.free) - frozenset(given)


_PARAMETERS = Key(
    "parameters",
    ListOf(Text()),
    "Free parameters that the test depends on: it is passed no others, and its runs do not differ "
    "in them. Needed only if there are several tests.",
    example='["particle_wall.restitution"]',
)

COMMAND = TestType(
    "command",
    (
        Key(
            "folder",
            Located(is_folder=True),
            "Your model: its files are copied into the folder of every run.",
            required=True,
            example='"model"',
        ),
        Key(
            "command",
            ListOf(Text()),
            "Program and arguments, started in the copy; {{ ... }} is filled in.",
            required=True,
            example='["lmp", "-in", "in.deck"]',
        ),
        Key(
            "templates",
            ListOf(Text()),
            "Files of the folder that Jinja2 fills in, as names or patterns; *.j2 by default.",
            example='["*.j2"]',
        ),
        Key(
            "responses",
            Text(),
            "JSON file that the command writes: responses by name; responses.json by default.",
            example='"responses.json"',
        ),
        Key(
            "evaluate",
            OneOrMore(Text()),
            "Instead of responses: a function in a file of the folder that gets the folder of the "
            "run and returns the responses by name; or a list of functions, whose responses are "
            "joined.",
            example='"evaluate.py:measure"',
        ),
        TIMEOUT_KEY,
        _PARAMETERS,
    ),
    _command,
    check=_check_command,
)

PYTHON = TestType(
    "python",
    (
        Key(
            "function",
            Function(),
            "Function that is called with the parameters by name and a seed, and returns the "
            "responses by name.",
            required=True,
            example='"model.py:simulate"',
        ),
        _PARAMETERS,
    ),
    _python,
)

TABLE = TestType(
    "table",
    (
        Key(
            "file",
            Located(),
            "CSV file of recorded runs: one column for each free parameter and each response.",
            required=True,
            example='"runs.csv"',
        ),
        Key(
            "nearest",
            Flag(),
            "Whether to use the nearest recorded run for one that was not recorded; it confirms no "
            "answer; false.",
        ),
        _PARAMETERS,
    ),
    _table,
    has_curves=False,
)
