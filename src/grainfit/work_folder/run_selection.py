"""Select and order runs."""

from __future__ import annotations

import difflib
import math
import operator
import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import get_args

from grainfit.campaign.store.records import RunStatus
from grainfit.errors import Fault, InputError
from grainfit.formatting import in_a_row
from grainfit.units import UnitError, to_unit
from grainfit.work_folder import messages
from grainfit.work_folder.run_columns import COMMON_COLUMNS, INTERRUPTED, RunColumns

_CONDITION = re.compile(r"\s*(?P<name>[^<>=!]+?)\s*(?P<operator><=|>=|==|!=|=|<|>)(?P<value>.+)")


def select_runs(
    runs: RunColumns,
    status: str | None = None,
    test: str | None = None,
    where: Iterable[str] = (),
) -> RunColumns:
    """Return the runs that meet all conditions.

    Parameters
    ----------
    runs : RunColumns
        The runs.
    status, test : str, optional
        Status and name of the test.
    where : iterable of str
        Conditions on numbers, such as ``particle.density > 2 g/cm^3`` or ``seconds < 60``. A
        run that does not have the number does not meet the condition.

    Raises
    ------
    InputError
        A condition cannot be read, or no run has the number that it names.
    """
    faults: list[Fault] = []
    chosen = set(range(len(runs)))
    for key, wanted, there in (
        ("status", status, [*get_args(RunStatus), INTERRUPTED]),
        ("test", test, list(dict.fromkeys(runs.values["test"]))),
    ):
        if wanted is not None:
            chosen &= {row for row, found in enumerate(runs.values[key]) if found == wanted}
            if there and wanted not in there:
                known = _suggestion(wanted, there)
                faults.append(messages.UNKNOWN.fault(f"--{key}", wanted=wanted, known=known))
    for condition in where:
        try:
            chosen &= _meeting(runs, condition)
        except InputError as error:
            faults += error.faults
    InputError.raise_for(faults)
    return runs.rows(sorted(chosen))


def sort_runs(runs: RunColumns, by: str) -> RunColumns:
    """Return runs in the order of a column; with ``-`` before its name, the largest first.

    Runs that have nothing in this column come last.

    Raises
    ------
    InputError
        There is no such column.
    """
    name = by.removeprefix("-").strip()
    if name not in runs.values:
        known = _suggestion(name, [*runs.values])
        raise InputError(messages.NO_SUCH_COLUMN.fault("--sort", name=name, known=known))
    column = runs.values[name]
    there = [row for row, value in enumerate(column) if value is not None]
    there.sort(key=column.__getitem__, reverse=by.startswith("-"))
    return runs.rows([*there, *(row for row, value in enumerate(column) if value is None)])


def _meeting(runs: RunColumns, text: str) -> set[int]:
    """Return the rows that meet a condition."""
    match = _CONDITION.fullmatch(text)
    if match is None:
        raise InputError(messages.NO_CONDITION.fault("--where", text=text))
    name = match["name"]
    known = [c for c in runs.values if c not in COMMON_COLUMNS or c in ("seed", "seconds")]
    if name not in known:
        known_ones = _suggestion(name, known)
        raise InputError(messages.NO_SUCH_NUMBER.fault("--where", name=name, known=known_ones))
    try:
        limit = _limit(match["value"].strip(), name, runs)
    except UnitError as error:
        raise InputError(Fault("--where", f"{name}: {error.message}", error.remedy)) from error
    holds = _OPERATORS[match["operator"]]
    return {
        row
        for row, value in enumerate(runs.values[name])
        if value is not None and holds(value, limit)
    }


def _limit(text: str, name: str, runs: RunColumns) -> float:
    try:
        value = float(text)
    except ValueError:
        unit = runs.units.get(name)
        if unit is None:
            raise UnitError(messages.COMPARED_AS_IT_IS.fault("", text=text)) from None
        return to_unit(text, unit)
    if math.isnan(value):
        raise UnitError(messages.NOT_A_NUMBER.fault("", text=text))
    return value


def _close(value: float, limit: float) -> bool:
    # A value converted from one unit to another may differ in the last digit.
    return math.isclose(value, limit, rel_tol=1e-12, abs_tol=0.0)


_OPERATORS: Mapping[str, Callable[[float, float], bool]] = {
    "<": operator.lt,
    "<=": operator.le,
    ">": operator.gt,
    ">=": operator.ge,
    "=": _close,
    "==": _close,
    "!=": lambda value, limit: not _close(value, limit),
}


def _suggestion(wrong: str, known: Sequence[str]) -> str:
    short_for = [name for name in known if name.rpartition(".")[2] == wrong]
    close = short_for or difflib.get_close_matches(wrong[:64], known, n=1)
    if close:
        return f"Did you mean {in_a_row(map(repr, close), 'or')}?"
    return f"There are: {', '.join(known)}."
