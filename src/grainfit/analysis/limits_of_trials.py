"""Limits of the recorded sensitivities: parameters and particles that no trial had."""

from __future__ import annotations

from collections.abc import Collection, Mapping

from grainfit.analysis.further_tests import BETTER_FIXED
from grainfit.analysis.wall_sensitivities import without_sensitivities
from grainfit.bulk_tests.sensitivities import VARIED
from grainfit.contact_models.registry import COHESION
from grainfit.materials.walls import plain_name
from grainfit.solvers.base import Solver


def unrecorded_effects(
    solvers: Mapping[str, Solver], free: Collection[str]
) -> dict[str, list[str]]:
    """Return the tests on which the effect of a free parameter is not recorded, by parameter.

    Parameters
    ----------
    solvers : mapping of str to Solver
        By name of the test.
    free : collection of str
        Names of free parameters.
    """
    known = {*VARIED, *BETTER_FIXED}
    without = {test: without_sensitivities(solver) for test, solver in solvers.items()}
    found = {
        name: [t for t, own in without.items() if name in own or plain_name(name) not in known]
        for name in free
    }
    return {name: tests for name, tests in found.items() if tests}


def are_dry_spheres(solvers: Mapping[str, Solver], material: Mapping[str, float]) -> bool:
    """Return whether particles are spheres without cohesion, as those of the trials.

    Parameters
    ----------
    solvers : mapping of str to Solver
        By name of the test.
    material : mapping of str to float
        Values by dotted name.
    """
    tests = [solver.bulk_test for solver in solvers.values() if solver.bulk_test]
    are_clumps = any(test.sizes.shape is not None for test in tests)
    is_cohesive = any(value for name, value in material.items() if plain_name(name) in COHESION)
    return not are_clumps and not is_cohesive
