"""Simulated time of a scene, estimated from the ends of its stages."""

from __future__ import annotations

from grainfit.scenes.conditions import AtRest, Condition, Drained, Elapsed
from grainfit.scenes.scene import Scene

#: Beds come to rest soon after the first look, and long before the limit.
_AFTER_FIRST_LOOK = 1.25
_SHARE_OF_REST = 0.2
#: A tube is clear, and a load held, before the end of the travel or of the limit.
_SHARE_OF_LIMIT = 0.6


def expected_duration(scene: Scene) -> float:
    """Estimate the simulated time of a run, s: within a factor of two for most scenes."""
    return sum(max(_expected(stage.until), scene.check_interval) for stage in scene.stages)


def _expected(until: Condition) -> float:
    if isinstance(until, Elapsed):
        return until.time
    if isinstance(until, AtRest | Drained):
        return max(_AFTER_FIRST_LOOK * until.at_least, _SHARE_OF_REST * until.limit)
    return _SHARE_OF_LIMIT * until.limit
