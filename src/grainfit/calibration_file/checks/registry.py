"""All checks, and what they find in a calibration file."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import replace
from typing import Any

from grainfit.analysis.long_runs import long_runs
from grainfit.analysis.soft_particles import soft_particles
from grainfit.bulk_tests.base import BulkTest
from grainfit.bulk_tests.checks import CheckedTest
from grainfit.bulk_tests.registry import OWN_SCENE, bulk_tests
from grainfit.calibration_file.checks.assumed_size import assumed_size
from grainfit.calibration_file.checks.context import FileContext
from grainfit.calibration_file.checks.few_particles import few_particles
from grainfit.calibration_file.checks.fine_tolerances import fine_tolerance
from grainfit.calibration_file.checks.instruments import finer_than_instruments
from grainfit.calibration_file.checks.large_time_step import large_time_step
from grainfit.calibration_file.checks.near_spheres import near_spheres
from grainfit.calibration_file.checks.photographs import changed_picture, other_speed
from grainfit.calibration_file.checks.run_times import (
    long_calibration,
    more_ranks,
    mpi_ranks,
    short_timeout,
)
from grainfit.calibration_file.checks.same_simulation import repeated_simulation, shared_simulation
from grainfit.calibration_file.checks.solid_fractions import impossible_bulk_density
from grainfit.calibration_file.checks.targets import too_few_targets
from grainfit.calibration_file.checks.unusual_values import unusual_value
from grainfit.checks import Check, Finding
from grainfit.contact_models.checks import solvers_differ
from grainfit.which_test.open_parameters import further_response, open_parameters

#: In the order of their findings; those of the bulk tests themselves come in between.
_BEFORE_TESTS: tuple[Check[FileContext], ...] = (
    too_few_targets,
    open_parameters,
    soft_particles,
    solvers_differ,
    large_time_step,
    long_runs,
    shared_simulation,
    repeated_simulation,
    few_particles,
    assumed_size,
    near_spheres,
    impossible_bulk_density,
    unusual_value,
    changed_picture,
    other_speed,
)
_AFTER_TESTS: tuple[Check[FileContext], ...] = (
    finer_than_instruments,
    fine_tolerance,
    short_timeout,
    mpi_ranks,
    more_ranks,
    long_calibration,
    further_response,
)


def all_checks() -> tuple[Check[Any], ...]:
    """Return every check, each name once, in the order of their findings."""
    of_tests = _checks_of((*bulk_tests().values(), OWN_SCENE))
    found: list[Check[Any]] = [*_BEFORE_TESTS, *of_tests, *_AFTER_TESTS]
    return tuple({check.name: check for check in found}.values())


def findings(context: FileContext) -> Iterator[Finding]:
    """Yield what the checks find in a calibration file."""
    for check in _BEFORE_TESTS:
        yield from check(context)
    for name in dict.fromkeys(check.name for check in _checks_of(context.bulk_tests.values())):
        yield from _of_tests(name, context)
    for check in _AFTER_TESTS:
        yield from check(context)


def _checks_of(tests: Iterable[BulkTest | type[BulkTest]]) -> Iterator[Check[CheckedTest[Any]]]:
    for test in tests:
        yield from test.checks


def _of_tests(check_name: str, context: FileContext) -> Iterator[Finding]:
    """Yield what the checks of one name find in all tests."""
    for name, test in context.bulk_tests.items():
        targets = context.targets_of(name)
        walls = context.solvers[name].walls
        of_instrument = next((t.of_instrument for t in context.file.tests if t.name == name), ())
        checked = CheckedTest(test, context.lowest, context.highest, targets, walls, of_instrument)
        for check in test.checks:
            if check.name == check_name:
                for found in check(checked):
                    key = context.key(name, found.key)
                    yield replace(found, text=f"Test {name}: {found.text}", key=key)
