"""What is odd about the beginning and the filling of a scene, before its first run."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from grainfit.arrays import Array
from grainfit.bulk_tests.checks import CheckedTest
from grainfit.bulk_tests.own_scene import messages
from grainfit.checks import Found, check
from grainfit.scenes.conditions import AtRest
from grainfit.scenes.records import Force, RadialForce
from grainfit.scenes.scene import Scene, Stage, Wall
from grainfit.scenes.shapes import Cone, Cylinder
from grainfit.scenes.triangles import triangles_of

#: Particles at an edge may be held by their neighbours.
_TOLERATED = 0.05
#: As many particles, spread over all, are looked at.
_LOOKED_AT = 300

Mask = NDArray[np.bool_]


@check("particles-not-held", "warning")
def particles_not_held(checked: CheckedTest[Any]) -> Iterator[Found]:
    """Particles that begin below their gate or beside their vessel, so that no wall holds them."""
    scene = _scene(checked)
    if scene is None or scene.gravity == 0 or "z" in scene.box.periodic:
        return
    first = scene.stages[0]
    if not (first.is_closed or isinstance(first.until, AtRest)):
        return
    below = without_wall_below(scene)
    if below > _TOLERATED:
        yield "scene", messages.NO_WALL_BELOW(share=below, stage=first.name)
    beside = beside_all_tubes(scene)
    if beside > _TOLERATED:
        yield "scene", messages.BESIDE_VESSEL(share=beside)


@check("forces-after-fill", "note")
def forces_after_fill(checked: CheckedTest[Any]) -> Iterator[Found]:
    """Forces that are recorded while a bed comes to rest, or right after it."""
    scene = _scene(checked)
    if scene is None or scene.gravity == 0:
        return
    for stage in scene.stages:
        if _records_force(stage):
            yield "scene", messages.FORCES_AFTER_FILL(stage=stage.name)
        if stage is not scene.stages[0] and (stage.motions or stage.take_away):
            return


def _records_force(stage: Stage) -> bool:
    columns = {} if stage.series is None else stage.series.columns
    is_moved = bool(stage.motions or stage.take_away)
    return not is_moved and any(isinstance(q, Force | RadialForce) for q in columns.values())


def _scene(checked: CheckedTest[Any]) -> Scene | None:
    """Return the scene that was planned; None before: a check executes no code of the user."""
    scene: Scene | None = checked.test.last_planned
    return scene


def without_wall_below(scene: Scene) -> float:
    """Return the share of the particles that no wall of the beginning is below."""
    places = _some(scene)
    caught = np.zeros(len(places), dtype=bool)
    edge = scene.sizes.sauter_diameter
    for wall in scene.walls.values():
        for triangle in triangles_of(wall.shape, scene.box, edge):
            caught |= _is_over(places, np.asarray(triangle, dtype=float))
    for body in scene.glued.values():
        ends = body.positions.min(axis=0), body.positions.max(axis=0)
        within = ((places[:, :2] >= ends[0][:2]) & (places[:, :2] <= ends[1][:2])).all(axis=1)
        caught |= within & (places[:, 2] > ends[0][2])
    return float(1 - caught.mean())


def beside_all_tubes(scene: Scene) -> float:
    """Return the share of the particles that are level with upright tubes, and in none of them."""
    places = _some(scene)
    level, inside = np.zeros((2, len(places)), dtype=bool)
    for wall in scene.walls.values():
        here, within = _in_tube(places, wall)
        level |= here
        inside |= within
    return float((level & ~inside).mean())


def _some(scene: Scene) -> Array:
    places = scene.particles.positions
    return places[:: max(1, len(places) // _LOOKED_AT)]


def _in_tube(places: Array, wall: Wall) -> tuple[Mask, Mask]:
    """Find particles between the ends of an upright tube, and those of them inside of it."""
    shape = wall.shape
    if isinstance(shape, Cylinder) and shape.axis == "z":
        lower = upper = shape.radius
    elif isinstance(shape, Cone):
        lower, upper = shape.lower_radius, shape.upper_radius
    else:
        none = np.zeros(len(places), dtype=bool)
        return none, none
    level = (places[:, 2] >= shape.bottom) & (places[:, 2] <= shape.top)
    share = (places[:, 2] - shape.bottom) / (shape.top - shape.bottom)
    radii = lower + share * (upper - lower)
    return level, level & (np.hypot(places[:, 0], places[:, 1]) < radii)


def _is_over(places: Array, triangle: Array) -> Mask:
    """Find points that are above a triangle."""
    (ax, ay, az), (bx, by, bz), (cx, cy, cz) = triangle
    area = (bx - ax) * (cy - ay) - (cx - ax) * (by - ay)
    if abs(area) <= 1e-12 * float(np.ptp(triangle, axis=0).max()) ** 2:
        return np.zeros(len(places), dtype=bool)
    x, y, z = places.T
    second = ((x - ax) * (cy - ay) - (cx - ax) * (y - ay)) / area
    third = ((bx - ax) * (y - ay) - (x - ax) * (by - ay)) / area
    # Edges shared by two triangles must not have a gap.
    within = (second >= -1e-9) & (third >= -1e-9) & (second + third <= 1 + 1e-9)
    return within & (z >= az + second * (bz - az) + third * (cz - az))
