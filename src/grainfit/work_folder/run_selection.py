"""Select and order the rows of a table of runs."""

from __future__ import annotations

import difflib
import math
import operator
import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any, get_args

import numpy as np
import pandas as pd

from grainfit.campaign.store.records import RunStatus
from grainfit.errors import Fault, InputError
from grainfit.units import UnitError, to_unit
from grainfit.work_folder.run_table import COMMON_COLUMNS

_CONDITION = re.compile(r"\s*(?P<name>[^<>=!]+?)\s*(?P<operator><=|>=|==|!=|=|<|>)(?P<value>.+)")
_CONDITION_FORM = "Write name, operator and value, such as 'particle.density > 2000'."


def select_runs(
    runs: pd.DataFrame,
    status: str | None = None,
    test: str | None = None,
    where: Iterable[str] = (),
) -> pd.DataFrame:
    """Return the rows that meet all conditions.

    Parameters
    ----------
    runs : pandas.DataFrame
        As `runs_table` returns it.
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
    chosen = pd.Series(True, index=runs.index)
    for key, wanted, there in (
        ("status", status, list(get_args(RunStatus))),
        ("test", test, list(runs["test"].unique())),
    ):
        if wanted is not None:
            chosen &= runs[key] == wanted
            if there and wanted not in there:
                faults.append(Fault(f"--{key}", f"is {wanted!r}.", _suggestion(wanted, there)))
    for condition in where:
        try:
            chosen &= _meets(runs, condition)
        except InputError as error:
            faults += error.faults
    if faults:
        raise InputError(faults)
    return runs[chosen]


def sort_runs(runs: pd.DataFrame, by: str) -> pd.DataFrame:
    """Return runs in the order of a column; with ``-`` before its name, the largest first.

    Runs that have nothing in this column come last.

    Raises
    ------
    InputError
        There is no such column.
    """
    name = by.removeprefix("-").strip()
    known = [runs.index.name, *runs.columns]
    if name not in known:
        raise InputError(Fault("--sort", f"no run has {name!r}.", _suggestion(name, known)))
    return runs.sort_values(name, ascending=not by.startswith("-"), kind="stable")


def _meets(runs: pd.DataFrame, text: str) -> Any:
    match = _CONDITION.fullmatch(text)
    if match is None:
        raise InputError(Fault("--where", f"{text!r} is not a condition.", _CONDITION_FORM))
    name = match["name"]
    known = [c for c in runs.columns if c not in COMMON_COLUMNS or c in ("seed", "seconds")]
    if name not in known:
        message = f"no run has a number called {name!r}."
        raise InputError(Fault("--where", message, _suggestion(name, known)))
    try:
        limit = _limit(match["value"].strip(), runs.attrs["units"].get(name))
    except UnitError as error:
        raise InputError(Fault("--where", f"{name}: {error.message}", error.remedy)) from error
    values = runs[name].to_numpy(float, na_value=math.nan)
    return _OPERATORS[match["operator"]](values, limit) & ~np.isnan(values)


def _limit(text: str, unit: str | None) -> float:
    try:
        value = float(text)
    except ValueError:
        if unit is None:
            raise UnitError(
                f"{text!r} is not a number.",
                "What is given and yielded by models of your own is compared as it is.",
            ) from None
        return to_unit(text, unit)
    if math.isnan(value):
        raise UnitError(f"{text!r} is not a number.", "Nothing is above or below it.")
    return value


def _close(values: Any, limit: float) -> Any:
    # A value converted from one unit to another may differ in the last digit.
    return np.isclose(values, limit, rtol=1e-12, atol=0.0)


_OPERATORS: Mapping[str, Callable[[Any, float], Any]] = {
    "<": operator.lt,
    "<=": operator.le,
    ">": operator.gt,
    ">=": operator.ge,
    "=": _close,
    "==": _close,
    "!=": lambda values, limit: ~_close(values, limit),
}


def _suggestion(wrong: str, known: Sequence[str]) -> str:
    close = difflib.get_close_matches(wrong[:64], known, n=1)
    if close:
        return f"Did you mean {close[0]!r}?"
    return f"There are: {', '.join(known)}."
