"""Page of a preview: every test in three dimensions, its stages and walls in words."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np

from grainfit.formatting import assigned, counted, in_a_row, plain
from grainfit.preview.geometry import Geometry, State
from grainfit.preview.previewed_test import PreviewedTest
from grainfit.preview.scene_picture import COLOURS
from grainfit.preview.scene_text import box_text, stage_text, wall_text
from grainfit.report.drawing_data import DrawingScale
from grainfit.report.package_page import package_page
from grainfit.report.rendering import script_json

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
        data=script_json({key: _scene(test.geometry) for key, test in keyed.items()}),
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


def _scene(geometry: Geometry) -> dict[str, Any]:
    """Return the data of the drawing in three dimensions."""
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
        "arrows": [[*scale.listed(arrow), COLOURS["moving"]] for arrow in geometry.arrows],
    }
