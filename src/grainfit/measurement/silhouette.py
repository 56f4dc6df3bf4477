"""Silhouettes of a heap from the side, rendered from particles or photographed."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from grainfit.measurement.grid import require_grid
from grainfit.measurement.particles import Particles


@dataclass(frozen=True)
class Silhouette:
    """A boolean image of a heap seen from the side, and its position.

    A photograph becomes one by thresholding and by the size of its pixels.

    Parameters
    ----------
    image : ndarray of bool of shape (rows, columns)
        True where there is material; the first row is the uppermost, as in any picture.
    pixel_size : float
        Width and height of a pixel, m.
    left : float
        Horizontal coordinate of the image's left edge, m.
    bottom : float
        Height of the image's lower edge, m.
    """

    image: NDArray[np.bool_]
    pixel_size: float
    left: float = 0.0
    bottom: float = 0.0

    @property
    def columns(self) -> NDArray[np.float64]:
        """Horizontal coordinate of the middle of every column, shape (columns,), m."""
        middles = np.arange(0.5, self.image.shape[1], dtype=np.float64)
        return self.left + middles * self.pixel_size

    def outline(self) -> NDArray[np.float64]:
        """Height of the upper outline in every column, m; NaN where there is no material."""
        rows = self.image.shape[0]
        heights: NDArray[np.float64] = (
            self.bottom + (rows - np.argmax(self.image, axis=0)) * self.pixel_size
        )
        heights[~self.image.any(axis=0)] = np.nan
        return heights


def render_silhouette(
    particles: Particles,
    azimuth: float,
    half_width: float,
    height: float,
    pixel_size: float,
) -> Silhouette:
    """Render the silhouette of spheres in parallel projection.

    A pixel belongs to the silhouette when its middle lies in a sphere's disc.

    Parameters
    ----------
    particles : Particles
        The particles to render.
    azimuth : float
        Angle about the z axis between the x axis and the picture's horizontal axis, degrees.
    half_width : float
        The picture shows horizontal coordinates from ``-half_width`` to ``half_width``, m.
    height : float
        The picture shows heights from 0 to ``height``, m.
    pixel_size : float
        Width and height of a pixel, m; a twentieth of a particle diameter is fine enough.

    Returns
    -------
    Silhouette
        Its horizontal coordinate is ``x cos(azimuth) + y sin(azimuth)``.

    Raises
    ------
    NotMeasurableError
        It would have too many pixels.
    """
    require_grid("silhouette", 2 * half_width / pixel_size, height / pixel_size)
    columns = 2 * math.ceil(half_width / pixel_size)
    rows = math.ceil(height / pixel_size)
    left = -columns / 2 * pixel_size
    angle = math.radians(azimuth)
    across = particles.positions[:, :2] @ np.array([math.cos(angle), math.sin(angle)])
    centres = (across - left) / pixel_size - 0.5
    heights = particles.positions[:, 2] / pixel_size - 0.5
    radii = particles.radii / pixel_size

    # Every disc is a run of columns, and every column of it a run of rows: mark where the runs
    # begin and end, and the running sum counts the discs over each pixel.
    first = np.clip(np.ceil(centres - radii), 0, columns).astype(np.int64)
    last = np.clip(np.floor(centres + radii) + 1, 0, columns).astype(np.int64)
    widths = np.maximum(last - first, 0)
    require_grid("silhouette", float(widths.sum()))
    disc = np.repeat(np.arange(len(widths)), widths)
    column = np.arange(len(disc)) - np.repeat(np.cumsum(widths) - widths, widths) + first[disc]
    half_chord = np.sqrt(np.maximum(radii[disc] ** 2 - (column - centres[disc]) ** 2, 0.0))
    lower = np.clip(np.ceil(heights[disc] - half_chord), 0, rows).astype(np.int64)
    upper = np.clip(np.floor(heights[disc] + half_chord) + 1, 0, rows).astype(np.int64)
    cells = (rows + 1) * columns
    begins = np.bincount(lower * columns + column, minlength=cells)
    ends = np.bincount(np.maximum(upper, lower) * columns + column, minlength=cells)
    covered = np.cumsum((begins - ends).reshape(rows + 1, columns), axis=0)[:rows] > 0
    return Silhouette(covered[::-1], pixel_size, left)
