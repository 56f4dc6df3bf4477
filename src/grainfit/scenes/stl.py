"""STL files as walls: read and checked triangles, in m."""

from __future__ import annotations

import math
import re
from codecs import BOM_UTF8
from collections.abc import Iterator
from dataclasses import dataclass
from functools import lru_cache
from itertools import chain
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from grainfit.errors import Fault, InputError
from grainfit.files import LARGEST_MESH, TooLargeError, read_within
from grainfit.messages import Message
from grainfit.scenes import messages
from grainfit.scenes.scene import Box
from grainfit.scenes.shapes import Mesh, Shape

#: More triangles than this are refused: solvers look at every one of them.
MOST_TRIANGLES = 200_000
_HEADER, _RECORD = 84, 50
_RECORD_TYPE = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
_VERTEX = re.compile(rb"^\s*vertex\s+(\S+)\s+(\S+)\s+(\S+)\s*$", re.MULTILINE | re.IGNORECASE)
_FACET = re.compile(rb"facet", re.IGNORECASE)
_END = re.compile(rb"\bendfacet\b", re.IGNORECASE)
#: Corners nearer than this are one, over the size of the mesh.
_SAME = 1e-6
#: Distance from a periodic side that counts as none, over the period.
_SIDE = 1e-6
#: A triangle whose height is below this, over its longest side, has no direction.
_SLIVER = 1e-6
#: A mesh this much larger than the box, or smaller, has another unit.
_TOO_LARGE, _TOO_SMALL = 50.0, 1e-3

Triangles = NDArray[np.float64]


@dataclass(frozen=True)
class StlContent:
    """Triangles of an STL file.

    Parameters
    ----------
    triangles : ndarray of shape (n, 3, 3)
        Corners, in the unit of the file; triangles without an area are left out.
    left_out : int
        Number of triangles without an area.
    """

    triangles: Triangles
    left_out: int

    @property
    def size(self) -> float:
        """Largest extent along an axis, in the unit of the file."""
        corners = self.triangles.reshape(-1, 3)
        return float((corners.max(axis=0) - corners.min(axis=0)).max())

    @property
    def is_closed(self) -> bool:
        """Whether every edge belongs to two triangles, so that there is an inside."""
        step = _SAME * self.size
        corners = np.round(self.triangles / step).astype(np.int64)
        _, numbers = np.unique(corners.reshape(-1, 3), axis=0, return_inverse=True)
        faces = numbers.reshape(-1, 3)
        edges = np.sort(np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]]))
        _, counts = np.unique(edges, axis=0, return_counts=True)
        return bool((counts == 2).all())


def read_stl(path: Path) -> StlContent:
    """Read an STL file, text or binary.

    Raises
    ------
    InputError
        It cannot be read, is no STL file, is damaged, or has no triangle or too many.
    """
    try:
        found = path.stat()
        return _read(path, found.st_mtime_ns, found.st_size)
    except TooLargeError as error:
        raise _error(path, messages.MESH_TOO_LARGE, reason=error.strerror) from error
    except OSError as error:
        raise _error(path, messages.MESH_UNREADABLE, reason=error.strerror or error) from error


@lru_cache(maxsize=8)
def _read(path: Path, _changed: int, _size: int) -> StlContent:
    content = read_within(path, LARGEST_MESH)
    triangles = _binary(path, content)
    if triangles is None:
        triangles = _text(path, content)
    if not len(triangles):
        raise _error(path, messages.MESH_EMPTY)
    if len(triangles) > MOST_TRIANGLES:
        raise _error(path, messages.MESH_TOO_FINE, count=len(triangles), most=MOST_TRIANGLES)
    if not np.isfinite(triangles).all() or np.abs(triangles).max() > 1e9:
        raise _error(path, messages.MESH_CORNERS)
    good = _has_area(triangles)
    if not good.any():
        raise _error(path, messages.MESH_FLAT)
    return StlContent(triangles[good], int((~good).sum()))


def _binary(path: Path, content: bytes) -> Triangles | None:
    """Return the triangles of a binary file; None for a text file."""
    if len(content) >= _HEADER:
        count = int.from_bytes(content[80:84], "little")
        if len(content) == _HEADER + _RECORD * count:
            records = np.frombuffer(content, _RECORD_TYPE, count, _HEADER)
            return records["corners"].astype(np.float64)
    start = content.removeprefix(BOM_UTF8).lstrip()[:5]
    if start.lower() == b"solid" and _FACET.search(content):
        return None
    if len(content) < _HEADER:
        raise _error(path, messages.MESH_NO_STL)
    raise _error(path, messages.MESH_CUT_OFF, count=count)


def _text(path: Path, content: bytes) -> Triangles:
    found = _VERTEX.findall(content)
    if len(found) % 3 or len(found) != 3 * len(_END.findall(content)):
        raise _error(path, messages.MESH_DAMAGED)
    try:
        numbers = np.fromiter(map(float, chain.from_iterable(found)), np.float64, 3 * len(found))
        return numbers.reshape(-1, 3, 3)
    except ValueError:
        raise _error(path, messages.MESH_CORNERS) from None


def _has_area(triangles: Triangles) -> NDArray[np.bool_]:
    sides = triangles - np.roll(triangles, 1, axis=1)
    longest = np.linalg.norm(sides, axis=2).max(axis=1)
    double = np.linalg.norm(np.cross(sides[:, 0], sides[:, 1]), axis=1)
    good: NDArray[np.bool_] = double > _SLIVER * longest**2
    return good


def _error(path: Path, message: Message, **values: object) -> InputError:
    return InputError(message.fault("", **values), str(path))


def mesh_triangles(mesh: Mesh, box: Box) -> Triangles:
    """Return the triangles of a mesh in m; in a periodic box none is longer than a share of it.

    Raises
    ------
    InputError
        See `read_stl`.
    """
    triangles = mesh.scale * read_stl(mesh.path).triangles
    if not box.periodic:
        return triangles
    return divided(triangles[~_on_periodic_side(triangles, box)], box.longest_element)


def _on_periodic_side(triangles: Triangles, box: Box) -> NDArray[np.bool_]:
    """Find triangles in a periodic side of the box: there, the wall goes on."""
    found = np.zeros(len(triangles), dtype=bool)
    for axis, name in enumerate("xyz"):
        if name in box.periodic:
            low, high = box.low[axis], box.high[axis]
            near = _SIDE * (high - low)
            for side in (low, high):
                found |= (np.abs(triangles[:, :, axis] - side) < near).all(axis=1)
    return found


def divided(triangles: Triangles, longest: float) -> Triangles:
    """Return triangles halved until no side is longer than a length.

    Parameters
    ----------
    triangles : ndarray of shape (n, 3, 3)
        Corners.
    longest : float
        Largest length of a side.

    Raises
    ------
    InputError
        There would be too many.
    """
    sides = triangles[:, 1:] - triangles[:, :1]
    area = float(np.linalg.norm(np.cross(sides[:, 0], sides[:, 1]), axis=1).sum() / 2)
    if area > MOST_TRIANGLES * math.sqrt(3) / 4 * longest**2:
        raise InputError(messages.MESH_PERIOD.fault("mesh"))
    done = []
    while len(triangles):
        sides = np.linalg.norm(triangles - np.roll(triangles, -1, axis=1), axis=2)
        long = sides.max(axis=1) > longest
        done.append(triangles[~long])
        rest, worst = triangles[long], sides[long].argmax(axis=1)
        at = np.arange(len(rest))
        a, b, c = (rest[at, (worst + n) % 3] for n in range(3))
        middle = (a + b) / 2
        triangles = np.concatenate(
            (np.stack((a, middle, c), axis=1), np.stack((middle, b, c), axis=1))
        )
    return np.concatenate(done)


def mesh_faults(key: str, shape: Shape, box: Box) -> Iterator[Fault]:
    """Yield why an STL file cannot be a wall of the box: damaged, elsewhere, or of another unit."""
    if not isinstance(shape, Mesh):
        return
    if not shape.scale > 0:
        yield messages.MESH_SCALE.fault(key, scale=shape.scale)
        return
    try:
        corners = shape.scale * read_stl(shape.path).triangles.reshape(-1, 3)
    except InputError as error:
        yield from (Fault(key, f"{error.source} {f.message}", f.remedy) for f in error.faults)
        return
    elsewhere = [*_place_faults(key, shape.path.name, corners, box)]
    if elsewhere:
        yield from elsewhere
        return
    try:
        mesh_triangles(shape, box)
    except InputError as error:
        name = shape.path.name
        yield from (Fault(key, f"{name} {f.message}", f.remedy) for f in error.faults)


def _place_faults(key: str, name: str, corners: NDArray[np.float64], box: Box) -> Iterator[Fault]:
    """Yield why a mesh with these corners, m, is no wall in the box: its size or its place."""
    low, high = corners.min(axis=0), corners.max(axis=0)
    size, room = float((high - low).max()), max(np.subtract(box.high, box.low))
    if size > _TOO_LARGE * room or size < _TOO_SMALL * room:
        yield messages.MESH_SIZE.fault(key, name=name, size=size, room=room)
    elif (low > box.high).any() or (high < box.low).any():
        yield messages.MESH_ELSEWHERE.fault(key, name=name)
    else:
        yield from _side_faults(key, name, low, high, box)


def _side_faults(
    key: str, name: str, low: NDArray[np.float64], high: NDArray[np.float64], box: Box
) -> Iterator[Fault]:
    """Yield where a mesh goes beyond the box: LIGGGHTS loses such triangles."""
    for axis, letter in enumerate("xyz"):
        near = _SIDE * (box.high[axis] - box.low[axis])
        if low[axis] >= box.low[axis] - near and high[axis] <= box.high[axis] + near:
            continue
        repeats = letter in box.periodic
        message = messages.MESH_BEYOND_PERIOD if repeats else messages.MESH_BEYOND
        yield message.fault(key, name=name, axis=letter)
