"""Page of a preview: every test in three dimensions, its stages and walls in words."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np

from grainfit.arrays import Array
from grainfit.formatting import assigned, counted, in_a_row, millimetres, plain
from grainfit.preview.geometry import State
from grainfit.preview.previewed_test import PreviewedTest
from grainfit.preview.scene_picture import COLOURS
from grainfit.preview.scene_text import box_text, stage_text, wall_text
from grainfit.report.drawing_data import DrawingScale
from grainfit.report.package_page import package_page
from grainfit.report.rendering import script_json
from grainfit.scenes.shapes import Annulus, Block, Cone, Cylinder, Disc, Prism

#: Particles above this number are left out of the drawing, evenly.
_MOST_PARTICLES = 20_000
_STATES: Mapping[State, str] = {"still": "stand still", "moving": "move", "later": "put later"}


def preview_page(
    name: str,
    tests: Sequence[PreviewedTest],
    values: Mapping[str, float],
    units: Mapping[str, str],
) -> str:
    """Return a page of tests at values of the free parameters that needs no network."""
    keyed = {f"test-{number}": test for number, test in enumerate(tests, 1)}
    return package_page(
        "grainfit.preview",
        name=plain(name),
        values=in_a_row(assigned(values, units)),
        tests=[_described(key, test) for key, test in keyed.items()],
        data=script_json({key: _scene(test) for key, test in keyed.items()}),
    )


def _described(key: str, test: PreviewedTest) -> dict[str, Any]:
    scene, states = test.scene, test.geometry.states
    count = len(scene.particles.positions)
    left_out = "" if count <= _MOST_PARTICLES else f" ({_MOST_PARTICLES} of them are drawn)"
    return {
        "key": key,
        "name": plain(test.name),
        "solver": test.solver,
        "cost": test.cost_text,
        "problem": plain(test.problem),
        "apparatus": [plain(line) for line in test.apparatus],
        "particles": count,
        "left_out": left_out,
        "glued_count": test.geometry.number_of_glued,
        "legend": [(_STATES[state], COLOURS[state]) for state in COLOURS if state in states],
        "stages": [(stage.name, stage_text(stage)) for stage in scene.stages],
        "walls": list(_walls(test)),
        "glued": [(b.name, counted(len(b.radii), "particle")) for b in test.geometry.glued],
        "box": box_text(scene),
    }


def _walls(test: PreviewedTest) -> Iterator[tuple[str, str]]:
    for name, wall in test.scene.all_walls().items():
        drawn = "" if name not in test.geometry.not_drawn else "; not drawn"
        yield name, f"{plain(wall_text(wall))}{drawn}"


def _scene(test: PreviewedTest) -> dict[str, Any]:
    """Return the data of the drawing in three dimensions."""
    geometry = test.geometry
    scale = DrawingScale.of(geometry.corners)
    table = np.column_stack([geometry.positions, geometry.radii])
    every = -(-len(table) // (_MOST_PARTICLES * geometry.each))
    shown = table.reshape(-1, geometry.each, 4)[::every].reshape(-1, 4)
    walls, glued = geometry.walls, geometry.glued
    return {
        "particles": scale.packed(shown),
        "outlines": scale.outlines(edge for wall in walls for edge in wall.edges),
        "walls": [scale.wall(wall.triangles, COLOURS[wall.state]) for wall in walls],
        "glued": [scale.glued(b.positions, b.radii, COLOURS[b.state]) for b in glued],
        "dimensions": [[*scale.listed(line), words] for words, line in _dimensions(test)],
        "arrows": [[*scale.listed(arrow), COLOURS["moving"]] for arrow in geometry.arrows],
    }


def _dimensions(test: PreviewedTest) -> Iterator[tuple[str, Array]]:
    """Yield the dimensions of walls in words, each once, with a line beside the wall, m."""
    shapes = {name: wall.shape for name, wall in test.scene.all_walls().items()}
    told = set()
    for wall in test.geometry.walls:
        corners = wall.triangles.reshape(-1, 3)
        low, high = corners.min(axis=0), corners.max(axis=0)
        for axis, length, sign in _lengths(shapes[wall.name]):
            words = f"{sign}{millimetres(length)}"
            is_tube = isinstance(shapes[wall.name], Cylinder | Cone)
            front = (low[1] + high[1]) / 2 if is_tube and axis != 1 else low[1]
            start = np.array([high[0] if axis else low[0], front, low[2] if axis == 2 else high[2]])
            end = start.copy()
            end[axis] = high[axis]
            if words not in told:
                told.add(words)
                yield words, np.array([start, end])


def _lengths(shape: object) -> Iterator[tuple[int, float, str]]:
    """Yield the dimensions of a shape: axis, length, and a sign for diameters."""
    match shape:
        case Cylinder():
            yield 0, 2 * shape.radius, "⌀ "
            yield "xyz".index(shape.axis), shape.top - shape.bottom, ""
        case Cone():
            yield 0, 2 * max(shape.lower_radius, shape.upper_radius), "⌀ "
            yield 2, shape.top - shape.bottom, ""
        case Disc():
            yield 0, 2 * shape.radius, "⌀ "
        case Annulus():
            yield 0, 2 * shape.outer_radius, "⌀ "
        case Block() | Prism():
            sides = np.subtract(shape.high, shape.low)
            axis = int(sides.argmax())
            yield axis, float(sides[axis]), ""
