"""Particle sizes in the plan of a calibration: what the classes are, and what the finest costs."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from grainfit.bulk_tests.abilities import user_functions
from grainfit.bulk_tests.base import BulkTest
from grainfit.bulk_tests.workload import workload
from grainfit.errors import InputError
from grainfit.formatting import millimetres, percent
from grainfit.materials.sizes import ParticleSizes
from grainfit.solvers.speed import Speed

#: Share of the time of a run above which the price of particles is not stated.
_HARDLY_FASTER = 0.8
#: Share of the mass, in the finest particles, of which the price is stated.
_FINEST = 0.05
#: Only ratios of times are shown, which are the same at any speed.
_ANY_SPEED = Speed(1.0)


def size_lines(
    sizes: ParticleSizes | None, bulk_tests: Mapping[str, BulkTest], material: Mapping[str, float]
) -> Iterator[str]:
    """Yield the particle sizes and the price of the finest ones, in words.

    Parameters
    ----------
    sizes : ParticleSizes, optional
        Of the particles; nothing is yielded for a single diameter.
    bulk_tests : mapping of str to BulkTest
        Simulated tests by name.
    material : mapping of str to float
        Material parameters by dotted name, in the middle of their intervals.
    """
    if sizes is None or len(sizes.diameters) == 1:
        return
    if sizes.origin is not None:
        yield from sizes.origin.describe(sizes.real)
    tests = [test for test in bulk_tests.values() if not user_functions(test)]
    if tests:
        yield from _price(sizes, tests, material)


def _price(
    sizes: ParticleSizes, tests: list[BulkTest], material: Mapping[str, float]
) -> Iterator[str]:
    try:
        whole = _seconds(tests, material)
        finest = min(range(len(sizes.diameters)), key=lambda i: sizes.diameters[i])
        share = _seconds(_with_sizes(tests, sizes.without(finest)), material) / whole
        if share > _HARDLY_FASTER:
            return
        yield (
            f"  The finest class, {millimetres(sizes.real.diameters[finest])}, has "
            f"{percent(sizes.mass_fractions[finest])} of the mass and "
            f"{percent(sizes.number_fractions[finest])} of the particles, and sets the time step: "
            f"without it, a run would take {share:.2g} of the time."
        )
        if sizes.origin is not None:
            limit, rest = sizes.origin.without_finest(_FINEST)
            rest = rest.coarse_grained(sizes.coarse_graining)
            share = _seconds(_with_sizes(tests, rest), material) / whole
            yield (
                f'  With smallest = "{1000 * limit:.3g} mm", which leaves out '
                f"{'another' if sizes.origin.is_cut_below else 'the finest'} {percent(_FINEST)} of "
                f"the mass, it would take {share:.2g} of the time."
            )
    except InputError:
        # A test that is impossible with other sizes has no price.
        return


def _with_sizes(tests: list[BulkTest], sizes: ParticleSizes) -> list[BulkTest]:
    return [test.with_sizes(sizes) for test in tests]


def _seconds(tests: list[BulkTest], material: Mapping[str, float]) -> float:
    """Return the estimated time of a run of each test; only ratios have a meaning."""
    return sum(_ANY_SPEED.cost(workload(test, material)).wall_seconds for test in tests)
