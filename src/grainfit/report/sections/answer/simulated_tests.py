"""Geometry, speeds and procedure of the bulk tests, as they were simulated."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from grainfit.bulk_tests.apparatus import apparatus_of
from grainfit.bulk_tests.base import BulkTest
from grainfit.formatting import in_usual_unit, plain
from grainfit.options.tables import Key

_DIGITS = 4


@dataclass(frozen=True)
class SimulatedTest:
    """Options of one test: names, meanings, values with units, and which of them are assumed.

    Parameters
    ----------
    name : str
        Of the test in the calibration file.
    options : sequence of tuple of str
        Rows of a table.
    """

    name: str
    options: Sequence[tuple[str, str, str, str]]


def simulated_tests(tests: Mapping[str, BulkTest]) -> list[SimulatedTest]:
    """Return the options of every bulk test, defaults included."""
    return [SimulatedTest(plain(name), list(_options(test))) for name, test in tests.items()]


def _options(test: BulkTest) -> Iterator[tuple[str, str, str, str]]:
    values = test.resolved_options()
    origins = {value.name: value.origin for value in apparatus_of(test)}
    for key in test.option_keys():
        shown = _shown(key, values.get(key.name))
        if shown:
            yield (
                key.name,
                key.description.partition(". ")[0].rstrip("."),
                shown,
                origins.get(key.name, ""),
            )


def _shown(key: Key, value: Any) -> str:
    """Return a value with its unit; "" for one that is not set."""
    if value is None:
        return ""
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, int | float):
        return in_usual_unit(float(value), str(getattr(key.kind, "unit", "") or ""), _DIGITS)
    if isinstance(value, list | tuple):
        return ", ".join(filter(None, (_shown(key, one) for one in value)))
    return plain(str(value))
