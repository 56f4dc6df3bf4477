"""A check of the contact law: without cohesion there is no strength to fit."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from grainfit.bulk_tests.checks import CheckedTest
from grainfit.bulk_tests.shear_cell import messages
from grainfit.checks import Found, check
from grainfit.contact_models.registry import COHESION
from grainfit.materials.walls import plain_name

_STRENGTHS = ("ffc", "unconfined_strength", "cohesion")


@check("no-cohesion", "warning")
def no_cohesion(checked: CheckedTest[Any]) -> Iterator[Found]:
    """Strength of a powder as a target, and a contact law without cohesion."""
    if any(value for name, value in checked.highest.items() if plain_name(name) in COHESION):
        return
    wanted = [name for name in _STRENGTHS if checked.targets.get(name)]
    if wanted:
        yield f"targets.{wanted[0]}", messages.NO_COHESION()
