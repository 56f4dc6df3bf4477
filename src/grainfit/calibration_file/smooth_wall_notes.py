"""Notes on walls so smooth that particles roll on them for longer than a test waits."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from grainfit.bulk_tests.base import BulkTest
from grainfit.materials.walls import plain_name
from grainfit.problem import Problem

_ROLLING = "particle_wall.rolling_friction"


def smooth_wall_notes(
    problem: Problem, bulk_tests: Mapping[str, BulkTest], fixed: Mapping[str, float]
) -> Iterator[str]:
    """Yield a note on each test whose beds may never rest, because a wall hardly brakes rolling.

    Parameters
    ----------
    problem : Problem
        Free parameters.
    bulk_tests : mapping of str to BulkTest
        Simulated tests by name.
    fixed : mapping of str to float
        Material parameters that are not free.
    """
    lowest = {**fixed, **{p.name: p.minimum for p in problem.parameters}}
    smooth = {name: value for name, value in lowest.items() if plain_name(name) == _ROLLING}
    for name, test in bulk_tests.items():
        least = test.least_wall_rolling_friction
        for key, value in smooth.items():
            if value < least:
                yield (
                    f"Test {name}: with {key} = {value:g}, particles roll on its walls for long, "
                    "so that runs may fail because the bed does not come to rest. Give "
                    f"{least:g} or more if your apparatus is not that smooth, or a longer "
                    "settling_time_limit."
                )
