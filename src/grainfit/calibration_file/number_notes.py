"""Notes on particles that are rained in only to be cut off above the strike-off height."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace

from grainfit.bulk_tests.base import BulkTest
from grainfit.errors import InputError
from grainfit.formatting import millimetres

#: Numbers above this many times the usual one are noted.
_FAR_TOO_MANY = 1.5


def number_notes(bulk_tests: Mapping[str, BulkTest]) -> Iterator[str]:
    """Yield a note on each test whose ``particle_count`` is far more than it keeps.

    Parameters
    ----------
    bulk_tests : mapping of str to BulkTest
        Simulated tests by name.
    """
    for name, test in bulk_tests.items():
        given = getattr(test, "particle_count", None)
        if given is None:
            continue
        try:
            usual = replace(test, particle_count=None)  # type: ignore[call-arg]
        except InputError:
            # The given number is small enough to compute, the usual one is not.
            continue
        if given <= _FAR_TOO_MANY * usual.number_of_particles:
            continue
        height = millimetres(usual.resolved_options()["strike_off_height"])
        yield (
            f"Test {name}: particle_count = {given}, but {usual.number_of_particles} fill it up to "
            f"strike_off_height ({height}); the rest is cut off there, before anything is "
            "measured. Leave particle_count out, or raise strike_off_height."
        )
