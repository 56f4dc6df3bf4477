"""A check of the end caps of a drum: a wall is named for caps that it does not have."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from grainfit.bulk_tests.checks import CheckedTest
from grainfit.bulk_tests.drum import messages
from grainfit.checks import Found, check


@check("no-end-caps", "warning")
def no_end_caps(checked: CheckedTest[Any]) -> Iterator[Found]:
    """Drums without end caps in a file that says what these are made of."""
    wall = checked.walls.get("caps")
    if wall and not checked.test.end_caps:
        yield "end_caps", messages.NO_END_CAPS(wall=wall)
