"""Names of the responses and runs of a calibration with several tests, or several seeds."""

from __future__ import annotations

import re
from collections.abc import Iterable

from grainfit.relative_names import is_relative

#: Column of a response's standard error in tables of runs: after the name of the response.
ERROR_SUFFIX = ".standard_error"
#: Name under which a failure is kept that came without the name of a test.
ALL_RUNS = "run"
_FURTHER_SEED = re.compile(r", seed \d+$")


def response_name(test: str, name: str, tests: int) -> str:
    """Return the name of a test's response in a calibration with this number of tests."""
    return name if tests == 1 else f"{test}.{name}"


def run_name(test: str, number: int) -> str:
    """Return the name of the numbered run of an evaluation: that of its test for the first.

    Examples
    --------
    >>> run_name("heap", 1), run_name("heap", 2)
    ('heap', 'heap, seed 2')
    """
    return test if number == 1 else f"{test}, seed {number}"


def name_of_test(run: str) -> str:
    """Return the test of a `run_name`.

    Examples
    --------
    >>> name_of_test("heap, seed 2")
    'heap'
    """
    return _FURTHER_SEED.sub("", run)


def names_of_tests(runs: Iterable[str]) -> tuple[str, ...]:
    """Return the tests of some runs by their names, each once."""
    return tuple(dict.fromkeys(map(name_of_test, runs)))


def tests_asked(runs: Iterable[str], tests: int) -> tuple[str, ...] | None:
    """Return the tests that a proposal asked for, by its runs; None for all of so many tests."""
    asked = names_of_tests(runs)
    return None if len(asked) == tests and not any(map(is_relative, asked)) else asked
