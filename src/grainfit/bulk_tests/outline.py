"""Outline of a bulk test's scene: what a solver must have, and the parts that have a wall."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from grainfit.bulk_tests.abilities import HasUserFunctions
from grainfit.bulk_tests.base import BulkTest
from grainfit.scenes.packing import Column
from grainfit.scenes.scene import Scene

#: A material to build a scene with when only its concepts matter: they follow from the options.
_ANY_MATERIAL: Mapping[str, float] = {
    "particle.density": 2500.0,
    "particle.youngs_modulus": 5e6,
    "particle.poissons_ratio": 0.25,
    "particle_particle.sliding_friction": 0.5,
    "particle_particle.rolling_friction": 0.1,
}


def concepts(test: BulkTest, material: Mapping[str, float] | None = None) -> set[str]:
    """Return the concepts of a test's scene that a solver must have, see `Scene.concepts`.

    Parameters
    ----------
    test : BulkTest
        The test.
    material : mapping of str to float, optional
        All material parameters: without them, nothing is known of a scene of the user.
    """
    if isinstance(test, HasUserFunctions):
        return set() if material is None else test.planned(material).concepts()
    return _without_particles(test).concepts() | ({"clumps"} if test.sizes.shape else set())


def scene_parts(test: BulkTest, material: Mapping[str, float]) -> Mapping[str, tuple[str, ...]]:
    """Return the parts of a test's scene, each with its walls, see `BulkTest.parts`."""
    if test.parts is not None:
        return test.parts
    if isinstance(test, HasUserFunctions):
        return walls_as_parts(test.planned(material))
    return walls_as_parts(_without_particles(test))


def walls_as_parts(scene: Scene) -> dict[str, tuple[str, ...]]:
    """Return every wall of a scene as a part."""
    return {name: (name,) for name in scene.all_walls()}


def _without_particles(test: BulkTest) -> Scene:
    """Return the experiment without particles, which take long to place when they are many."""
    empty = Column(np.empty((0, 3)), np.empty(0, dtype=np.int64), test.sizes.sauter_diameter)
    return test.scene_of(empty, _ANY_MATERIAL)
