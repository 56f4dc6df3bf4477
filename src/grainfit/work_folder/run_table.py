"""Runs as a table: a pandas DataFrame with one row for each run."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

from grainfit.campaign.store.records import RunRecord
from grainfit.extras import import_extra
from grainfit.work_folder.run_columns import COMMON_COLUMNS, RunColumns, run_columns

if TYPE_CHECKING:
    import pandas as pd

_TYPES = {"seed": "Int64", "ended": "datetime64[us, UTC]"}


def runs_table(records: Iterable[RunRecord]) -> pd.DataFrame:
    """Return runs as a table, in order, with their identities as index.

    Returns
    -------
    pandas.DataFrame
        The columns `grainfit.work_folder.run_columns.COMMON_COLUMNS`; every parameter, fixed and
        free, by its dotted name; every response and its ``.standard_error``. Numbers are in SI
        units, angles in degrees; what a run does not have is missing. ``attrs`` holds ``units`` by
        column, where they are known, and the columns of ``parameters`` and ``responses``.

    Raises
    ------
    InputError
        pandas is not installed.
    """
    return as_table(run_columns(records))


def as_table(runs: RunColumns) -> pd.DataFrame:
    """Return runs as `runs_table` does."""
    pd = import_extra("pandas", "notebook", "a table of runs")
    columns = {name: _series(pd, name, values) for name, values in runs.values.items()}
    table = pd.DataFrame(columns).set_index("identity")
    table.attrs = {
        "units": dict(runs.units),
        "parameters": list(runs.parameters.values()),
        "responses": list(runs.responses.values()),
    }
    return table


def _series(pd: Any, name: str, values: list[Any]) -> Any:
    if name in _TYPES:
        return pd.Series(values, dtype=_TYPES[name])
    if name == "seconds" or name not in COMMON_COLUMNS:
        return pd.Series(values, dtype=float)
    return values
