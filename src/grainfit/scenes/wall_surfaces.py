"""Put walls of a scene on surfaces of their own."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

from grainfit.scenes.scene import Scene, Wall


def on_surfaces(
    scene: Scene, surface_of: Mapping[str, str], materials: Mapping[str, Mapping[str, float]]
) -> Scene:
    """Return a scene with some of its walls on other surfaces.

    Parameters
    ----------
    scene : Scene
        The scene.
    surface_of : mapping of str to str
        Names of the new surfaces, by the names of walls; walls that the scene does not have do not
        matter.
    materials : mapping of str to mapping
        Material parameters of each new surface.
    """
    names = {new: _free_name(new, scene.surfaces) for new in materials}

    def moved(walls: Mapping[str, Wall]) -> dict[str, Wall]:
        return {
            name: replace(wall, surface=names[surface_of[name]]) if name in surface_of else wall
            for name, wall in walls.items()
        }

    stages = tuple(replace(stage, put=moved(stage.put)) for stage in scene.stages)
    surfaces = {**scene.surfaces, **{names[new]: dict(own) for new, own in materials.items()}}
    found = replace(scene, walls=moved(scene.walls), stages=stages, surfaces=surfaces)
    used = {wall.surface for wall in found.all_walls().values()}
    return replace(found, surfaces={n: own for n, own in surfaces.items() if n in used})


def _free_name(name: str, taken: Mapping[str, object]) -> str:
    """Return a name for a surface that the scene does not use for another one."""
    while name in taken:
        name = f"{name}_"
    return name
