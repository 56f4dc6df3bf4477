"""A check of the number of taps: after few of them a bed is looser than after many."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from grainfit.bulk_tests.checks import CheckedTest
from grainfit.bulk_tests.tapped import messages
from grainfit.checks import Found, check

#: Taps after which pharmacopoeias read the first tapped volume (USP chapter 616: 500, then 1250).
_USUAL = 500


@check("few-taps", "warning")
def few_taps(checked: CheckedTest[Any]) -> Iterator[Found]:
    """Fewer taps than a laboratory gives, where the tapped density is a target."""
    taps = checked.test.setup.taps
    if taps < _USUAL and {"tapped_density", "hausner_ratio"} & checked.targets.keys():
        yield "taps", messages.FEW_TAPS(taps=taps, usual=_USUAL)
