"""Larger particles in the apparatus of a test, and how a calibration file asks for them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any, TypeVar

from grainfit.bulk_tests.abilities import material_faults
from grainfit.bulk_tests.base import BulkTest
from grainfit.errors import InputError
from grainfit.materials.sizes import ParticleSizes

_Test = TypeVar("_Test", bound=BulkTest)


def coarse_grained(test: _Test, factor: float, material: Mapping[str, float]) -> _Test:
    """Return a test with larger particles, fewer where their number is an option.

    Parameters
    ----------
    test : BulkTest
        Stays as it is.
    factor : float
        Times the present diameters.
    material : mapping of str to float
        Material parameters by dotted name.

    Raises
    ------
    InputError
        The test is impossible with them; names every option at fault.
    """
    sizes = test.sizes.coarse_grained(factor)
    count = _given_number(test)
    if count is None:
        coarser = test.with_sizes(sizes)
    else:
        definition = {**test.definition(), **sizes.definition()}
        fewer = max(1, round(count / factor**3))
        coarser = test.from_definition({**definition, "particle_count": fewer})
    InputError.raise_for(material_faults(coarser, material))
    return coarser


def sized_for(kind: type[_Test], sizes: ParticleSizes, **options: Any) -> _Test:
    """Return a test of which there is no apparatus yet: its defaults suit the simulated particles.

    Parameters
    ----------
    kind : type
        Class of the test.
    sizes : ParticleSizes
        Its particles.
    **options : object
        Options that are given.

    Raises
    ------
    InputError
        The test is impossible with them; names every option at fault.
    """
    if sizes.coarse_graining == 1:
        return kind(sizes, **options)
    usual = kind(replace(sizes, coarse_graining=1.0), **options)
    return kind(sizes, **usual.resolved_options())


def factor_words(tests: Mapping[str, BulkTest]) -> str:
    """Return the entries of a calibration file that make its particles those of tests.

    Parameters
    ----------
    tests : mapping of str to BulkTest
        By name, all with the same particles.
    """
    [factor, *_] = {test.sizes.coarse_graining for test in tests.values()}
    numbers = {name: _given_number(test) for name, test in tests.items()}
    return " and ".join(
        [
            f"particle.coarse_graining = {factor:g}",
            *(f"particle_count = {n} in test {name}" for name, n in numbers.items() if n),
        ]
    )


def _given_number(test: BulkTest) -> int | None:
    count: int | None = getattr(test, "particle_count", None)
    return count
