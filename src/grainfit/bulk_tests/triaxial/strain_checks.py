"""Checks of a triaxial test before any run: its strain rate and its strain."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from grainfit.bulk_tests.checks import CheckedTest
from grainfit.bulk_tests.triaxial import messages
from grainfit.checks import Found, check

#: Inertial number up to which compression is quasi-static within the scatter of the angles.
_SLOWEST = 0.003
#: Strain up to which dense and loose beds of spheres come to one critical state within two standard
#: errors; up to 0.35 dense ones still had 1.2 degrees more (benchmarks/triaxial.py).
_CRITICAL = 0.45


@check("fast-compression", "warning")
def fast_compression(checked: CheckedTest[Any]) -> Iterator[Found]:
    """Compression that is not quasi-static, as that of a triaxial cell is."""
    number = float(checked.test.inertial_number)
    if number > _SLOWEST:
        yield "inertial_number", messages.FAST_COMPRESSION(number=number, slowest=_SLOWEST)


@check("short-compression", "warning")
def short_compression(checked: CheckedTest[Any]) -> Iterator[Found]:
    """Compression that may end before the critical state, where its angle is a target."""
    strain = float(checked.test.axial_strain)
    if strain < _CRITICAL and "critical_friction_angle" in checked.targets:
        yield "axial_strain", messages.SHORT_COMPRESSION(strain=strain, least=_CRITICAL)
