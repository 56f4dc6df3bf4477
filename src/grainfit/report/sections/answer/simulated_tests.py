"""Geometry, speeds and procedure of the bulk tests, as they were simulated."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass

from grainfit.bulk_tests.apparatus import apparatus_of, shown_value
from grainfit.bulk_tests.base import BulkTest
from grainfit.formatting import plain


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


def simulated_tests(
    tests: Mapping[str, BulkTest], given: Mapping[str, Collection[str]]
) -> list[SimulatedTest]:
    """Return the options of every bulk test, defaults included.

    Parameters
    ----------
    tests : mapping of str to BulkTest
        By name.
    given : mapping of str to collection of str
        Options that were given, by name of the test, where that is known.
    """
    return [
        SimulatedTest(plain(name), list(_options(test, given.get(name))))
        for name, test in tests.items()
    ]


def _options(test: BulkTest, given: Collection[str] | None) -> Iterator[tuple[str, str, str, str]]:
    values = test.resolved_options()
    origins = {value.name: value.origin for value in apparatus_of(test, given)}
    for key in test.option_keys():
        shown = shown_value(key, values.get(key.name))
        if shown:
            yield (
                key.name,
                key.in_words().description.partition(". ")[0].rstrip("."),
                shown,
                origins.get(key.name, ""),
            )
