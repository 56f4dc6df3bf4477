"""Scenes in words: shapes of walls, stages, motions, ends."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import fields, is_dataclass
from math import pi
from typing import Any

from grainfit.formatting import in_a_row, number
from grainfit.formatting import millimetres as _mm
from grainfit.scenes.conditions import AtRest, Clear, Drained, Elapsed, Loaded
from grainfit.scenes.scene import WALL, Load, Rotation, Scene, Stage, Velocity, Wall
from grainfit.scenes.shapes import Annulus, Block, Cone, Cylinder, Disc, Mesh, Plane, Prism
from grainfit.scenes.stl import read_stl


def _block(shape: Block | Prism) -> str:
    sides = (f"{_mm(high - low)}" for low, high in zip(shape.low, shape.high, strict=True))
    return f"block, {' x '.join(sides)}"


def _mesh(shape: Mesh) -> str:
    found = read_stl(shape.path)
    kind = "closed" if found.is_closed else "open"
    left = f", {found.left_out} without an area left out" if found.left_out else ""
    size = _mm(shape.scale * found.size)
    count = len(found.triangles)
    return f"STL file {shape.path.name}, {size} large, {kind}, {count} triangles{left}"


_SHAPES: Mapping[type, Callable[[Any], str]] = {
    Plane: lambda s: f"plane {s.axis} = {_mm(s.at)}, met from {'above' if s.upwards else 'below'}",
    Block: _block,
    Prism: lambda s: f"{_block(s)}, its upper side shifted by {_mm(s.shift)} along x",
    Cylinder: lambda s: (
        f"tube, radius {_mm(s.radius)}, from {s.axis} = {_mm(s.bottom)} to {_mm(s.top)}"
    ),
    Cone: lambda s: (
        f"funnel, radius {_mm(s.lower_radius)} at z = {_mm(s.bottom)} and {_mm(s.upper_radius)} "
        f"at {_mm(s.top)}"
    ),
    Disc: lambda s: f"round plate, radius {_mm(s.radius)}, at z = {_mm(s.z)}",
    Annulus: lambda s: (
        f"ring, radii {_mm(s.inner_radius)} and {_mm(s.outer_radius)}, at z = {_mm(s.z)}"
    ),
    Mesh: _mesh,
}
_MOTIONS: Mapping[type, Callable[[Any], str]] = {
    Velocity: lambda m: f"moves {_way(m.speed, m.along)} at {_mm(abs(m.speed))}/s",
    Load: lambda m: (
        f"presses {_way(m.force, m.along)} with {number(abs(m.force), 3)} N{_across(m)} "
        f"(no faster than {_mm(m.largest_speed)}/s)"
    ),
    Rotation: lambda m: (
        f"turns at {number(60 * abs(m.speed) / (2 * pi), 3)} rpm about the {m.along} axis"
    ),
}
_ENDS: Mapping[type, Callable[[Any], str]] = {
    AtRest: lambda u: f"until the particles rest ({_between(u.at_least, u.limit)})",
    Clear: lambda u: (
        f"until no particle touches the {_words(u.wall)} and they rest (at most {_s(u.limit)})"
    ),
    Loaded: lambda u: (
        f"until the {_words(u.wall)} holds its load within {number(100 * u.within, 2)} % and the "
        f"particles rest (at most {_s(u.limit)})"
    ),
    Drained: lambda u: (
        f"until {number(100 * u.share, 2)} % of the mass is no more above {_mm(u.height)}, or the "
        f"particles rest ({_between(u.at_least, u.limit)})"
    ),
    Elapsed: lambda u: f"for {_s(u.time)}",
}


def _words(name: str) -> str:
    return name.replace("_", " ")


def _way(amount: float, along: str) -> str:
    """Return a direction in words: upwards, downwards, or along an axis."""
    if along == "z":
        return "upwards" if amount > 0 else "downwards"
    return f"along {along}" if amount > 0 else f"against {along}"


def _across(load: Load) -> str:
    pairs = " and ".join(f"{low} and {high}" for low, high in load.across)
    return f", times the distance between {pairs} over the first one" if pairs else ""


def _s(time: float) -> str:
    return f"{number(time, 3)} s"


def _between(least: float, most: float) -> str:
    return f"{_s(least)} to {_s(most)}" if least > 0 else f"at most {_s(most)}"


def _text(table: Mapping[type, Callable[[Any], str]], thing: Any) -> str:
    """Return the words of a table; of a class that it does not know, the name and the fields."""
    known = table.get(type(thing))
    if known is not None:
        return known(thing)
    values = fields(thing) if is_dataclass(thing) else ()
    listed = ", ".join(f"{f.name.replace('_', ' ')} {getattr(thing, f.name)}" for f in values)
    return f"{type(thing).__name__.lower()}: {listed}" if listed else type(thing).__name__.lower()


def wall_text(wall: Wall) -> str:
    """Describe a wall: its shape, and its surface if it has one of its own."""
    surface = "" if wall.surface == WALL else f"; surface {wall.surface}"
    return f"{_text(_SHAPES, wall.shape)}{surface}"


def motion_text(motion: object) -> str:
    """Describe a motion of a wall."""
    return _text(_MOTIONS, motion)


def stage_text(stage: Stage) -> str:
    """Describe what happens in a stage, and when it ends."""
    parts = [*_changes(stage), *_motions(stage), _text(_ENDS, stage.until)]
    return "; ".join(parts)


def _changes(stage: Stage) -> Iterator[str]:
    if stage.take_away:
        yield f"{in_a_row(map(_words, stage.take_away))} taken away"
    if stage.put:
        yield f"{in_a_row(map(_words, stage.put))} put in place"
    if stage.strike_off is not None:
        yield f"particles above {_mm(stage.strike_off)} removed"
    if stage.sliding_friction is not None:
        yield f"sliding friction between particles {number(stage.sliding_friction, 3)}"


def _motions(stage: Stage) -> Iterator[str]:
    for name in stage.motions:
        for motion in stage.motions_of(name):
            yield f"{_words(name)} {motion_text(motion)}"
    if stage.series is not None:
        recorded = in_a_row(map(_words, stage.series.columns))
        yield f"{recorded} recorded every {number(1000 * stage.series.every, 2)} ms"


def box_text(scene: Scene) -> str:
    """Describe the size of the box and its periodic axes."""
    sides = zip(scene.box.low, scene.box.high, strict=True)
    size = " x ".join(_mm(high - low) for low, high in sides)
    periodic = f", repeats along {in_a_row(scene.box.periodic)}" if scene.box.periodic else ""
    return f"{size}{periodic}"
