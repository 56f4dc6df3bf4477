"""Photographs and videos that are others than at the beginning, or of another test."""

from __future__ import annotations

from collections.abc import Iterator

from grainfit.calibration_file import messages
from grainfit.calibration_file.checks.context import FileContext
from grainfit.checks import Found, check
from grainfit.formatting import turns_per_minute

#: Share by which speeds differ at least, and by so many standard errors.
_DIFFERENT, _ERRORS = 0.05, 3.0


@check("changed-picture", "warning")
def changed_picture(context: FileContext) -> Iterator[Found]:
    """Pictures and videos that moved, changed, or are missing since the calibration was begun."""
    for target in context.file.photographs:
        for text in target.changes:
            yield target.key, text


@check("other-speed", "warning")
def other_speed(context: FileContext) -> Iterator[Found]:
    """A video in which the drum turns at another speed than in the simulated test."""
    for _, target in context.file.photographed:
        test = next((t.name for t in context.file.tests if t.number == target.test), "")
        if target.speed is None or test not in context.bulk_tests:
            continue
        found, error = target.speed
        given = context.bulk_tests[test].resolved_options()["rotational_speed"]
        if abs(found - given) > max(_DIFFERENT * given, _ERRORS * error):
            said = {"found": turns_per_minute(found), "given": turns_per_minute(given)}
            yield target.key, messages.OTHER_SPEED(**said)
