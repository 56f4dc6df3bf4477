"""Runs as columns of plain values, which need no numerical package."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from datetime import UTC, datetime
from functools import cached_property
from pathlib import Path
from typing import Any

from grainfit.calibration.provenance import Provenance
from grainfit.campaign.folder_lock import is_held
from grainfit.campaign.store.records import RunRecord
from grainfit.campaign.store.store import RunStore
from grainfit.contact_models.registry import material_units
from grainfit.errors import InputError
from grainfit.evaluation import ERROR_SUFFIX, scalars
from grainfit.work_folder import messages

#: Columns that all runs have, before those of parameters and responses.
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
#: Status of a run whose process has died.
INTERRUPTED = "interrupted"
#: Behind the test of a run in a smaller apparatus than the laboratory's.
_SMALLER = " (smaller)"
_NAMED_RUNS = 5
#: Seeds beyond these are no whole numbers of a table.
_SEED_LIMIT = 2**63


@dataclass(frozen=True)
class RunColumns:
    """Runs, one row for each; None where a run does not have a value.

    Parameters
    ----------
    records : sequence of RunRecord
        The runs, by row.
    values : mapping of str to list
        Values by column: `COMMON_COLUMNS`; every parameter, fixed and free, by its dotted name;
        every response and its ``.standard_error``. Numbers are in SI units, angles in degrees.
    parameters, responses : mapping of str to str
        Columns by name of the parameter and of the response.
    """

    records: Sequence[RunRecord]
    values: Mapping[str, list[Any]]
    parameters: Mapping[str, str]
    responses: Mapping[str, str]

    def __len__(self) -> int:
        return len(self.records)

    def rows(self, chosen: Sequence[int]) -> RunColumns:
        """Return some rows, in this order."""
        values = {name: [column[row] for row in chosen] for name, column in self.values.items()}
        return replace(self, records=[self.records[row] for row in chosen], values=values)

    @property
    def parameter_units(self) -> dict[str, str]:
        """SI units by name of the parameter, where they are known."""
        return material_units(self.parameters)

    @cached_property
    def units(self) -> Mapping[str, str]:
        """SI units by column, where they are known.

        Those of responses are known to the bulk tests, which take a second to import.
        """
        units = {"seconds": "s"}
        for name, unit in self.parameter_units.items():
            units[self.parameters[name]] = unit
        for name, column in self.responses.items():
            if found := _unit(name, self.records):
                units |= dict.fromkeys((column, f"{column}{ERROR_SUFFIX}"), found)
        return units


def none_running(source: str) -> bool:
    """Whether no process executes runs in a work folder; of a shared store that is not known."""
    return "://" not in source and not is_held(Path(source))


def run_columns(
    records: Iterable[RunRecord],
    none_is_running: bool = False,
    laboratory: Mapping[str, Any] | None = None,
) -> RunColumns:
    """Return runs as columns, in order.

    Parameters
    ----------
    records : iterable of RunRecord
        The runs.
    none_is_running : bool
        Whether those that are stored as running were interrupted.
    laboratory : mapping of str to mapping, optional
        Definitions of the tests of which a smaller apparatus was simulated, too: the test of such a
        run is called so, because its responses are others.
    """
    records = list(records)
    inputs = [record.definition.parameters for record in records]
    taken = set(COMMON_COLUMNS)
    parameters = {name: _free(name, "parameter", taken) for name in _distinct(inputs)}
    numbers = [scalars(record.responses) for record in records]
    responses = {name: _free(name, "response", taken) for name in _distinct(numbers)}
    values = _common_columns(records, laboratory or {})
    if none_is_running:
        values["status"] = [INTERRUPTED if s == "running" else s for s in values["status"]]
    for name, column in parameters.items():
        values[column] = [_number(given.get(name)) for given in inputs]
    for name, column in responses.items():
        error = _free(f"{column}{ERROR_SUFFIX}", "response", taken)
        found = [given.get(name) for given in numbers]
        values[column] = [_number(response.value) if response else None for response in found]
        errors = (response.standard_error if response else None for response in found)
        values[error] = [_number(error) for error in errors]
    return RunColumns(records, values, parameters, responses)


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
        raise InputError(messages.NO_RUN.fault("", identity=identity, store=store.place))
    some = ", ".join(found[:_NAMED_RUNS]) + (", ..." if len(found) > _NAMED_RUNS else "")
    raise InputError(
        messages.SEVERAL_RUNS.fault("", identity=identity, count=len(found), some=some)
    )


def laboratory_of(store: RunStore) -> Mapping[str, Any]:
    """Return the definitions of tests of which the latest calibration simulates a smaller one."""
    latest = store.latest_calibration()
    about = {} if latest is None else latest.about
    return Provenance.from_json(about.get("provenance", {})).laboratory


def _common_columns(
    records: Sequence[RunRecord], laboratory: Mapping[str, Any]
) -> dict[str, list[Any]]:
    own = ("status", "kind", "reason", "origin")
    models = [record.definition.model for record in records]
    return {
        "identity": [_text(record.identity) for record in records],
        "test": [_test_of(record, laboratory) for record in records],
        **{name: [_text(getattr(record, name)) for record in records] for name in own},
        **{name: [_text(model.get(name)) for model in models] for name in ("solver", "version")},
        "seed": [_seed(record.definition.seed) for record in records],
        "seconds": [_number(record.seconds) for record in records],
        "ended": [_moment(record.ended) for record in records],
    }


def _test_of(record: RunRecord, laboratory: Mapping[str, Any]) -> str:
    real = laboratory.get(record.test)
    is_smaller = real is not None and record.definition.model.get("test") != real
    return f"{_text(record.test)}{_SMALLER}" if is_smaller else _text(record.test)


def _number(value: float | None) -> float | None:
    return None if value is None else float(value)


def _seed(seed: int) -> int | None:
    return seed if abs(seed) < _SEED_LIMIT else None


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
    from grainfit.bulk_tests.registry import class_of_test

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
