"""Kinds and descriptions of options that several bulk tests share."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from grainfit.bulk_tests.base import GRAVITY, LOWEST_GRAVITY
from grainfit.bulk_tests.shared.filling import least_radius
from grainfit.options.fields import Derived, option
from grainfit.options.kinds import Quantity

LENGTH = Quantity("m", above_zero=True, highest=1e3)
TIME = Quantity("s", above_zero=True)
STRESS = Quantity("Pa", above_zero=True, highest=1e12)

#: Height of a bed that is not struck off.
FILL_HEIGHT = "Height of the bed at a solid fraction of 0.58; it gives the number of particles."
SLOT_WIDTH = "Width of the slot. The mass flow depends on it strongly: use that of the laboratory."


def settling_option(what: str = "the bed") -> Any:
    """Return the option of the longest time in which something may come to rest."""
    return option(
        TIME,
        f"Longest simulated time in which {what} may come to rest.",
        example='"2 s"',
        default=Derived("ten times the time of fall", lambda s: s.filling.settling_time_limit),
    )


def flow_settling_option(example: str, times: str, what: str = "all particles") -> Any:
    """Return the option of the longest time in which a bed that flows out may come to rest."""
    return option(
        TIME,
        f"Longest simulated time in which the bed, and after the flow {what}, may come to rest.",
        example=example,
        default=Derived(f"{times} times the expected time of the flow", lambda s: s.usual_limit),
    )


def length_option(name: str, diameters: float, what: str) -> Any:
    """Return the option of a length of an apparatus whose setup knows the usual ones."""
    return option(
        LENGTH,
        what,
        example=f'"{10 * diameters:g} mm"',
        default=Derived(f"{diameters:g} d", lambda s: s.usual(name, diameters)),
    )


def cylinder_option(what: str, diameters: int) -> Any:
    """Return the option of the radius of a cylinder; the default holds the largest particles."""
    return option(
        LENGTH,
        f"Inner radius of the {what}.",
        example=f'"{10 * diameters} mm"',
        default=Derived(f"{diameters} d", lambda s: max(diameters * s.d, least_radius(s.real))),
    )


def density_bottom_option() -> Any:
    """Return the option of the height from which on a bulk density is measured."""
    return option(
        LENGTH,
        "The bulk density is measured from this height on.",
        example='"10 mm"',
        default=Derived("1 d", lambda s: s.d),
    )


def density_top_option(text: str, default: Callable[[Any], float]) -> Any:
    """Return the option of the height up to which a bulk density is measured."""
    return option(
        LENGTH,
        "The bulk density is measured up to this height.",
        example='"90 mm"',
        default=Derived(text, default),
    )


def laboratory_gravity_option(verb: str) -> Any:
    """Return the option of the gravity of a laboratory whose bed has none where it is simulated."""
    return option(
        Quantity("m/s^2", lowest=LOWEST_GRAVITY),
        f"Gravity of the laboratory, which the default stress follows; the {verb} bed has none.",
        example="9.81",
        default=GRAVITY,
    )
