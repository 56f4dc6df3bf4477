"""Photographs that are others than those with which the calibration was begun."""

from __future__ import annotations

from collections.abc import Iterator

from grainfit.calibration_file.checks.context import FileContext
from grainfit.checks import Found, check


@check("changed-picture", "warning")
def changed_picture(context: FileContext) -> Iterator[Found]:
    """Photographs that moved, changed, or are missing since the calibration was begun."""
    for target in context.file.photographs:
        for text in target.changes:
            yield target.key, text
