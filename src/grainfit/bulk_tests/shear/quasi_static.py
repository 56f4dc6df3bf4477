"""A check of the shear rate: the angle of internal friction grows with the inertial number."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from grainfit.bulk_tests.checks import CheckedTest
from grainfit.bulk_tests.shear import messages
from grainfit.checks import Found, check

#: Inertial number up to which shear is quasi-static within the scatter of the angle.
_SLOWEST = 0.01


@check("fast-shear")
def fast_shear(checked: CheckedTest[Any]) -> Iterator[Found]:
    """Shear that is not quasi-static, as that of a shear tester is."""
    number = float(checked.test.inertial_number)
    if number > _SLOWEST:
        yield "inertial_number", messages.FAST_SHEAR(number=number, slowest=_SLOWEST)
