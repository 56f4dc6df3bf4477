"""Faults of a scene that a solver would answer with a crash, or with plausible numbers."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import fields
from itertools import combinations_with_replacement

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from grainfit.arrays import Array
from grainfit.errors import Fault
from grainfit.scenes import messages
from grainfit.scenes.conditions import AtRest, Condition, Drained, Elapsed
from grainfit.scenes.glued import Glued
from grainfit.scenes.packing import Column
from grainfit.scenes.records import Force
from grainfit.scenes.scene import Box, Motion, Rotation, Scene, Stage, Wall
from grainfit.scenes.shapes import Annulus, Block, Cone, Cylinder, Disc, Plane, Prism, Shape
from grainfit.scenes.spheres import ClumpSpheres
from grainfit.scenes.stl import mesh_faults
from grainfit.scenes.wall_distances import distances, ends_along
from grainfit.validation import SMALLEST, as_number

_AXES = ("x", "y", "z")
#: Beginnings of the parameters that a surface may have of its own.
_OF_WALLS = ("wall.", "particle_wall.")
#: Overlap of two particles at the beginning that is no rounding error, over their distance; of one
#: and a wall, over its radius.
_OVERLAP = 0.01
#: Distance beyond a periodic side that is rounding, over the period.
_SIDE = 1e-6


#: Numbers of the parts of a stage that have messages of their own.
_ELSEWHERE = ("time", "limit", "at_least", "share", "every")
_FINITE = "a finite number"
_ABOVE_ZERO = (SMALLEST, "a number above 0")
#: Least values of numbers that cannot be negative, by name, and what is wanted.
_LOWEST = {
    "sliding_friction": (0.0, "0 or a number above it"),
    "within": _ABOVE_ZERO,
    "largest_speed": _ABOVE_ZERO,
    "gain": _ABOVE_ZERO,
}


def scene_faults(scene: Scene) -> tuple[Fault, ...]:
    """Return why a scene cannot be simulated as it is meant; empty when nothing is found.

    Its names and the walls of its stages were checked when it was made.
    """
    numbers = [*_number_faults(scene), *_box_faults(scene.box)]
    if numbers:
        return tuple(numbers)
    parts = (
        *_period_faults(scene),
        *_particle_faults(scene),
        *_surface_faults(scene),
        *(f for name, body in scene.glued.items() for f in _glued_faults(name, body, scene)),
        *(f for name, wall in scene.all_walls().items() for f in _wall_faults(name, wall, scene)),
        *(f for stage in scene.stages for f in _stage_faults(stage)),
        *_order_faults(scene),
    )
    return parts or tuple(_faults_at_walls(scene))


def _is_number(value: object) -> bool:
    return math.isfinite(as_number(value))


def _is_interval(value: object) -> bool:
    return as_number(value) > 0 and _is_number(value)


def _number_faults(scene: Scene) -> Iterator[Fault]:
    for key in ("time_step", "quiet_speed", "check_interval", "typical_load", "film_interval"):
        value = getattr(scene, key)
        is_left_out = key == "film_interval" and value is None
        if not (is_left_out or _is_interval(value)):
            yield messages.NOT_ABOVE_ZERO.fault(key, value=value)
    if not (_is_number(scene.gravity) and scene.gravity >= 0):
        yield messages.NO_GRAVITY.fault("gravity", value=scene.gravity)
    for name, value in scene.material.items():
        if not _is_number(value):
            yield messages.NO_NUMBER.fault("material", name=name, value=value, wanted=_FINITE)
    yield from _other_numbers("particles", scene.particles)


def _other_numbers(key: str, owner: object) -> Iterator[Fault]:
    """Yield the numbers of a part of a scene that mean nothing, but for those checked elsewhere."""
    for field in fields(owner):  # type: ignore[arg-type]
        name, value = field.name, getattr(owner, field.name)
        is_left_out = value is None and field.type == "float | None"
        if name in _ELSEWHERE or is_left_out or field.type not in ("float", "float | None"):
            continue
        lowest, wanted = _LOWEST.get(name, (-math.inf, _FINITE))
        if not (_is_number(value) and value >= lowest):
            yield messages.NO_NUMBER.fault(key, name=name, value=value, wanted=wanted)


def _box_faults(box: Box) -> Iterator[Fault]:
    if None in (*_components(box.low), *_components(box.high)):
        yield messages.BOX_CORNERS.fault("box", low=box.low, high=box.high)
        return
    for axis, low, high in zip(_AXES, box.low, box.high, strict=True):
        if not (_is_number(low) and _is_number(high) and low < high):
            yield messages.BOX_SIDES.fault("box", low=low, high=high, axis=axis)
    if not set(box.periodic) <= set(_AXES) or len(set(box.periodic)) < len(box.periodic):
        yield messages.BOX_PERIODS.fault("box", axes=box.periodic)


def _period_faults(scene: Scene) -> Iterator[Fault]:
    """A particle must not touch the same neighbour from both sides."""
    largest = max(scene.sizes.outer_diameters)
    for axis, low, high in zip(_AXES, scene.box.low, scene.box.high, strict=True):
        if axis in scene.box.periodic and high - low < 2 * largest:
            yield messages.SHORT_PERIOD.fault("box", axis=axis, period=high - low, diameter=largest)


def _particle_faults(scene: Scene) -> Iterator[Fault]:
    column, sizes = scene.particles, scene.sizes
    shape, count = column.positions.shape, len(column.size_indices)
    if count == 0 or shape != (count, 3) or not np.isfinite(column.positions).all():
        yield messages.POSITIONS.fault("particles", shape=shape, count=count)
        return
    wrong_sizes = [*_size_faults("particles", column.size_indices, len(sizes.diameters))]
    if wrong_sizes:
        yield from wrong_sizes
        return
    velocities = column.velocities
    if velocities is not None and (velocities.shape != shape or not np.isfinite(velocities).all()):
        yield messages.VELOCITIES.fault("particles")
    turned = [*_clump_faults(scene)]
    if turned:
        yield from turned
        return
    clumps = scene.clumps
    outside = _outside(column, clumps, scene.box)
    if outside.any():
        lost, first = int(outside.sum()), column.positions[outside][0].tolist()
        yield messages.OUTSIDE.fault("particles", outside=lost, count=count, first=first)
        return
    if clumps is None:
        overlaps = _overlaps(column, sizes.diameters, scene.box)
    else:
        overlaps = _clump_overlaps(*column.outlines(clumps), len(clumps.clump), scene.box)
    if overlaps:
        yield messages.OVERLAPS.fault("particles", pairs=overlaps)


def _size_faults(key: str, indices: NDArray[np.int64], sizes: int) -> Iterator[Fault]:
    low, high = int(indices.min()), int(indices.max())
    if low < 0 or high >= sizes:
        yield messages.SIZE_INDICES.fault(key, low=low, high=high, last=sizes - 1)


def _outside(column: Column, clumps: ClumpSpheres | None, box: Box) -> NDArray[np.bool_]:
    """Find particles whose centre is outside of the box, or a sphere of a clump.

    Spheres of a clump may be beyond a periodic side, through which the clump reaches.
    """
    beyond = _beyond(column.positions, box)
    if clumps is not None:
        has_end = np.array([axis not in box.periodic for axis in _AXES])
        spheres = _beyond(column.outlines(clumps)[0], box) & has_end
        beyond = np.hstack((beyond, spheres.reshape(len(beyond), -1)))
    return np.asarray(beyond.any(axis=1))


def _beyond(places: Array, box: Box) -> NDArray[np.bool_]:
    found: NDArray[np.bool_] = (places < box.low) | (places > box.high)
    return found


def _clump_faults(scene: Scene) -> Iterator[Fault]:
    """Orientations and spins belong to clumps, one for each."""
    column, count = scene.particles, len(scene.particles.size_indices)
    for name, values, width in (
        ("orientations", column.orientations, 4),
        ("spins", column.spins, 3),
    ):
        if values is None:
            continue
        if scene.clumps is None:
            yield messages.SPHERES_TURN.fault("particles", name=name)
        elif values.shape != (count, width) or not np.isfinite(values).all():
            yield messages.ONE_FOR_EACH_CLUMP.fault(
                "particles", name=name, count=count, width=width
            )


def _glued_faults(name: str, body: Glued, scene: Scene) -> Iterator[Fault]:
    key = f"glued {name}"
    yield from _size_faults(key, body.size_indices, len(scene.sizes.diameters))
    if not np.isfinite(body.positions).all():
        yield messages.GLUED_POSITIONS.fault(key)
        return
    outside = _beyond(body.positions, scene.box).any(axis=1)
    if outside.any():
        first = body.positions[outside][0].tolist()
        yield messages.GLUED_OUTSIDE.fault(key, count=outside.sum(), first=first)


def _in_period(places: Array, box: Box) -> tuple[Array, Array]:
    """Return places moved into the box through its periods, and these, m: 0 where there is none."""
    low, high = np.array(box.low, dtype=float), np.array(box.high, dtype=float)
    periods = np.where([axis in box.periodic for axis in _AXES], high - low, 0.0)
    repeats = np.flatnonzero(periods)
    moved = places.copy()
    # Twice: a little less than the lower side becomes the period, by rounding.
    moved[:, repeats] = (places - low)[:, repeats] % periods[repeats] % periods[repeats]
    return moved, periods


def _overlaps(column: Column, diameters: Iterable[float], box: Box) -> int:
    """Count pairs of particles that overlap, also across periodic sides."""
    found = 0
    places, periods = _in_period(column.positions, box)
    trees = {
        index: (diameter, cKDTree(places[column.size_indices == index], boxsize=periods))
        for index, diameter in enumerate(diameters)
        if (column.size_indices == index).any()
    }
    for one, other in combinations_with_replacement(trees, 2):
        (d1, first), (d2, second) = trees[one], trees[other]
        reach = (1 - _OVERLAP) * (d1 + d2) / 2
        if one == other:
            found += len(first.query_pairs(reach))
        else:
            found += int(first.count_neighbors(second, reach))
    return found


def _clump_overlaps(outlines: Array, radii: Array, each: int, box: Box) -> int:
    """Count pairs of clumps that overlap, also across periodic sides."""
    places, periods = _in_period(outlines, box)
    pairs = cKDTree(places, boxsize=periods).query_pairs(2 * radii.max(), output_type="ndarray")
    between = np.abs(places[pairs[:, 0]] - places[pairs[:, 1]])
    apart = np.linalg.norm(np.minimum(between, np.abs(periods - between)), axis=1)
    owners = pairs[apart < (1 - _OVERLAP) * radii[pairs].sum(axis=1)] // each
    return len(np.unique(np.sort(owners[owners[:, 0] != owners[:, 1]], axis=1), axis=0))


def _wall_faults(name: str, wall: Wall, scene: Scene) -> Iterator[Fault]:
    key = f"wall {name}"
    shape = wall.shape
    lengths = _lengths(shape)
    if not all(_is_number(value) for value in lengths):
        yield messages.NO_NUMBERS.fault(key, shape=shape)
        return
    if isinstance(shape, Plane) and shape.axis not in _AXES:
        yield messages.WALL_AXIS.fault(key, axis=shape.axis)
    if isinstance(shape, Block | Prism) and not all(a < b for a, b in _sides(shape, scene.box)):
        yield messages.BLOCK_SIDES.fault(key, low=shape.low, high=shape.high)
    if isinstance(shape, Prism) and set(scene.box.periodic) & {"x", "z"}:
        yield messages.PRISM_PERIOD.fault(key, axes=scene.box.periodic)
    if isinstance(shape, Cylinder | Cone) and not shape.bottom < shape.top:
        yield messages.WALL_ENDS.fault(key, bottom=shape.bottom, top=shape.top)
    if any(radius <= 0 for radius in _radii(shape)):
        yield messages.NO_RADIUS.fault(key, shape=shape)
    if wall.surface != "wall" and wall.surface not in scene.surfaces:
        known = ", ".join(("wall", *scene.surfaces))
        yield messages.NO_SURFACE.fault(key, surface=wall.surface, known=known)
    yield from mesh_faults(key, shape, scene.box)
    yield from _side_faults(key, shape, scene.box)


def _side_faults(key: str, shape: Shape, box: Box) -> Iterator[Fault]:
    """Yield the periods of the box with which a wall does not repeat."""
    for axis in box.periodic:
        if isinstance(shape, Plane) and shape.axis == axis:
            yield messages.ACROSS_PERIOD.fault(key, axis=axis)
        elif _goes_beyond(shape, box, axis):
            yield messages.BEYOND_PERIOD.fault(key, axis=axis)


def _goes_beyond(shape: Shape, box: Box, axis: str) -> bool:
    """Return whether a round wall reaches through a periodic side, where it does not go on."""
    if not isinstance(shape, Cylinder | Cone | Disc | Annulus):
        return False
    low, high = ends_along(shape, axis)
    number = _AXES.index(axis)
    near = _SIDE * (box.high[number] - box.low[number])
    is_along = isinstance(shape, Cylinder) and shape.axis == axis
    return not is_along and (low < box.low[number] - near or high > box.high[number] + near)


def _faults_at_walls(scene: Scene) -> Iterator[Fault]:
    """Yield the walls of the beginning that particles begin in, or on the wrong side of."""
    column, clumps, first = scene.particles, scene.clumps, scene.stages[0]
    places, each = column.positions, 1
    radii = np.array(scene.sizes.diameters)[column.size_indices] / 2
    if clumps is not None:
        (places, radii), each = column.outlines(clumps), len(clumps.clump)
    for name, wall in {**scene.walls, **first.put}.items():
        apart = distances(wall.shape, scene.box, places, float(radii.max()))
        caught = np.unique(np.flatnonzero(apart < (1 - _OVERLAP) * radii) // each)
        if len(caught) and name not in first.take_away:
            yield messages.IN_WALL.fault(
                f"wall {name}",
                caught=len(caught),
                count=len(column.positions),
                first=column.positions[caught[0]].tolist(),
            )


def _surface_faults(scene: Scene) -> Iterator[Fault]:
    known = [n for n in {**scene.law.defaults, **scene.material} if n.startswith(_OF_WALLS)]
    for name, values in scene.surfaces.items():
        key = f"surface {name}"
        for parameter, value in values.items():
            if parameter not in known:
                names = ", ".join(known)
                yield messages.SURFACE_PARAMETER.fault(key, name=parameter, known=names)
            elif not _is_number(value):
                yield messages.SURFACE_VALUE.fault(key, name=parameter, value=value)


def _sides(block: Block | Prism, box: Box) -> list[tuple[float, float]]:
    """Lower and upper limits of a block along the axes on which it has ends."""
    sides = zip(_AXES, block.low, block.high, strict=True)
    return [(low, high) for axis, low, high in sides if axis not in box.periodic]


def _lengths(shape: Shape) -> list[object]:
    kinds = {field.name: field.type for field in fields(shape)}
    vectors = [getattr(shape, name) for name, kind in kinds.items() if kind == "Vector"]
    single = [getattr(shape, name) for name, kind in kinds.items() if kind == "float"]
    return [*single, *(number for vector in vectors for number in _components(vector))]


def _components(vector: object) -> Iterable[object]:
    """Return the three numbers of a vector; of what is none, something that is no number."""
    is_vector = isinstance(vector, Sequence | np.ndarray) and len(vector) == len(_AXES)
    return vector if is_vector else [None]  # type: ignore[return-value]


def _radii(shape: Shape) -> tuple[float, ...]:
    if isinstance(shape, Cylinder | Disc):
        return (shape.radius,)
    if isinstance(shape, Cone):
        # One of them may be 0: the funnel ends in a point.
        lower, upper = shape.lower_radius, shape.upper_radius
        return (lower or upper, upper or lower)
    if isinstance(shape, Annulus):
        return (shape.inner_radius, shape.outer_radius - shape.inner_radius)
    return ()


def _stage_faults(stage: Stage) -> Iterator[Fault]:
    key = f"stage {stage.name}"
    yield from _other_numbers(key, stage)
    yield from _end_faults(key, stage.until)
    for name in stage.motions:
        for motion in stage.motions_of(name):
            yield from _motion_faults(key, name, motion)
    if stage.frames is not None and not _is_interval(stage.frames.every):
        yield messages.NO_FRAME_INTERVAL.fault(key, value=stage.frames.every)
    if stage.series is not None:
        if not _is_interval(stage.series.every):
            yield messages.NO_RECORD_INTERVAL.fault(key, value=stage.series.every)
        for column, quantity in stage.series.columns.items():
            yield from _other_numbers(f"{key}, column {column}", quantity)
            axis = getattr(quantity, "along", "")
            if axis not in _AXES and (axis or isinstance(quantity, Force)):
                yield messages.RECORD_AXIS.fault(key, column=column, axis=axis)


def _end_faults(key: str, until: Condition) -> Iterator[Fault]:
    times = {"time": until.time} if isinstance(until, Elapsed) else {"limit": until.limit}
    for name, value in times.items():
        if not (_is_number(value) and value > 0):
            yield messages.NO_TIME.fault(key, name=name, value=value)
    at_least = getattr(until, "at_least", 0.0)
    if not (_is_number(at_least) and at_least >= 0):
        yield messages.NO_FIRST_LOOK.fault(key, value=at_least)
    if isinstance(until, Drained) and not (_is_number(until.share) and 0 < until.share <= 1):
        yield messages.NO_SHARE.fault(key, value=until.share)
    yield from _other_numbers(key, until)


def _motion_faults(key: str, name: str, motion: Motion) -> Iterator[Fault]:
    if motion.along not in _AXES:
        yield messages.MOTION_AXIS.fault(key, name=name, axis=motion.along)
    others = ("along", "through", "across")
    numbers = [value for field, value in vars(motion).items() if field not in others]
    through = _components(motion.through) if isinstance(motion, Rotation) else ()
    if not all(map(_is_number, (*numbers, *through))):
        yield messages.MOTION_NUMBERS.fault(key, name=name, motion=motion)
        return
    yield from _other_numbers(f"{key}, motion of {name}", motion)


def _order_faults(scene: Scene) -> Iterator[Fault]:
    if not scene.stages:
        yield messages.NO_STAGES.fault("stages")
    for stage in scene.stages[1:]:
        changes = stage.take_away or stage.put or stage.strike_off is not None or stage.motions
        if isinstance(stage.until, AtRest | Drained) and changes and not stage.until.at_least > 0:
            yield messages.ENDS_AT_ONCE.fault(f"stage {stage.name}")
