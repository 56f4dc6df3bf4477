"""Geometry of a scene to be drawn: particles, walls as triangles, arrows of motions."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Literal

import numpy as np

from grainfit.arrays import Array
from grainfit.errors import InputError
from grainfit.scenes.scene import Load, Scene, Velocity, Wall
from grainfit.scenes.triangles import Triangles, triangles_of

State = Literal["still", "moving", "later"]

#: Two triangles that meet at less than this have no visible edge, degrees.
_SMOOTH = 25.0
#: Corners nearer than this are one, over the size of the scene.
_SAME = 1e-6
#: Length of an arrow over the size of the scene.
_ARROW = 0.12


@dataclass(frozen=True)
class DrawnWall:
    """A wall to be drawn.

    Parameters
    ----------
    name : str
        As in the scene.
    state : {"still", "moving", "later"}
        Whether it moves in some stage, or is put by a later one.
    triangles : ndarray of shape (n, 3, 3)
        Corners, m.
    edges : ndarray of shape (m, 2, 3)
        Borders and sharp edges, m.
    arrows : ndarray of shape (k, 2, 3)
        Beginning and end of an arrow for each direction of its motions, m.
    """

    name: str
    state: State
    triangles: Triangles
    edges: Array
    arrows: Array

    def moved(self, shift: Array) -> DrawnWall:
        """Return the wall elsewhere."""
        there = (self.triangles + shift, self.edges + shift, self.arrows + shift)
        return DrawnWall(self.name, self.state, *there)


@dataclass(frozen=True)
class DrawnGlued:
    """A glued set to be drawn.

    Parameters
    ----------
    name : str
        As in the scene.
    state : {"still", "moving"}
        Whether it moves in some stage.
    positions : ndarray of shape (n, 3)
        Centres of its particles, m.
    radii : ndarray of shape (n,)
        m.
    arrows : ndarray of shape (k, 2, 3)
        Beginning and end of an arrow for each direction of its motions, m.
    """

    name: str
    state: State
    positions: Array
    radii: Array
    arrows: Array

    def moved(self, shift: Array) -> DrawnGlued:
        """Return the glued set elsewhere."""
        return replace(self, positions=self.positions + shift, arrows=self.arrows + shift)


@dataclass(frozen=True)
class Geometry:
    """A scene to be drawn, moved so that its middle is on the z axis and its lowest point at z = 0.

    Parameters
    ----------
    positions : ndarray of shape (n, 3)
        Centres of the spheres of loose particles, m.
    radii : ndarray of shape (n,)
        m.
    walls : tuple of DrawnWall
        Walls of all stages.
    not_drawn : tuple of str
        Walls whose shape cannot be drawn.
    glued : tuple of DrawnGlued
        Glued sets.
    each : int
        Number of spheres of each loose particle.
    shift : ndarray of shape (3,)
        By which it was moved, m.
    """

    positions: Array
    radii: Array
    walls: tuple[DrawnWall, ...]
    not_drawn: tuple[str, ...]
    glued: tuple[DrawnGlued, ...] = ()
    each: int = 1
    shift: Array = field(default_factory=lambda: np.zeros(3))

    @property
    def spheres(self) -> list[tuple[Array, Array, State | None]]:
        """Positions and radii of all particles; loose ones have no state."""
        sets = [(body.positions, body.radii, body.state) for body in self.glued]
        return [(self.positions, self.radii, None), *sets]

    @property
    def _bodies(self) -> tuple[DrawnWall | DrawnGlued, ...]:
        return (*self.walls, *self.glued)

    @property
    def number_of_glued(self) -> int:
        """Number of glued particles."""
        return sum(len(body.radii) for body in self.glued)

    @property
    def arrows(self) -> list[Array]:
        """Beginnings and ends of all arrows, each of shape (2, 3), m."""
        return [arrow for body in self._bodies for arrow in body.arrows]

    @property
    def states(self) -> set[State]:
        """States of walls and glued sets that there are."""
        return {body.state for body in self._bodies}

    @property
    def corners(self) -> Array:
        """Points that a picture must show, shape (n, 3), m."""
        points = [wall.triangles.reshape(-1, 3) for wall in self.walls]
        for positions, radii, _ in self.spheres:
            points += [positions - radii[:, None], positions + radii[:, None]]
        return np.concatenate([*points, *self.arrows])


def geometry_of(scene: Scene) -> Geometry:
    """Return the geometry of a scene at its beginning, with the walls of all stages."""
    radii = np.array(scene.sizes.diameters)[scene.particles.size_indices] / 2
    positions, each = scene.particles.positions, 1
    if scene.clumps is not None:
        (positions, radii), each = scene.particles.outlines(scene.clumps), len(scene.clumps.clump)
    found: dict[str, Triangles] = {}
    not_drawn = []
    for name, wall in scene.all_walls().items():
        triangles = _triangles(wall, scene)
        if triangles is None:
            not_drawn.append(name)
        else:
            found[name] = triangles
    there = [positions, *_points(found), *(body.positions for body in scene.glued.values())]
    size = float(np.ptp(np.concatenate(there), axis=0).max())
    walls = [_drawn(scene, name, triangles, size) for name, triangles in found.items()]
    glued = [_drawn_glued(scene, name, size) for name in scene.glued]
    return _centred(Geometry(positions, radii, tuple(walls), tuple(not_drawn), tuple(glued), each))


def _points(found: Mapping[str, Triangles]) -> list[Array]:
    return [triangles.reshape(-1, 3) for triangles in found.values()]


def _triangles(wall: Wall, scene: Scene) -> Triangles | None:
    """Return the triangles of a wall; None for a shape that has none."""
    try:
        return triangles_of(wall.shape, scene.box, 0.95 * scene.sizes.sauter_diameter)
    except InputError:
        raise
    except (AssertionError, AttributeError, ValueError):
        return None


def _drawn(scene: Scene, name: str, triangles: Triangles, size: float) -> DrawnWall:
    is_moving = any(scene.motions_of(name))
    state: State = "moving" if is_moving else "still" if name in scene.walls else "later"
    arrows = _arrows(scene, name, triangles.reshape(-1, 3), size)
    return DrawnWall(name, state, triangles, feature_edges(triangles, size), arrows)


def _drawn_glued(scene: Scene, name: str, size: float) -> DrawnGlued:
    body = scene.glued[name]
    radii = np.array(scene.sizes.diameters)[body.size_indices] / 2
    state: State = "moving" if any(scene.motions_of(name)) else "still"
    arrows = _arrows(scene, name, body.positions, size)
    # Within the set, an arrow of its colour is not seen: it begins at the side.
    directions = np.sign(np.diff(arrows, axis=1).round(12))
    sides = directions * np.ptp(body.positions, axis=0) / 2
    return DrawnGlued(name, state, body.positions, radii, arrows + sides)


def _arrows(scene: Scene, name: str, points: Array, size: float) -> Array:
    """Return arrows of the straight motions of a body, from the middle of its points."""
    middle = (points.min(axis=0) + points.max(axis=0)) / 2
    found = (_direction(motion) for motion in scene.motions_of(name))
    directions = dict.fromkeys(d for d in found if d is not None)
    arrows = [(middle, middle + _ARROW * size * np.array(d)) for d in directions]
    return np.array(arrows).reshape(len(arrows), 2, 3)


def _direction(motion: object) -> tuple[float, ...] | None:
    """Return the direction of a straight motion; None for any other."""
    if not isinstance(motion, Velocity | Load):
        return None
    amount = motion.speed if isinstance(motion, Velocity) else motion.force
    return tuple(float(np.sign(amount)) if axis == motion.along else 0.0 for axis in "xyz")


def feature_edges(triangles: Triangles, size: float) -> Array:
    """Return edges of one triangle alone, and those where two meet at a large angle.

    The ends of the edges have the shape (m, 2, 3). Corners that are much nearer to each other than
    the size of the scene are one.
    """
    normals = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
    normals /= np.maximum(np.linalg.norm(normals, axis=1), 1e-300)[:, None]
    corners = np.round(triangles.reshape(-1, 3) / (_SAME * size)).astype(np.int64)
    _, first, numbers = np.unique(corners, axis=0, return_index=True, return_inverse=True)
    faces = numbers.reshape(-1, 3)
    edges = np.sort(np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]]))
    owner = np.tile(np.arange(len(faces)), 3)
    unique, inverse, counts = np.unique(edges, axis=0, return_inverse=True, return_counts=True)
    order = np.argsort(inverse.ravel(), kind="stable")
    ends = np.cumsum(counts)
    one, other = owner[order[ends - counts]], owner[order[ends - 1]]
    # Neighbours may turn their sides differently: of an STL file, one does not know.
    aligned = np.abs((normals[one] * normals[other]).sum(axis=1))
    shown = (counts != 2) | (aligned < np.cos(np.radians(_SMOOTH)))
    found: Array = triangles.reshape(-1, 3)[first[unique[shown]]]
    return found


def _centred(geometry: Geometry) -> Geometry:
    points = geometry.corners
    shift = -(points.min(axis=0) + points.max(axis=0)) / 2
    shift[2] = -points[:, 2].min()
    return replace(
        geometry,
        positions=geometry.positions + shift,
        walls=tuple(wall.moved(shift) for wall in geometry.walls),
        glued=tuple(body.moved(shift) for body in geometry.glued),
        shift=geometry.shift + shift,
    )
