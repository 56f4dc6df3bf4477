"""Checks of a measured mass flow: through which depth, and how far from Beverloo's law."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from grainfit.bulk_tests.checks import CheckedTest
from grainfit.bulk_tests.parameter_names import DENSITY
from grainfit.bulk_tests.shared import messages
from grainfit.checks import Found, check
from grainfit.formatting import millimetres

#: A measured flow that many times less or more than Beverloo's law is due to a unit or a slip.
#: Arches and cohesion make flows small; nothing makes them large.
_LESS, _MORE = 10.0, 4.0


@check("flow-depth", "warning")
def flow_depth(checked: CheckedTest[Any]) -> Iterator[Found]:
    """Measured flows through a slot whose depth the file does not give."""
    test = checked.test
    depth = test.setup.option("depth")
    if "mass_flow" in checked.targets and test.depth is None and depth is not None:
        yield "targets.mass_flow", messages.FLOW_DEPTH(depth=millimetres(depth))


@check("unusual-flow", "warning")
def unusual_flow(checked: CheckedTest[Any]) -> Iterator[Found]:
    """Measured flows a tenth of, or four times, what Beverloo's law gives."""
    measured, setup = checked.targets.get("mass_flow"), checked.test.setup
    if not measured or DENSITY not in checked.lowest:
        return
    low, high = (ends[DENSITY] * setup.beverloo_flow for ends in (checked.lowest, checked.highest))
    if not low / _LESS <= measured <= high * _MORE:
        expected = (low * high) ** 0.5
        yield (
            "targets.mass_flow",
            messages.UNUSUAL_FLOW(measured=measured, times=measured / expected, expected=expected),
        )
