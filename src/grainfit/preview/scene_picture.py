"""Picture of a scene from above and aside: shaded particles between translucent walls."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageDraw

from grainfit.arrays import Array
from grainfit.measurement.sheet import OVERSAMPLING, height_colour
from grainfit.preview.geometry import DrawnWall, Geometry, State

#: Directions of view, as in the report: radians about the z axis, and above the horizon.
AZIMUTH, ELEVATION = 0.5, 0.35
#: Colours of walls and glued sets by state: slate, vermilion, bluish green (after Okabe & Ito).
COLOURS: Mapping[State, tuple[int, int, int]] = {
    "still": (120, 134, 150),
    "moving": (213, 94, 0),
    "later": (0, 158, 115),
}
#: Colours of pixels; single precision is enough.
Colours = NDArray[np.float32]
#: Rows and columns of a part of a picture.
Window = tuple[slice, slice]
_HIGHEST = 640 * OVERSAMPLING
_FRONT, _BACK = 0.16, 0.34
_EDGE = 0.75
_MARGIN = 8 * OVERSAMPLING
_LIGHT = np.array([-0.35, -0.55, 0.76])


@dataclass(frozen=True)
class _Camera:
    """Parallel projection onto pixels; depths grow away from the eye, m."""

    scale: float
    offset: tuple[float, float]
    size: tuple[int, int]

    @classmethod
    def of(cls, points: Array, width: int) -> _Camera:
        """Return the camera that shows all points in a width, pixels."""
        flat = _seen(points)
        low, high = flat[:, :2].min(axis=0), flat[:, :2].max(axis=0)
        room = np.maximum(high - low, 1e-12)
        scale = min((width - 2 * _MARGIN) / room[0], (_HIGHEST - 2 * _MARGIN) / room[1])
        height = math.ceil(room[1] * scale) + 2 * _MARGIN
        left = (width - room[0] * scale) / 2 - low[0] * scale
        return cls(scale, (left, _MARGIN + high[1] * scale), (width, height))

    def place(self, points: Array) -> Array:
        """Return columns, rows and depths of points, shape (..., 3)."""
        flat = _seen(points)
        column = self.offset[0] + flat[..., 0] * self.scale
        row = self.offset[1] - flat[..., 1] * self.scale
        return np.stack([column, row, flat[..., 2]], axis=-1)


def _seen(points: Array) -> Array:
    """Return points as across, up and away from the eye, m."""
    ca, sa = math.cos(AZIMUTH), math.sin(AZIMUTH)
    ce, se = math.cos(ELEVATION), math.sin(ELEVATION)
    across = points[..., 0] * ca + points[..., 1] * sa
    deep = points[..., 1] * ca - points[..., 0] * sa
    return np.stack(
        [across, points[..., 2] * ce + deep * se, deep * ce - points[..., 2] * se], axis=-1
    )


def draw_geometry(geometry: Geometry, width: int) -> Image.Image:
    """Draw a scene in a width, oversampled pixels."""
    camera = _Camera.of(geometry.corners, width)
    shape = (camera.size[1], camera.size[0])
    colours, depth = _particles(geometry, camera, shape)
    near, far = _Layer(shape, np.inf), _Layer(shape, -np.inf)
    for wall in geometry.walls:
        _rasterise(wall, camera, near, far)
    picture = np.full((*shape, 3), 255.0, dtype=np.float32)
    _blend(picture, far, _BACK)
    covered = np.isfinite(depth)
    picture[covered] = colours[covered]
    _blend(picture, near, np.where(near.depth < depth, _FRONT, 0.0))
    for wall in geometry.walls:
        _draw_edges(picture, wall, camera, depth)
    image = Image.fromarray(np.clip(picture, 0, 255).astype(np.uint8))
    _draw_arrows(ImageDraw.Draw(image), geometry.arrows, camera)
    return image


class _Layer:
    """Depth and colour of the nearest or farthest wall in every pixel."""

    def __init__(self, shape: tuple[int, int], empty: float) -> None:
        self.depth = np.full(shape, empty)
        self.colours = np.zeros((*shape, 3), dtype=np.float32)

    def put(self, where: Window, better: NDArray[np.bool_], z: Array, c: Array) -> None:
        """Set depth and colour of some pixels of a rectangle."""
        self.depth[where][better] = z[better]
        self.colours[where][better] = c


def _blend(picture: Colours, layer: _Layer, alpha: Array | float) -> None:
    share = np.where(np.isfinite(layer.depth), alpha, 0.0).astype(np.float32)[..., None]
    picture *= 1 - share
    picture += share * layer.colours


def _particles(
    geometry: Geometry, camera: _Camera, shape: tuple[int, int]
) -> tuple[Colours, Array]:
    """Return colours and depths of the particles in every pixel; infinite where there is none."""
    depth = np.full(shape, np.inf)
    colours = np.zeros((*shape, 3), dtype=np.float32)
    highest = max(float(geometry.positions[:, 2].max(initial=0.0)), 1e-12)
    for positions, radii, state in geometry.spheres:
        for place, height, radius in zip(
            camera.place(positions), positions[:, 2], radii.tolist(), strict=True
        ):
            colour = np.array(COLOURS[state], dtype=float) if state else None
            if colour is None:
                colour = height_colour(float(height) / highest)
            _draw_sphere(colours, depth, place, (radius, radius * camera.scale), colour)
    return colours, depth


def _draw_sphere(
    colours: Colours, depth: Array, place: Array, radius: tuple[float, float], colour: Array
) -> None:
    """Draw a shaded sphere, given by column, row and depth and its radius, where nothing is nearer.

    The radius is in m and in pixels.
    """
    (column, row, away), size = place, max(1.0, radius[1])
    where = _window(column - size, column + size, row - size, row + size, depth.shape)
    rows, columns = np.mgrid[where]
    u, v = (columns - column) / size, (rows - row) / size
    bulge = np.sqrt(np.maximum(1 - u**2 - v**2, 0))
    z = away - radius[0] * bulge
    better = (u**2 + v**2 <= 1) & (z < depth[where])
    depth[where][better] = z[better]
    shade = np.clip(0.45 + 0.75 * (bulge * 0.75 - 0.4 * u * 0.6 - 0.6 * v * 0.7), 0.35, 1.2)
    colours[where][better] = shade[better][:, None] * colour


def _window(left: float, right: float, top: float, bottom: float, shape: tuple[int, int]) -> Window:
    rows = slice(max(0, math.floor(top)), min(shape[0], math.ceil(bottom) + 1))
    columns = slice(max(0, math.floor(left)), min(shape[1], math.ceil(right) + 1))
    return rows, columns


def _rasterise(wall: DrawnWall, camera: _Camera, near: _Layer, far: _Layer) -> None:
    normals = np.cross(
        wall.triangles[:, 1] - wall.triangles[:, 0], wall.triangles[:, 2] - wall.triangles[:, 0]
    )
    normals /= np.maximum(np.linalg.norm(normals, axis=1), 1e-300)[:, None]
    shades = 0.75 + 0.45 * np.abs(normals @ _LIGHT)
    colour = np.array(COLOURS[wall.state], dtype=float)
    for corners, shade in zip(camera.place(wall.triangles), shades, strict=True):
        _rasterise_triangle(corners, shade * colour, near, far)


def _rasterise_triangle(corners: Array, colour: Array, near: _Layer, far: _Layer) -> None:
    (x1, y1, z1), (x2, y2, z2), (x3, y3, z3) = corners
    area = (x2 - x1) * (y3 - y1) - (x3 - x1) * (y2 - y1)
    if abs(area) < 1e-9:
        return
    columns, rows = corners[:, 0], corners[:, 1]
    where = _window(columns.min(), columns.max(), rows.min(), rows.max(), near.depth.shape)
    row, column = np.mgrid[where]
    second = ((column - x1) * (y3 - y1) - (x3 - x1) * (row - y1)) / area
    third = ((x2 - x1) * (row - y1) - (column - x1) * (y2 - y1)) / area
    inside = (second >= 0) & (third >= 0) & (second + third <= 1)
    z = z1 + second * (z2 - z1) + third * (z3 - z1)
    near.put(where, inside & (z < near.depth[where]), z, colour)
    far.put(where, inside & (z > far.depth[where]), z, colour)


def _samples(edges: Array, camera: _Camera) -> Iterator[Array]:
    for start, end in camera.place(edges):
        count = max(2, math.ceil(float(np.abs(end - start)[:2].max())))
        yield start + np.linspace(0, 1, count)[:, None] * (end - start)


def _draw_edges(picture: Colours, wall: DrawnWall, camera: _Camera, depth: Array) -> None:
    """Draw the edges that no particle hides."""
    colour = 0.7 * np.array(COLOURS[wall.state], dtype=float)
    rows_, columns_ = depth.shape
    for points in _samples(wall.edges, camera):
        columns, rows = np.round(points[:, 0]).astype(int), np.round(points[:, 1]).astype(int)
        for shift in range(OVERSAMPLING):
            r, c = rows + shift, columns
            there = (r >= 0) & (r < rows_) & (c >= 0) & (c < columns_)
            r, c, z = r[there], c[there], points[there, 2]
            seen = z < depth[r, c]
            picture[r[seen], c[seen]] *= 1 - _EDGE
            picture[r[seen], c[seen]] += _EDGE * colour


def _draw_arrows(draw: ImageDraw.ImageDraw, arrows: Sequence[Array], camera: _Camera) -> None:
    for start, end in (camera.place(arrow)[:, :2] for arrow in arrows):
        along = end - start
        length = float(np.linalg.norm(along))
        if length < 1:
            continue
        along = along / length
        across = np.array([-along[1], along[0]])
        head = min(0.4 * length, 14 * OVERSAMPLING)
        neck = end - head * along
        draw.line([tuple(start), tuple(neck)], fill=COLOURS["moving"], width=4 * OVERSAMPLING)
        tip = [tuple(end), tuple(neck + 0.5 * head * across), tuple(neck - 0.5 * head * across)]
        draw.polygon(tip, fill=COLOURS["moving"])
