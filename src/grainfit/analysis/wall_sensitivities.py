"""Recorded sensitivities of tests whose parts are made of walls with a name.

The trials varied the friction of all parts together, but for parts that had one of their own.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import fields, replace

from grainfit.bulk_tests.base import ResponseInfo
from grainfit.bulk_tests.sensitivities import WALL_SLIDING
from grainfit.materials.walls import PLAIN, on_wall
from grainfit.solvers.base import Solver


def on_walls(info: ResponseInfo, solver: Solver) -> ResponseInfo:
    """Return a response whose sensitivities have the names of the walls of a test.

    The sensitivity to walls is that to the wall of the first part, which most particles touch.

    Parameters
    ----------
    info : ResponseInfo
        The response.
    solver : Solver
        Of its test.
    """
    test, known = solver.bulk_test, info.sensitivities
    if known is None or test is None or not test.parts:
        return info
    wall = solver.walls.get(next(iter(test.parts)), PLAIN)

    def named(slopes: Mapping[str, float]) -> dict[str, float]:
        return {on_wall(name, wall): slope for name, slope in slopes.items()}

    own = replace(
        known,
        slopes=named(known.slopes),
        slopes_at_high_rolling=named(known.slopes_at_high_rolling),
    )
    return replace(info, sensitivities=own)


def without_sensitivities(solver: Solver) -> set[str]:
    """Return parameters of walls whose effect on a test is not known: no trial varied them."""
    test = solver.bulk_test
    if test is None or not solver.walls:
        return set()
    defaults = {field.name: field.default for field in fields(test)}
    # A part whose friction is by default that of the walls was varied with them.
    apart = [p for p, own in test.own_friction.items() if any(defaults[o] is not None for o in own)]
    return {on_wall(WALL_SLIDING, solver.walls[part]) for part in apart if part in solver.walls}
