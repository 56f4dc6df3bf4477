"""A round plate that carries a heap: its walls and options, and its checks.

It is checked whether it is too small for the measured heap, or too smooth for any heap.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from typing import Any

from grainfit.bulk_tests.checks import CheckedTest
from grainfit.bulk_tests.response_info import absent_responses
from grainfit.bulk_tests.shared import messages
from grainfit.bulk_tests.shared.part_friction import AS_PARTICLES, friction_option
from grainfit.checks import Found, check
from grainfit.formatting import in_a_row, millimetres
from grainfit.materials.walls import PLAIN, on_wall
from grainfit.options.fields import Amount, option
from grainfit.options.kinds import Choice, Quantity, Whole
from grainfit.scenes.scene import WALL, Wall
from grainfit.scenes.shapes import Cylinder, Disc

#: Surface of plate and rim, when it is another one than that of the walls.
PLATE = "plate"
#: What a heap lies on: a plate on which it ends free, or a disc that it covers.
ON_PLATE, ON_DISC = "plate", "disc"
#: Options of a rough plate, on which all materials make heaps.
ROUGH_PLATE: Mapping[str, Amount] = {
    "plate_sliding_friction": 0.5,
    "plate_rolling_friction": AS_PARTICLES,
}

#: Diameters from the edge of its disc within which a heap that covers it ends.
_AT_EDGE = 2.0
#: An angle of which there is no cone, degrees.
STEEPEST = 90.0
#: Glass beads and rough spheres of 10 mm make no heap at a sliding friction of 0.1 and of 0.15;
#: without rolling friction glass beads roll on, and rough spheres make a heap of 10 degrees.
_LEAST = {"sliding": 0.2, "rolling": 0.02}


def plate_walls(radius: float, rim_height: float, is_rough: bool) -> dict[str, Wall]:
    """Return the plate at z = 0, and its rim where it has one.

    Parameters
    ----------
    radius, rim_height : float
        m.
    is_rough : bool
        Whether its surface is `PLATE`, and not that of the walls.
    """
    surface = PLATE if is_rough else WALL
    walls = {"plate": Wall(Disc(radius, 0.0), surface)}
    if rim_height > 0:
        walls["rim"] = Wall(Cylinder(radius, 0.0, rim_height), surface)
    return walls


def base_option() -> Any:
    """Return the option of what the heap lies on."""
    return option(
        Choice((ON_PLATE, ON_DISC)),
        "What the heap lies on: a plate on which it ends free, or a disc that it covers, off which "
        "the surplus falls.",
        example=f'"{ON_DISC}"',
        default=ON_PLATE,
        default_text=f'`"{ON_PLATE}"`',
    )


def rim_option() -> Any:
    """Return the option of the height of a rim around the plate."""
    return option(
        Quantity("m", lowest=0.0, highest=1e3),
        "Height of a rim around the plate.",
        example='"10 mm"',
        default=0.0,
        default_text="0, a free edge",
    )


def plate_friction(kind: str) -> Any:
    """Return the option of a friction of the plate.

    Parameters
    ----------
    kind : {"Sliding", "Rolling"}
        Kind of friction.
    """
    if kind == "Sliding":
        starter = "rough; by default that of the walls, off which heaps slide"
        return friction_option(kind, "plate", "plate.", "0.5", starter=starter, recorded="apart")
    return friction_option(
        kind,
        "plate",
        "plate. On a smooth plate heaps slide and roll apart, beyond its edge.",
        f'"{AS_PARTICLES}"',
        starter="rough; by default that of the walls",
        recorded="apart",
    )


def views_option() -> Any:
    """Return the option of the number of silhouettes."""
    return option(
        Whole(1, 360),
        "Number of silhouettes on which the heap is measured.",
        example="12",
        default=12,
    )


def expected_foot(volume: float, angle: float, diameter: float) -> float:
    """Return about the base radius of a heap, m.

    Half a diameter above its base, a cone of the volume of the bed is as wide as the heap, up to
    half a diameter: heaps of glass beads and of rough spheres of 18 to 23 degrees.

    Parameters
    ----------
    volume : float
        Bulk volume of the heap, m^3.
    angle : float
        Angle of repose, degrees.
    diameter : float
        Of the particles, m.
    """
    return cone_radius(volume, angle) - diameter / 2 / math.tan(math.radians(angle))


def cone_radius(volume: float, angle: float) -> float:
    """Return the base radius of a cone of a volume, m^3, and an inclination, degrees, in m."""
    return math.pow(3 * volume / (math.pi * math.tan(math.radians(angle))), 1 / 3)


@check("small-plate", "warning")
def small_plate(checked: CheckedTest[Any]) -> Iterator[Found]:
    """Plates that are too small for the measured heap, whose size is needed."""
    setup, diameter = checked.test.setup, checked.test.sizes.sauter_diameter
    needed = [name for name in absent_responses(checked.test) if name in checked.targets]
    angle, radius = (checked.targets.get(name) for name in ("angle_of_repose", "base_radius"))
    if not needed or setup.rim_height > 0 or setup.base == ON_DISC:
        return
    if radius is None and angle is not None and 0 < angle < STEEPEST:
        radius = expected_foot(setup.heap_volume, angle, diameter)
    if radius is not None and radius > setup.plate_radius - diameter:
        yield (
            "plate_radius",
            messages.SMALL_PLATE(
                plate=millimetres(setup.plate_radius),
                needed=in_a_row(needed),
                radius=millimetres(radius),
                least=millimetres(radius + 3 * diameter),
            ),
        )


@check("base-of-disc", "warning")
def base_of_disc(checked: CheckedTest[Any]) -> Iterator[Found]:
    """Measured base radii other than that of the disc which the heap covers."""
    setup, diameter = checked.test.setup, checked.test.sizes.sauter_diameter
    radius = checked.targets.get("base_radius")
    if setup.base != ON_DISC or radius is None:
        return
    if abs(radius - setup.plate_radius) > _AT_EDGE * diameter:
        yield (
            "targets.base_radius",
            messages.BASE_OF_DISC(radius=millimetres(radius), disc=millimetres(setup.plate_radius)),
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
    if checked.test.sizes.shape is not None or not angle or angle >= STEEPEST:
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
