"""Checks of the plate: too small for the measured heap, or too smooth for any heap."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

from grainfit.bulk_tests.checks import CheckedTest
from grainfit.bulk_tests.heap import messages
from grainfit.bulk_tests.response_info import absent_responses
from grainfit.bulk_tests.shared.part_friction import AS_PARTICLES
from grainfit.checks import Found, check
from grainfit.formatting import in_a_row, millimetres
from grainfit.materials.walls import PLAIN, on_wall

#: An angle of which there is no cone, degrees.
_STEEPEST = 90.0
#: Glass beads and rough spheres of 10 mm make no heap at a sliding friction of 0.1 and of 0.15;
#: without rolling friction glass beads roll on, and rough spheres make a heap of 10 degrees.
_LEAST = {"sliding": 0.2, "rolling": 0.02}


@check("small-plate", "warning")
def small_plate(checked: CheckedTest[Any]) -> Iterator[Found]:
    """Plates that are too small for the measured heap, whose size is needed."""
    setup, diameter = checked.test.setup, checked.test.sizes.sauter_diameter
    needed = [name for name in absent_responses(checked.test) if name in checked.targets]
    angle, radius = (checked.targets.get(name) for name in ("angle_of_repose", "base_radius"))
    if not needed or setup.rim_height > 0:
        return
    if radius is None and angle is not None and 0 < angle < _STEEPEST:
        radius = setup.expected_foot(angle, diameter)
    if radius is not None and radius > setup.plate_radius - diameter:
        yield (
            "plate_radius",
            f"the plate of {millimetres(setup.plate_radius)} radius is too small for "
            f"{in_a_row(needed)}: the measured heap has a base radius of about "
            f"{millimetres(radius)}, and a run whose heap reaches the edge fails. Use "
            f'plate_radius = "{millimetres(radius + 3 * diameter)}" or more.',
        )


@check("smooth-plate", "warning")
def smooth_plate(checked: CheckedTest[Any]) -> Iterator[Found]:
    """Plates so smooth that heaps slide or roll apart."""
    if checked.test.sizes.shape is not None:
        return
    wall = checked.walls.get("plate", PLAIN)
    for kind, least in _LEAST.items():
        option = f"plate_{kind}_friction"
        given = getattr(checked.test, option)
        between = f"particle_particle.{kind}_friction"
        of_wall = on_wall(f"particle_wall.{kind}_friction", wall)
        key = {None: of_wall, AS_PARTICLES: between}.get(given, option)
        value = checked.lowest.get(key, given)
        if isinstance(value, (int, float)) and value < least:
            yield (
                option,
                messages.SMOOTH_PLATE(kind=kind, value=value, key=key, least=least, option=option),
            )


@check("assumed-plate", "warning")
def assumed_plate(checked: CheckedTest[Any]) -> Iterator[Found]:
    """Plates as smooth as the walls, because the file gives no friction, below a measured heap."""
    angle = checked.targets.get("angle_of_repose")
    if checked.test.sizes.shape is not None or not angle or angle >= _STEEPEST:
        return
    wall = checked.walls.get("plate", PLAIN)
    least = {
        "sliding": math.tan(math.radians(angle)),
        "rolling": checked.lowest.get("particle_particle.rolling_friction", 0.0),
    }
    for kind, needed in least.items():
        option = f"plate_{kind}_friction"
        highest = checked.highest.get(on_wall(f"particle_wall.{kind}_friction", wall))
        if getattr(checked.test, option) is not None or highest is None:
            continue
        if _LEAST[kind] <= highest < needed:
            yield option, messages.ASSUMED_PLATE(kind=kind, value=highest, option=option)
