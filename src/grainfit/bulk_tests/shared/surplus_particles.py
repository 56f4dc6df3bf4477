"""Particles that are rained in only to be cut off above the strike-off height."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import Any

from grainfit.bulk_tests.checks import CheckedTest
from grainfit.bulk_tests.shared import messages
from grainfit.checks import Found, check
from grainfit.errors import InputError
from grainfit.formatting import millimetres

#: Numbers above this many times the usual one are noted.
_FAR_TOO_MANY = 1.5


@check("surplus-particles")
def surplus_particles(checked: CheckedTest[Any]) -> Iterator[Found]:
    """Particles that are rained in only to be cut off above the strike-off height."""
    given = checked.test.particle_count
    if given is None:
        return
    try:
        usual = replace(checked.test, particle_count=None)
    except InputError:
        # The given number is small enough to compute, the usual one is not.
        return
    if given > _FAR_TOO_MANY * usual.number_of_particles:
        yield (
            "particle_count",
            messages.SURPLUS_PARTICLES(
                given=given,
                needed=usual.number_of_particles,
                height=millimetres(usual.setup.strike_off_height),
            ),
        )
