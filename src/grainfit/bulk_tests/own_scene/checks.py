"""What is odd about the beginning and the filling of a scene, before its first run."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from grainfit.bulk_tests.checks import CheckedTest
from grainfit.bulk_tests.own_scene import messages
from grainfit.bulk_tests.own_scene.start import beside_all_tubes, without_wall_below
from grainfit.checks import Found, check
from grainfit.scenes.conditions import AtRest
from grainfit.scenes.records import Force, RadialForce
from grainfit.scenes.scene import Scene, Stage

#: Particles at an edge may be held by their neighbours.
_TOLERATED = 0.05


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
