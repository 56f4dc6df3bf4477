"""Faults of a scene that a solver would answer with a crash, or with plausible numbers."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from itertools import combinations_with_replacement

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from grainfit.errors import Fault
from grainfit.scenes.conditions import AtRest, Elapsed
from grainfit.scenes.glued import Glued
from grainfit.scenes.packing import Column
from grainfit.scenes.records import Force
from grainfit.scenes.scene import Box, Motion, Scene, Stage, Wall
from grainfit.scenes.shapes import Annulus, Block, Cone, Cylinder, Disc, Plane, Shape
from grainfit.scenes.spheres import ClumpSpheres
from grainfit.scenes.stl import mesh_faults

Array = NDArray[np.float64]

_AXES = ("x", "y", "z")
#: Overlap of two particles at the beginning that is no rounding error, over their distance.
_OVERLAP = 0.01


def scene_faults(scene: Scene) -> tuple[Fault, ...]:
    """Return why a scene cannot be simulated as it is meant; empty when nothing is found.

    Parameters
    ----------
    scene : Scene
        The scene; its names and the walls of its stages were checked when it was made.
    """
    numbers = [*_number_faults(scene), *_box_faults(scene.box)]
    if numbers:
        return tuple(numbers)
    return (
        *_period_faults(scene),
        *_particle_faults(scene),
        *(f for name, body in scene.glued.items() for f in _glued_faults(name, body, scene)),
        *(f for name, wall in scene.all_walls().items() for f in _wall_faults(name, wall, scene)),
        *(f for stage in scene.stages for f in _stage_faults(stage)),
        *_order_faults(scene),
    )


def _is_number(value: object) -> bool:
    return isinstance(value, int | float | np.number) and math.isfinite(value)


def _is_interval(value: object) -> bool:
    return _is_number(value) and value > 0  # type: ignore[operator]


def _number_faults(scene: Scene) -> Iterator[Fault]:
    for key in ("time_step", "quiet_speed", "check_interval", "typical_load"):
        value = getattr(scene, key)
        if not (_is_number(value) and value > 0):
            yield Fault(key, f"is {value!r}.", "Give a number above 0.")
    if not (_is_number(scene.gravity) and scene.gravity >= 0):
        yield Fault("gravity", f"is {scene.gravity!r}.", "Give a number in m/s^2, at least 0.")


def _box_faults(box: Box) -> Iterator[Fault]:
    for axis, low, high in zip(_AXES, box.low, box.high, strict=True):
        if not (_is_number(low) and _is_number(high) and low < high):
            yield Fault("box", f"goes from {low!r} to {high!r} along {axis}.", "low is below high.")
    if not set(box.periodic) <= set(_AXES) or len(set(box.periodic)) < len(box.periodic):
        yield Fault("box", f"is periodic along {box.periodic!r}.", 'Write axes, such as "y".')


def _period_faults(scene: Scene) -> Iterator[Fault]:
    """A particle must not touch the same neighbour from both sides."""
    largest = max(scene.sizes.outer_diameters)
    for axis, low, high in zip(_AXES, scene.box.low, scene.box.high, strict=True):
        if axis in scene.box.periodic and high - low < 2 * largest:
            yield Fault(
                "box",
                f"repeats along {axis} every {high - low:.3g} m, which is less than two diameters "
                f"of the largest particles ({largest:.3g} m).",
                "Use a longer period; five diameters are usual.",
            )


def _particle_faults(scene: Scene) -> Iterator[Fault]:
    column, sizes = scene.particles, scene.sizes
    shape, count = column.positions.shape, len(column.size_indices)
    if count == 0 or shape != (count, 3) or not np.isfinite(column.positions).all():
        message = f"positions have the shape {shape} for {count} particles, or are no numbers."
        yield Fault("particles", message, "Give one place for each particle.")
        return
    if column.size_indices.min() < 0 or column.size_indices.max() >= len(sizes.diameters):
        message = f"size_indices go from {column.size_indices.min()} to {column.size_indices.max()}"
        remedy = f"Use 0 to {len(sizes.diameters) - 1}, one for each diameter."
        yield Fault("particles", f"{message}.", remedy)
        return
    velocities = column.velocities
    if velocities is not None and (velocities.shape != shape or not np.isfinite(velocities).all()):
        yield Fault(
            "particles", "velocities are not one for each particle.", "Give (n, 3) of them."
        )
    turned = [*_clump_faults(scene)]
    if turned:
        yield from turned
        return
    clumps = scene.clumps
    outside = _outside(column, clumps, scene.box)
    if outside.any():
        lost, first = int(outside.sum()), column.positions[outside][0].tolist()
        message = f"{lost} of {count} begin outside of the box, the first at {first} m."
        yield Fault("particles", message, "Make the box larger, or move them.")
        return
    if clumps is None:
        overlaps = _overlaps(column, sizes.diameters)
    else:
        overlaps = _clump_overlaps(*column.outlines(clumps), len(clumps.clump))
    if overlaps:
        message = f"{overlaps} pairs overlap at the beginning, and would burst apart."
        yield Fault("particles", message, "Use random_column(), or place them farther apart.")


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
            remedy = "Leave them out: spheres look the same from all sides, and begin without spin."
            yield Fault("particles", f"have {name}, and are spheres.", remedy)
        elif values.shape != (count, width) or not np.isfinite(values).all():
            message = f"{name} are not one for each clump."
            yield Fault("particles", message, f"Give ({count}, {width}) of them.")


def _glued_faults(name: str, body: Glued, scene: Scene) -> Iterator[Fault]:
    key, sizes = f"glued {name}", len(scene.sizes.diameters)
    if body.size_indices.min() < 0 or body.size_indices.max() >= sizes:
        message = f"size_indices go from {body.size_indices.min()} to {body.size_indices.max()}."
        yield Fault(key, message, f"Use 0 to {sizes - 1}, one for each diameter.")
    if not np.isfinite(body.positions).all():
        yield Fault(key, "has positions that are no numbers.", "Give finite numbers, m.")
        return
    outside = _beyond(body.positions, scene.box).any(axis=1)
    if outside.any():
        first = body.positions[outside][0].tolist()
        message = f"begins outside of the box with {outside.sum()} particles, the first at {first}"
        yield Fault(key, f"{message} m.", "Make the box larger, or move them.")


def _overlaps(column: Column, diameters: Iterable[float]) -> int:
    """Count pairs of particles that overlap; copies across periodic sides are left out."""
    found = 0
    trees = {
        index: (diameter, cKDTree(column.positions[column.size_indices == index]))
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


def _clump_overlaps(places: Array, radii: Array, each: int) -> int:
    """Count pairs of clumps that overlap; copies across periodic sides are left out."""
    pairs = cKDTree(places).query_pairs(2 * radii.max(), output_type="ndarray")
    apart = np.linalg.norm(places[pairs[:, 0]] - places[pairs[:, 1]], axis=1)
    owners = pairs[apart < (1 - _OVERLAP) * radii[pairs].sum(axis=1)] // each
    return len(np.unique(np.sort(owners[owners[:, 0] != owners[:, 1]], axis=1), axis=0))


def _wall_faults(name: str, wall: Wall, scene: Scene) -> Iterator[Fault]:
    key = f"wall {name}"
    shape = wall.shape
    lengths = _lengths(shape)
    if not all(_is_number(value) for value in lengths):
        yield Fault(key, f"{shape!r} has lengths that are no numbers.", "Give finite numbers, m.")
        return
    if isinstance(shape, Plane) and shape.axis not in _AXES:
        yield Fault(key, f"has the axis {shape.axis!r}.", "Use x, y or z.")
    if isinstance(shape, Block) and not all(a < b for a, b in _sides(shape, scene.box)):
        yield Fault(key, f"goes from {shape.low} to {shape.high}.", "low is below high.")
    if isinstance(shape, Cylinder | Cone) and not shape.bottom < shape.top:
        yield Fault(key, f"goes from {shape.bottom} up to {shape.top} m.", "bottom is below top.")
    if any(radius <= 0 for radius in _radii(shape)):
        yield Fault(key, f"{shape!r} has no radius above 0.", "Give one in m.")
    if wall.surface != "wall" and wall.surface not in scene.surfaces:
        remedy = f"Surfaces: {', '.join(('wall', *scene.surfaces))}."
        yield Fault(
            key, f"has the surface {wall.surface!r}, which the scene does not have.", remedy
        )
    yield from mesh_faults(key, shape, scene.box)


def _sides(block: Block, box: Box) -> list[tuple[float, float]]:
    """Lower and upper limits of a block along the axes on which it has ends."""
    sides = zip(_AXES, block.low, block.high, strict=True)
    return [(low, high) for axis, low, high in sides if axis not in box.periodic]


def _lengths(shape: Shape) -> list[object]:
    fields = [value for name, value in vars(shape).items() if name not in ("axis", "path")]
    return [v for value in fields for v in (value if isinstance(value, tuple) else (value,))]


def _radii(shape: Shape) -> tuple[float, ...]:
    if isinstance(shape, Cylinder | Disc):
        return (shape.radius,)
    if isinstance(shape, Cone):
        return (max(shape.lower_radius, shape.upper_radius),)
    if isinstance(shape, Annulus):
        return (shape.inner_radius, shape.outer_radius - shape.inner_radius)
    return ()


def _stage_faults(stage: Stage) -> Iterator[Fault]:
    key = f"stage {stage.name}"
    until = stage.until
    times = {"time": until.time} if isinstance(until, Elapsed) else {"limit": until.limit}
    for name, value in times.items():
        if not (_is_number(value) and value > 0):
            yield Fault(key, f"has the {name} {value!r}.", "Give a time in s, above 0.")
    for name in stage.motions:
        for motion in stage.motions_of(name):
            yield from _motion_faults(key, name, motion)
    if stage.frames is not None and not _is_interval(stage.frames.every):
        yield Fault(key, f"has frames every {stage.frames.every!r} s.", "Give a time above 0.")
    if stage.series is not None:
        if not _is_interval(stage.series.every):
            yield Fault(key, f"records every {stage.series.every!r} s.", "Give a time above 0.")
        for column, quantity in stage.series.columns.items():
            if isinstance(quantity, Force) and quantity.along not in _AXES:
                yield Fault(key, f"records {column} along {quantity.along!r}.", "Use x, y or z.")


def _motion_faults(key: str, name: str, motion: Motion) -> Iterator[Fault]:
    if motion.along not in _AXES:
        yield Fault(key, f"moves {name} along {motion.along!r}.", "Use x, y or z.")
    numbers = [value for field, value in vars(motion).items() if field not in ("along", "through")]
    if not all(_is_number(value) for value in (*numbers, *getattr(motion, "through", ()))):
        yield Fault(key, f"moves {name} by {motion!r}.", "Give finite numbers.")


def _order_faults(scene: Scene) -> Iterator[Fault]:
    if not scene.stages:
        yield Fault("stages", "are missing.", "Give at least one Stage.")
    for stage in scene.stages[1:]:
        changes = stage.take_away or stage.put or stage.strike_off is not None or stage.motions
        if isinstance(stage.until, AtRest) and changes and not stage.until.at_least > 0:
            message = "ends at rest: a bed that is at rest when it begins ends it at once."
            yield Fault(f"stage {stage.name}", message, "Give AtRest an at_least, s.")
