"""Pictures of heaps of spheres with the truth known: light, shadow, background, noise, camera."""

from __future__ import annotations

import io
import math
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from PIL import Image
from scipy import ndimage

from grainfit.measurement.angle_of_repose import (
    angle_of_repose,
    angle_of_repose_in,
    heap_silhouette,
)
from grainfit.measurement.particles import Particles

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Sheet:
    """The marker sheet in a picture: its raster and where it is."""

    image: NDArray[np.uint8]
    width: float
    corner: tuple[float, float, float]
    #: Directions of its lower and its left edge.
    along: tuple[float, float, float]
    up: tuple[float, float, float]


@dataclass(frozen=True)
class Shot:
    """A picture of a heap that stands at the origin, seen along +y; lengths in m."""

    particles: Particles
    #: Of the camera above the horizontal, seen from the apex, degrees.
    elevation: float = 0.0
    roll: float = 0.0
    azimuth: float = 0.0
    #: Distance of the camera and focal length over the width of the picture.
    distance: float = 1.5
    focal: float = 1.0
    size: tuple[int, int] = (800, 600)
    #: By how much of its width the picture is aimed to the side of the heap, and above it.
    aim: tuple[float, float] = (0.0, 0.0)
    colour: tuple[float, float, float] = (0.85, 0.8, 0.7)
    colour_spread: float = 0.06
    gloss: float = 0.0
    backdrop: tuple[float, float, float] = (0.12, 0.12, 0.14)
    table: tuple[float, float, float] = (0.2, 0.22, 0.25)
    #: Relative change of the light across the picture, and of its dark corners.
    uneven: float = 0.0
    vignette: float = 0.0
    #: Relative scatter of the table's and the backdrop's brightness.
    texture: float = 0.02
    plate_radius: float = 0.0
    plate_colour: tuple[float, float, float] = (0.45, 0.46, 0.48)
    light: tuple[float, float, float] = (0.4, -0.6, 1.0)
    ambient: float = 0.45
    shadow: float = 0.5
    blur: float = 0.6
    noise: float = 0.01
    quality: int = 90
    sheet: Sheet | None = None
    #: A box before the right part of the picture, from here on, in widths from its middle.
    hidden: float | None = None
    seed: int = 0

    @property
    def focal_px(self) -> float:
        """Focal length, pixels."""
        return self.focal * self.size[0]


_THICKNESS = 0.012


def _camera(shot: Shot) -> tuple[Array, Array]:
    """Return the place of the camera, and its axes: right, down, forward."""
    e = math.radians(shot.elevation)
    top = _top(shot.particles)
    place = np.array([0.0, 0.0, top])
    place += shot.distance * np.array([0.0, -math.cos(e), math.sin(e)])
    forward = np.array([0.0, 0.0, 0.4 * top]) - place
    forward /= np.linalg.norm(forward)
    right = np.array([1.0, 0.0, 0.0])
    down = np.cross(forward, right)
    # The camera turns so that the heap is off the middle; then it rolls.
    across, upward = shot.aim[0] / shot.focal, shot.aim[1] / shot.focal
    forward = forward - across * right + upward * down
    forward /= np.linalg.norm(forward)
    right -= forward * (right @ forward)
    right /= np.linalg.norm(right)
    down = np.cross(forward, right)
    return place, np.array([*rolled(right, down, math.radians(shot.roll)), forward])


def rolled(right: Array, down: Array, roll: float) -> tuple[Array, Array]:
    """Return two axes of a camera that is rolled clockwise, rad."""
    return (
        math.cos(roll) * right + math.sin(roll) * down,
        -math.sin(roll) * right + math.cos(roll) * down,
    )


def _top(particles: Particles) -> float:
    return float((particles.positions[:, 2] + particles.radii).max())


def _turned(particles: Particles, azimuth: float) -> Array:
    a = math.radians(azimuth)
    turn = np.array([[math.cos(a), math.sin(a), 0], [-math.sin(a), math.cos(a), 0], [0, 0, 1]])
    turned: Array = particles.positions @ turn.T
    return turned


def render(shot: Shot) -> Image.Image:
    """Render a picture."""
    rng = np.random.default_rng(shot.seed)
    width, height = shot.size
    place, axes = _camera(shot)
    centres = _turned(shot.particles, shot.azimuth)
    light = np.array(shot.light) / np.linalg.norm(shot.light)
    colours, depth = _ground(shot, place, axes, centres, light, rng)
    seen = (centres - place) @ axes.T
    f = shot.focal_px
    across = f * seen[:, 0] / seen[:, 2] + width / 2 - 0.5
    down = f * seen[:, 1] / seen[:, 2] + height / 2 - 0.5
    radii = f * shot.particles.radii / seen[:, 2]
    base = np.array(shot.colour) * (1 + shot.colour_spread * rng.normal(size=(len(radii), 1)))
    spheres = Spheres(across, down, radii, seen[:, 2], shot.particles.radii, base)
    # The light in the axes of the camera.
    paint(spheres, axes @ light, shot.ambient, shot.gloss, colours, depth)
    if shot.hidden is not None:
        colours[height // 5 :, round(width * (0.5 + shot.hidden)) :] = (0.3, 0.1, 0.4)
    return _developed(colours, shot, rng)


class Spheres(NamedTuple):
    """Spheres before a camera: places and radii in pixels, depths and radii in m, colours."""

    across: Array
    down: Array
    pixels: Array
    depths: Array
    radii: Array
    colours: Array


def paint(
    spheres: Spheres, light: Array, ambient: float, gloss: float, colours: Array, depth: Array
) -> None:
    """Paint spheres into a picture and its depths, the nearest first."""
    height, width = depth.shape
    half = light + np.array([0.0, 0.0, -1.0])
    half /= np.linalg.norm(half)
    for i in np.argsort(spheres.depths):
        r, x, y = spheres.pixels[i], spheres.across[i], spheres.down[i]
        x0, x1 = max(0, math.ceil(x - r)), min(width, math.floor(x + r) + 1)
        y0, y1 = max(0, math.ceil(y - r)), min(height, math.floor(y + r) + 1)
        if x0 >= x1 or y0 >= y1:
            continue
        window = (slice(y0, y1), slice(x0, x1))
        if (depth[window] < spheres.depths[i] - spheres.radii[i]).all():
            continue
        nx = (np.arange(x0, x1) - x)[None, :] / r
        ny = (np.arange(y0, y1) - y)[:, None] / r
        square = 1 - nx**2 - ny**2
        nz = np.sqrt(np.maximum(square, 0))
        near = spheres.depths[i] - nz * spheres.radii[i]
        shown = (square >= 0) & (near < depth[window])
        if not shown.any():
            continue
        lit = np.maximum(nx * light[0] + ny * light[1] - nz * light[2], 0)
        shine = np.maximum(nx * half[0] + ny * half[1] - nz * half[2], 0) ** 40
        bright = ambient * (0.6 + 0.4 * nz) + (1 - ambient) * lit
        value = spheres.colours[i] * bright[..., None] + gloss * shine[..., None]
        depth[window] = np.where(shown, near, depth[window])
        colours[window] = np.where(shown[..., None], value, colours[window])


def _ground(
    shot: Shot, place: Array, axes: Array, centres: Array, light: Array, rng: np.random.Generator
) -> tuple[Array, Array]:
    """Backdrop, table, plate and sheet: colours and depths."""
    width, height = shot.size
    across = (np.arange(width) - width / 2 + 0.5) / shot.focal_px
    down = (np.arange(height) - height / 2 + 0.5) / shot.focal_px
    rays = across[None, :, None] * axes[0] + down[:, None, None] * axes[1] + axes[2]
    colours = np.empty((height, width, 3))
    colours[:] = shot.backdrop
    depth = np.full((height, width), 1e3)
    reach = 3 * float(np.abs(centres[:, 0]).max())
    floor = -_THICKNESS if shot.plate_radius else 0.0
    with np.errstate(divide="ignore", invalid="ignore"):
        table = (floor - place[2]) / rays[..., 2]
        top = -place[2] / rays[..., 2]
    hit = place + table[..., None] * rays
    on_table = (table > 0) & (hit[..., 1] < reach)
    colours[on_table] = shot.table
    depth[on_table] = table[on_table]
    darkness = _shadow(shot, centres, light)
    if shot.plate_radius:
        colours, depth = _plate(shot, place, rays, top, colours, depth)
    spot = place + top[..., None] * rays
    covered = (top > 0) & (np.hypot(spot[..., 0], spot[..., 1]) < (shot.plate_radius or reach))
    grid, step, left = darkness
    rows = np.clip(((spot[..., 1] - left) / step), 0, len(grid) - 1).astype(int)
    columns = np.clip(((spot[..., 0] - left) / step), 0, len(grid) - 1).astype(int)
    dark = np.where(covered, grid[rows, columns], 0.0)
    colours *= 1 - shot.shadow * dark[..., None]
    grain = ndimage.gaussian_filter(rng.normal(size=(height, width)), 2.0)
    colours *= 1 + shot.texture * (grain / grain.std())[..., None]
    if shot.sheet is not None:
        colours, depth = _sheet(shot.sheet, place, rays, colours, depth)
    return colours, depth


def _plate(
    shot: Shot, place: Array, rays: Array, top: Array, colours: Array, depth: Array
) -> tuple[Array, Array]:
    """A round plate whose upper face is at z = 0."""
    radius = shot.plate_radius
    spot = place + top[..., None] * rays
    face = (top > 0) & (np.hypot(spot[..., 0], spot[..., 1]) < radius)
    # Its side: the nearer crossing of each ray with the cylinder.
    a = rays[..., 0] ** 2 + rays[..., 1] ** 2
    b = place[0] * rays[..., 0] + place[1] * rays[..., 1]
    c = place[0] ** 2 + place[1] ** 2 - radius**2
    root = b**2 - a * c
    distance = (-b - np.sqrt(np.maximum(root, 0))) / a
    z = place[2] + distance * rays[..., 2]
    side = (root > 0) & (z < 0) & (z > -_THICKNESS)
    colours[side] = 0.6 * np.array(shot.plate_colour)
    depth[side] = distance[side]
    colours[face] = shot.plate_colour
    depth[face] = top[face]
    return colours, depth


def _shadow(shot: Shot, centres: Array, light: Array) -> tuple[Array, float, float]:
    """How much of the light the heap takes from each place of the plate."""
    step = float(np.median(shot.particles.radii)) / 2
    reach = 2.2 * float(np.abs(centres[:, :2]).max())
    cells = math.ceil(2 * reach / step)
    # Flat light would reach beyond the picture.
    steepness = max(light[2], 0.4)
    cast = centres[:, :2] - centres[:, 2:] * light[None, :2] / steepness
    places = np.clip(((cast + reach) / step).astype(int), 0, cells - 1)
    grid = np.zeros((cells, cells))
    grid[places[:, 1], places[:, 0]] = 1.0
    grid = ndimage.maximum_filter(grid, 5)
    return ndimage.gaussian_filter(grid, 4.0), step, -reach


def _sheet(
    sheet: Sheet, place: Array, rays: Array, colours: Array, depth: Array
) -> tuple[Array, Array]:
    corner, along, up = (np.array(v) for v in (sheet.corner, sheet.along, sheet.up))
    normal = np.cross(along, up)
    with np.errstate(divide="ignore", invalid="ignore"):
        distance = ((corner - place) @ normal) / (rays @ normal)
    spot = place + distance[..., None] * rays - corner
    rows, columns = sheet.image.shape
    scale = columns / sheet.width
    u, v = spot @ along * scale, rows - spot @ up * scale
    # One pixel of the picture covers many of the raster: mean over a few places.
    inside = (distance > 0) & (u >= 0) & (u < columns) & (v >= 0) & (v < rows)
    inside &= distance < depth
    smooth = ndimage.gaussian_filter(sheet.image.astype(float), 1.0)
    found = ndimage.map_coordinates(smooth, [v[inside] - 0.5, u[inside] - 0.5], order=1)
    colours[inside] = found[:, None] / 255 * 0.9 + 0.04
    depth[inside] = distance[inside]
    return colours, depth


def _developed(colours: Array, shot: Shot, rng: np.random.Generator) -> Image.Image:
    """Light, lens, sensor and JPEG."""
    height, width = colours.shape[:2]
    x = np.linspace(-1, 1, width)[None, :, None]
    y = np.linspace(-1, 1, height)[:, None, None]
    colours = colours * (1 + shot.uneven * x) * (1 - shot.vignette * (x**2 + y**2) / 2)
    colours = ndimage.gaussian_filter(colours, (shot.blur, shot.blur, 0))
    colours = np.clip(colours, 0, 1) ** (1 / 2.2)
    colours = colours + shot.noise * rng.normal(size=colours.shape)
    image = Image.fromarray((np.clip(colours, 0, 1) * 255).astype(np.uint8))
    if shot.quality >= 100:
        return image
    kept = io.BytesIO()
    image.save(kept, "JPEG", quality=shot.quality)
    return Image.open(kept).convert("RGB")


def save(shot: Shot, path: Any, *, exif: bool = False) -> None:
    """Write a picture, with the focal length in its EXIF data where asked for."""
    image = render(shot)
    tags = Image.Exif()
    if exif:
        width, height = shot.size
        # 35 mm equivalent: by the diagonal of the picture.
        tags.get_ifd(0x8769)[0xA405] = round(shot.focal * width / math.hypot(width, height) * 43.27)
    image.save(path, quality=97, exif=tags) if exif else image.save(path)


def generators(angle: float, elevation: float) -> float:
    """Azimuth by which the outline lies behind the sides of a cone, degrees."""
    ratio = math.tan(math.radians(elevation)) / math.tan(math.radians(angle))
    return math.degrees(math.asin(min(max(ratio, -1.0), 1.0)))


def true_angle(shot: Shot) -> float:
    """Return the angle that the same fit finds on true silhouettes of the flanks in view.

    A camera above the plate sees flanks that lie behind the sides: each is taken from the
    silhouette, from the side, in which it is a side.
    """
    particles = shot.particles
    reach = float(np.hypot(*particles.positions[:, :2].T).max()) + particles.diameter
    behind = generators(whole_angle(particles), shot.elevation)
    azimuths = [shot.azimuth + behind, shot.azimuth - behind]
    silhouettes = [heap_silhouette(particles, azimuth, reach) for azimuth in azimuths]
    size = particles.diameter
    views = angle_of_repose_in(silhouettes, azimuths, size, size).views
    flanks = [flank.angle for flank in (views[0].right, views[1].left) if flank is not None]
    return float(np.mean(flanks)) if len(flanks) == 2 else math.nan


def whole_angle(particles: Particles) -> float:
    """Return the angle of the whole heap, from all sides."""
    key = id(particles.positions)
    if key not in _WHOLE:
        _WHOLE[key] = (particles, _from_all_sides(particles))
    return _WHOLE[key][1]


#: Angles of whole heaps, with the heaps, so that these are not made again at the same place.
_WHOLE: dict[int, tuple[Particles, float]] = {}


def _from_all_sides(particles: Particles) -> float:
    reach = float(np.hypot(*particles.positions[:, :2].T).max()) + particles.diameter
    return angle_of_repose(particles, particles.diameter, reach, 12).value


def skin(particles: Particles, angle: float, depth: float = 2.0) -> Particles:
    """Return the particles near the surface of a cone: only these are seen."""
    z = particles.positions[:, 2]
    distance = np.hypot(*particles.positions[:, :2].T)
    slope = math.tan(math.radians(angle))
    base = float(distance.max())
    below = ((base - distance) * slope - z) * math.cos(math.radians(angle))
    return particles.select(below < depth * particles.diameter)


__all__ = ["Sheet", "Shot", "render", "replace", "save", "skin", "true_angle", "whole_angle"]
