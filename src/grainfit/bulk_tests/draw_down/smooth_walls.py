"""Walls so smooth that particles roll on them for longer than a draw-down test waits."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from grainfit.bulk_tests.checks import CheckedTest
from grainfit.checks import Found, check
from grainfit.materials.walls import plain_name

#: At a rolling friction of 0.005, beds roll off the shelf one by one for more than 7 s.
_LEAST = 0.02


@check("smooth-walls", "warning")
def smooth_walls(checked: CheckedTest[Any]) -> Iterator[Found]:
    """Walls so smooth that particles roll on them for longer than the test waits."""
    for key, value in checked.lowest.items():
        if plain_name(key) == "particle_wall.rolling_friction" and value < _LEAST:
            yield (
                key,
                f"with {key} = {value:g}, particles roll on its walls for long, so that runs may "
                f"fail because the bed does not come to rest. Give {_LEAST:g} or more if your "
                "apparatus is not that smooth, or a longer settling_time_limit.",
            )
