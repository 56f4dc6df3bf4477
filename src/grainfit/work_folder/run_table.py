"""Runs as a table: a pandas DataFrame with one row for each run."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from datetime import UTC, datetime
from typing import Any

import pandas as pd

from grainfit.bulk_tests.registry import class_of_test
from grainfit.campaign.store.records import RunRecord
from grainfit.campaign.store.store import RunStore
from grainfit.contact_models.registry import material_parameter
from grainfit.errors import Fault, InputError
from grainfit.evaluation import ERROR_SUFFIX, scalars

#: Columns that every table of runs has, before those of parameters and responses. The first one is
#: the index.
COMMON_COLUMNS = (
    "identity",
    "test",
    "status",
    "kind",
    "reason",
    "origin",
    "solver",
    "version",
    "seed",
    "seconds",
    "ended",
)
_NAMED_RUNS = 5


def runs_table(records: Iterable[RunRecord]) -> pd.DataFrame:
    """Return runs as a table, in order, with their identities as index.

    Parameters
    ----------
    records : iterable of RunRecord
        The runs.

    Returns
    -------
    pandas.DataFrame
        The columns `COMMON_COLUMNS`; every parameter, fixed and free, by its dotted name; every
        response and its ``.standard_error``. Numbers are in SI units, angles in degrees; what a run
        does not have is missing. ``attrs`` holds ``units`` by column, where they are known, and the
        columns of ``parameters`` and ``responses``.
    """
    records = list(records)
    inputs = [record.definition.parameters for record in records]
    taken = set(COMMON_COLUMNS)
    parameters = {name: _free(name, "parameter", taken) for name in _distinct(inputs)}
    numbers = [scalars(record.responses) for record in records]
    responses = {name: _free(name, "response", taken) for name in _distinct(numbers)}
    columns = _common_columns(records)
    for name, column in parameters.items():
        columns[column] = _numbers(given.get(name) for given in inputs)
    units = {
        "seconds": "s",
        **{
            column: known.unit
            for name, column in parameters.items()
            if (known := material_parameter(name)) is not None
        },
    }
    for name, column in responses.items():
        error = _free(f"{column}{ERROR_SUFFIX}", "response", taken)
        found = [given.get(name) for given in numbers]
        columns[column] = _numbers(response.value if response else None for response in found)
        columns[error] = _numbers(
            response.standard_error if response else None for response in found
        )
        units |= dict.fromkeys((column, error), unit) if (unit := _unit(name, records)) else {}
    table = pd.DataFrame(columns).set_index("identity")
    table.attrs = {
        "units": units,
        "parameters": list(parameters.values()),
        "responses": list(responses.values()),
    }
    return table


def find_run(store: RunStore, identity: str) -> RunRecord:
    """Return the run with this identity, or with an identity that begins with it.

    Raises
    ------
    InputError
        There is none, or there are several.
    """
    wanted = identity.strip().lower()
    found = sorted(known for known in store.identities() if known.startswith(wanted) and wanted)
    if wanted in found:
        found = [wanted]
    record = store.find(found[0]) if len(found) == 1 else None
    if record is not None:
        return record
    if not found:
        raise InputError(
            Fault(
                "",
                f"there is no run {identity!r} in {store.place}.",
                "'grainfit runs list' names the runs.",
            )
        )
    some = ", ".join(found[:_NAMED_RUNS]) + (", ..." if len(found) > _NAMED_RUNS else "")
    raise InputError(
        Fault(
            "", f"{identity!r} is the beginning of {len(found)} runs: {some}.", "Give more of it."
        )
    )


def _common_columns(records: Sequence[RunRecord]) -> dict[str, Any]:
    definitions = [record.definition for record in records]
    own = ("identity", "test", "status", "kind", "reason", "origin")
    return {
        **{name: [_text(getattr(record, name)) for record in records] for name in own},
        **{name: [_text(d.model.get(name)) for d in definitions] for name in ("solver", "version")},
        "seed": pd.array([_seed(d.seed) for d in definitions], dtype="Int64"),
        "seconds": _numbers(record.seconds for record in records),
        "ended": pd.Series(
            [_moment(record.ended) for record in records], dtype="datetime64[us, UTC]"
        ),
    }


def _numbers(values: Iterable[float | None]) -> pd.Series:
    return pd.Series(list(values), dtype=float)


def _seed(seed: int) -> int | None:
    return seed if abs(seed) < 2**63 else None


def _text(value: Any) -> str:
    # A text that is not valid Unicode must not prevent the whole table.
    return value.encode("utf-8", "backslashreplace").decode() if isinstance(value, str) else ""


def _moment(seconds: float) -> datetime | None:
    try:
        return datetime.fromtimestamp(seconds, UTC) if seconds else None
    except (ValueError, OverflowError, OSError):
        return None


def _unit(response: str, records: Iterable[RunRecord]) -> str | None:
    """Return the unit of a response, if all runs that have it agree on one."""
    units = {_unit_in_test(response, record) for record in records if response in record.responses}
    return units.pop() if len(units) == 1 else None


def _unit_in_test(response: str, record: RunRecord) -> str | None:
    # Units of a model's own responses are known to its calibration file only.
    test = class_of_test(record.definition)
    return test.responses[response].unit if test and response in test.responses else None


def _distinct(names: Iterable[Iterable[str]]) -> list[str]:
    return list(dict.fromkeys(name for some in names for name in some))


def _free(name: str, kind: str, taken: set[str]) -> str:
    """Reserve a column name that no other column has."""
    column = next(c for c in _candidates(_text(name), kind) if c not in taken)
    taken.add(column)
    return column


def _candidates(name: str, kind: str) -> Iterator[str]:
    while True:
        yield name
        name = f"{kind}.{name}"
