"""A heap in a picture, turned upright, with the edge between its pixels.

A flat heap is 30 to 40 pixels high: an edge that jumps from pixel to pixel tilts its flanks by up
to 0.7 degrees. So the edge is kept as where a smooth field is zero, and turn, scale and stretch are
one step, onto parts of a pixel.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from grainfit.arrays import Array
from grainfit.measurement.silhouette import Silhouette
from grainfit.photographs.pictures import opencv

#: A heap is measured in so many parts of pixels over its width; most parts of one.
_WIDTH, _MOST_PARTS = 1600, 4
#: From the middle of a pixel, whose places are whole numbers, to its edge, where lengths begin.
_HALF = np.array([[1.0, 0.0, 0.5], [0.0, 1.0, 0.5], [0.0, 0.0, 1.0]])


def parts_of_pixel(width: float) -> int:
    """Return in how many parts each pixel of a heap is divided to either side.

    Parameters
    ----------
    width : float
        Of the heap, pixels.
    """
    return int(np.clip(round(_WIDTH / width), 1, _MOST_PARTS))


@dataclass(frozen=True)
class Upright:
    """A heap as a camera sees it that looks at its apex.

    Parameters
    ----------
    field : ndarray of float32 of shape (rows, columns)
        In the picture: positive within the heap, zero at its edge.
    turn : ndarray of shape (3, 3)
        Homography from the picture.
    size : tuple of int
        Columns and rows, in pixels of the picture.
    parts : int
        Of a pixel, to either side.
    """

    field: NDArray[np.float32]
    turn: Array
    size: tuple[int, int]
    parts: int

    def silhouette(
        self, stretch: float = 1.0, top: float | None = None, axis: float = 0.0
    ) -> Silhouette:
        """Return the silhouette, lengths in pixels of the picture.

        Parameters
        ----------
        stretch : float
            Factor of all heights.
        top : float, optional
            Height of the upper edge; that of the stretched picture if not given.
        axis : float
            Column at which the horizontal coordinate is 0.
        """
        columns = self.parts * self.size[0]
        rows = max(1, int(np.ceil(self.parts * stretch * self.size[1])))
        finer = np.diag([self.parts, self.parts * stretch, 1.0])
        turn = np.linalg.inv(_HALF) @ finer @ _HALF @ self.turn
        found = opencv().warpPerspective(self.field, turn, (columns, rows), borderValue=-1.0)
        bottom = (stretch * self.size[1] if top is None else top) - rows / self.parts
        return Silhouette(found > 0, 1 / self.parts, -axis, bottom)

    def place(self, place: tuple[float, float]) -> tuple[float, float]:
        """Return where a place of the picture is: from the left and from the upper edge."""
        found = _HALF @ self.turn @ np.array([*place, 1.0])
        return float(found[0] / found[2]), float(found[1] / found[2])

    def back(self, places: Array) -> Array:
        """Return columns and rows in the picture of places, shape (n, 2)."""
        turned = np.linalg.inv(_HALF @ self.turn)
        found = np.column_stack([places, np.ones(len(places))]) @ turned.T
        shown: Array = found[:, :2] / found[:, 2:]
        return shown


def mirrored(silhouette: Silhouette) -> Silhouette:
    """Return a silhouette as seen from behind."""
    right = silhouette.left + silhouette.image.shape[1] * silhouette.pixel_size
    return replace(silhouette, image=silhouette.image[:, ::-1], left=-right)
