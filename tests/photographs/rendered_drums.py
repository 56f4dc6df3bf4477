"""Pictures of turning drums with the truth known: light, glare, noise, tilt, a mark on the rim."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from PIL import Image
from scipy import ndimage

from grainfit.photographs.pictures import opencv
from tests.photographs.rendered_pictures import (
    Sheet,
    Spheres,
    _developed,
    _sheet,
    paint,
    rolled,
)

Array = NDArray[np.float64]
Colour = tuple[float, float, float]


@dataclass(frozen=True)
class DrumShot:
    """A drum whose front is at x = 0, its axis along x, seen along +x; lengths in its radius."""

    #: Places of the particles in every frame, shape (frames, particles, 3), and their radii.
    places: Array
    radii: Array
    length: float = 0.6
    #: Turn of the drum from frame to frame, rad, and time between two, s.
    step: float = 2 * math.pi / 120
    interval: float = 0.05
    #: By which the camera is beside the axis, above it, and rolled clockwise, degrees.
    yaw: float = 0.0
    pitch: float = 0.0
    roll: float = 0.0
    distance: float = 7.0
    size: tuple[int, int] = (480, 360)
    #: Radius of the drum in the picture, over half its height.
    share: float = 0.75
    aim: tuple[float, float] = (0.0, 0.0)
    rim: float = 1.12
    colour: Colour = (0.85, 0.8, 0.7)
    colour_spread: float = 0.06
    gloss: float = 0.0
    back: Colour = (0.08, 0.09, 0.1)
    rim_colour: Colour = (0.4, 0.42, 0.45)
    backdrop: Colour = (0.2, 0.22, 0.25)
    table: Colour = (0.3, 0.25, 0.2)
    mark: Colour | None = (0.7, 0.1, 0.1)
    #: Lit from behind: what it is made of is dark.
    ambient: float = 0.5
    light: tuple[float, float, float] = (-1.0, -0.4, 0.8)
    #: Brightness, place and width of a reflection in the glass.
    glare: float = 0.0
    glare_at: tuple[float, float] = (-0.3, 0.4)
    glare_width: float = 0.12
    uneven: float = 0.0
    vignette: float = 0.0
    blur: float = 0.6
    noise: float = 0.01
    quality: int = 100
    mirrored: bool = False
    #: Shift of the camera from frame to frame, over the radius.
    moves: float = 0.0
    sheet: Sheet | None = None
    seed: int = 0


def _camera(shot: DrumShot) -> tuple[Array, Array]:
    yaw, pitch, roll = (math.radians(angle) for angle in (shot.yaw, shot.pitch, shot.roll))
    forward = np.array(
        [math.cos(pitch) * math.cos(yaw), -math.cos(pitch) * math.sin(yaw), -math.sin(pitch)]
    )
    place = -shot.distance * forward
    right = np.cross(forward, [0, 0, 1.0])
    right /= np.linalg.norm(right)
    down = np.cross(forward, right)
    return place, np.array([*rolled(right, down, roll), forward])


def render_drum(shot: DrumShot, number: int) -> Image.Image:
    """Render a frame."""
    rng = np.random.default_rng([shot.seed, number])
    width, height = shot.size
    place, axes = _camera(shot)
    focal = shot.share * height / 2 * shot.distance
    middle = np.array([width * (0.5 + shot.aim[0]), height * (0.5 + shot.aim[1])]) - 0.5
    middle[0] += shot.moves * number * shot.share * height / 2
    x = (np.arange(width) - middle[0]) / focal
    y = (np.arange(height) - middle[1]) / focal
    rays = x[None, :, None] * axes[0] + y[:, None, None] * axes[1] + axes[2]
    colours, depth, window = _still(shot, place, rays, number)
    centres = shot.places[number] * ([1, -1, 1] if shot.mirrored else 1)
    seen = (centres - place) @ axes.T
    across = focal * seen[:, 0] / seen[:, 2] + middle[0]
    down = focal * seen[:, 1] / seen[:, 2] + middle[1]
    radii = focal * shot.radii / seen[:, 2]
    light = axes @ (np.array(shot.light) / np.linalg.norm(shot.light))
    tints = np.random.default_rng(shot.seed).normal(size=(len(radii), 1))
    base = np.clip(np.array(shot.colour) * (1 + shot.colour_spread * tints), 0, 1)
    behind = np.where(window, 1e3, 0.0)
    inside = colours.copy()
    spheres = Spheres(across, down, radii, seen[:, 2], shot.radii, base)
    paint(spheres, light, shot.ambient, shot.gloss, inside, behind)
    colours = np.where(window[..., None], inside, colours)
    colours += _glare(shot, x, y)
    if shot.sheet is not None:
        colours, depth = _sheet(shot.sheet, place, rays, colours, depth)
    return _developed(colours, shot, rng)  # type: ignore[arg-type]


def _glare(shot: DrumShot, x: Array, y: Array) -> Array:
    """A reflection in the glass."""
    across, down = x[None, :] * shot.distance, y[:, None] * shot.distance
    square = (across - shot.glare_at[0]) ** 2 + (down + shot.glare_at[1]) ** 2
    spot: Array = shot.glare * np.exp(-square / (2 * shot.glare_width**2))[..., None]
    return spot


def _still(
    shot: DrumShot, place: Array, rays: Array, number: int
) -> tuple[Array, Array, NDArray[np.bool_]]:
    """Backdrop, table, rim with its mark, and the empty drum; and where its window is."""
    colours = np.empty(rays.shape)
    colours[:] = shot.backdrop
    depth = np.full(rays.shape[:2], 50.0)
    with np.errstate(divide="ignore", invalid="ignore"):
        table = (-1.25 - place[2]) / rays[..., 2]
        front = -place[0] / rays[..., 0]
    on_table = (table > 0) & (table < 3 * shot.distance)
    colours[on_table], depth[on_table] = shot.table, table[on_table]
    hit = place + front[..., None] * rays
    radius = np.hypot(hit[..., 1], hit[..., 2])
    window, rim = radius < 1, (radius >= 1) & (radius < shot.rim)
    colours[rim], depth[rim] = shot.rim_colour, front[rim]
    depth[window] = front[window]
    if shot.mark is not None:
        azimuth = np.arctan2(hit[..., 1] * (-1 if shot.mirrored else 1), -hit[..., 2])
        apart = (azimuth - number * shot.step + math.pi) % (2 * math.pi) - math.pi
        colours[rim & (np.abs(apart) < 0.08)] = shot.mark
    # The empty drum: its back, and its wall in its shade.
    back = place + ((shot.length - place[0]) / rays[..., 0])[..., None] * rays
    colours[window] = shot.back
    wall = window & (np.hypot(back[..., 1], back[..., 2]) > 1)
    colours[wall] = 0.7 * np.array(shot.back)
    grain = ndimage.gaussian_filter(
        np.random.default_rng(shot.seed).normal(size=rays.shape[:2]), 2.0
    )
    return colours * (1 + 0.03 * (grain / grain.std())[..., None]), depth, window


def save_video(shot: DrumShot, path: Path, frames: Any = None) -> None:
    """Write a video, at the intervals of the frames."""
    cv2 = opencv()
    writer = cv2.VideoWriter(
        str(path), cv2.VideoWriter_fourcc(*"mp4v"), 1 / shot.interval, shot.size
    )
    for number in range(len(shot.places)) if frames is None else frames:
        writer.write(np.asarray(render_drum(shot, number))[..., ::-1])
    writer.release()


def seen_from_the_front(
    x: Array, across: Array, heights: Array, radii: Array, radius: float
) -> tuple[Array, Array]:
    """Return places and radii of the particles that a camera before the drum sees, in its radius.

    Those deep in the bed behind three layers of others are left out.
    """
    places = np.stack([x, across, heights], axis=-1) / radius
    near = (places[..., 0] < 5 * np.median(radii) / radius).any(axis=0)
    turn = math.atan2(float(across.mean()), -float(heights.mean()))
    above = places[..., 2] * math.cos(turn) - places[..., 1] * math.sin(turn)
    top = float(np.quantile(above, 0.97))
    high = (above > top - 8 * np.median(radii) / radius).any(axis=0)
    kept = near | high
    return places[:, kept], radii[kept] / radius


__all__ = ["DrumShot", "render_drum", "save_video", "seen_from_the_front"]
