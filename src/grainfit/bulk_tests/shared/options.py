"""Kinds and descriptions of options that several bulk tests share."""

from __future__ import annotations

from typing import Any

from grainfit.bulk_tests.base import GRAVITY, LOWEST_GRAVITY
from grainfit.options.fields import Derived, option
from grainfit.options.kinds import Quantity

LENGTH = Quantity("m", above_zero=True, highest=1e3)
TIME = Quantity("s", above_zero=True)
STRESS = Quantity("Pa", above_zero=True, highest=1e12)

#: Height of a bed that is not struck off.
FILL_HEIGHT = "Height of the bed at a solid fraction of 0.58; it gives the number of particles."
SLOT_WIDTH = "Width of the slot. The mass flow depends on it strongly: use that of the laboratory."
#: Time limit of tests with a door in the floor.
FLOW_TIME_LIMIT = (
    "Longest simulated time in which the bed, and after the flow all particles, may come to rest."
)


def settling_option(what: str = "the bed") -> Any:
    """Return the option of the longest time in which something may come to rest."""
    return option(
        TIME,
        f"Longest simulated time in which {what} may come to rest.",
        example='"2 s"',
        default=Derived("ten times the time of fall", lambda s: s.filling.settling_time_limit),
    )


def laboratory_gravity_option(verb: str) -> Any:
    """Return the option of the gravity of a laboratory whose bed has none where it is simulated."""
    return option(
        Quantity("m/s^2", lowest=LOWEST_GRAVITY),
        f"Gravity of the laboratory, which the default stress follows; the {verb} bed has none.",
        example="9.81",
        default=GRAVITY,
    )
