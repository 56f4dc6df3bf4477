"""The heap and the wedges of a draw-down in one picture, seen through its front."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from grainfit.arrays import Array
from grainfit.errors import NotMeasurableError
from grainfit.measurement.height_map import HeightMap
from grainfit.measurement.inclination import (
    Inclination,
    inclination_of_pile,
    inclination_of_wedges,
)
from grainfit.photographs import messages
from grainfit.photographs.heap import particle_in
from grainfit.photographs.pictures import Picture, opencv
from grainfit.photographs.separation import separate

Mask = NDArray[np.bool_]

#: Steps of lightness and of both hues, and least ratio of the frequencies of a colour in the heap
#: and beside it, from which it is that of the material.
_STEPS, _RATIO = (16, 24, 24), 3.0
#: Least area of a wedge, over that of the heap.
_WEDGE = 0.02
#: Columns at the ends of a wedge, over its width, in which its lower edge is not that of the shelf.
_ENDS = 0.1
#: An outline is that of the highest particles, and lies so far above the mean surface of a bed that
#: is 8 diameters deep, in diameters (0.8 on simulated draw-downs, 0.65 where one layer lies);
#: flanks would else end where single particles lie beyond the foot.
_ABOVE = 0.7
#: Depth of the material as far as a picture tells, in diameters: one independent flank.
_DEPTH = 10.0
#: Standard uncertainty of the particle diameter by the roughness, and by the width of the box,
#: relative; of the elevation of the camera, degrees; and of an angle by pixels and lens, degrees.
_SIZE, _KNOWN_SIZE, _ELEVATION, _PICTURE = 0.5, 0.1, 5.0, 0.2


@dataclass(frozen=True)
class DrawDownInPicture:
    """What was measured on one picture of a draw-down. Lengths are in pixels.

    Parameters
    ----------
    picture : Picture
        In its working size.
    angles : dict
        Angle of repose of the lower heap, and shear angle of the wedges where they are seen,
        degrees.
    parts : dict
        Standard uncertainties of each by their source, degrees.
    masks : tuple of ndarray of bool
        The heap, and the wedges.
    lines : tuple of ndarray of shape (2, 2)
        Fitted flanks, columns and rows.
    no_wedges : str
        Why there is no shear angle; empty if there is one.
    """

    picture: Picture
    angles: dict[str, float]
    parts: dict[str, dict[str, float]]
    masks: tuple[Mask, ...]
    lines: tuple[Array, ...]
    no_wedges: str


def measure_draw_down(picture: Picture, diameters: float | None = None) -> DrawDownInPicture:
    """Measure the angle of repose of the heap on the floor, and the shear angle above the shelf.

    Both are the means of two flanks that face each other, so that a rolled camera does not matter.

    Parameters
    ----------
    picture : Picture
        The end of a draw-down, from the front.
    diameters : float, optional
        Inner width of the box in particle diameters; by the roughness of the heap if not given.

    Raises
    ------
    NotMeasurableError
        There is no heap with two flanks, and why.
    """
    rough = separate(picture.colours).mask()
    material = _material(picture.colours, rough)
    overlap = np.bincount(material[rough])
    heap = material == int(overlap[1:].argmax()) + 1 if len(overlap) > 1 else rough
    columns = np.flatnonzero(heap.any(axis=0))
    floor = float(np.median(_lower(heap, columns)))
    axis = _axis(heap, floor)
    no_wedges = ""
    wedges: tuple[Mask, ...] = ()
    try:
        wedges = _wedges(material, heap, axis)
    except NotMeasurableError as error:
        no_wedges = str(error)
        if diameters is not None:
            raise
    diameter, unsure = particle_in(heap), _SIZE
    if diameters is not None:
        between = np.flatnonzero(np.any(wedges, axis=0).any(axis=0))
        diameter, unsure = float(np.ptp(between) + 1) / diameters, _KNOWN_SIZE
    angles, parts = {}, {}
    lines: list[Array] = []

    def keep(
        name: str, measure: Callable[[float], Inclination], middle: float, base: float
    ) -> None:
        found = measure(diameter)
        sizes = [measure(factor * diameter).value for factor in (1 - unsure, 1 + unsure)]
        angles[name] = found.value
        # A surface that is seen from above or from below looks flatter: tan a' = tan a cos e.
        tangent = math.tan(math.radians(found.value)) / math.cos(math.radians(_ELEVATION))
        parts[name] = {
            "flanks": found.standard_error,
            "particle size": float(np.ptp([*sizes, found.value])) / 2,
            "elevation": math.degrees(math.atan(tangent)) - found.value,
            "picture": _PICTURE,
        }
        for flank in found.flanks:
            ends = np.array([flank.start, flank.end])
            rows = base - ends[:, 1] - _ABOVE * diameter
            lines.append(np.column_stack([middle + ends[:, 0], rows]))

    surface = _surface((heap,), axis, lambda _: floor, diameter)
    keep("angle_of_repose", lambda d: inclination_of_pile(surface, d), axis, floor)
    if wedges:
        shelf, (low, high) = _shelf(wedges)
        middle = (low + high) / 2
        above = _surface(wedges, middle, shelf, diameter)
        base = float(shelf(np.array([middle]))[0])
        try:
            keep("shear_angle", lambda d: inclination_of_wedges(above, high - low, d), middle, base)
        except NotMeasurableError as error:
            no_wedges = messages.NO_SHEAR_ANGLE(reason=error)
    masks = (heap, *wedges)
    return DrawDownInPicture(picture, angles, parts, masks, tuple(lines), no_wedges)


def _lower(mask: Mask, columns: NDArray[np.int64]) -> Array:
    found: Array = mask.shape[0] - np.argmax(mask[::-1, columns], axis=0).astype(np.float64)
    return found


def _axis(heap: Mask, floor: float) -> float:
    """Column of the ridge: the middle of the heap over its upper half."""
    rows = np.flatnonzero(heap.any(axis=1))
    some = np.linspace(rows[0] + 0.2 * (floor - rows[0]), rows[0] + 0.6 * (floor - rows[0]), 9)
    middles = []
    for row in some.astype(int):
        columns = np.flatnonzero(heap[row])
        middles.append((columns[0] + columns[-1] + 1) / 2)
    return float(np.mean(middles))


def _surface(
    masks: tuple[Mask, ...],
    middle: float,
    ground: Callable[[Array], Array | float],
    diameter: float,
) -> HeightMap:
    """Return the mean surface of material above a ground, by its outline, as of one slice."""
    material = np.any(masks, axis=0)
    columns = np.flatnonzero(material.any(axis=0))
    every = np.arange(columns[0], columns[-1] + 1)
    tops = np.argmax(material[:, every], axis=0).astype(np.float64)
    x = every + 0.5
    above = np.maximum(ground(x) - tops - _ABOVE * diameter, 0.0)
    heights = np.where(material[:, every].any(axis=0), above, 0.0)
    return HeightMap(heights[None], x - middle, _DEPTH * diameter)


def _material(colours: NDArray[np.uint8], heap: Mask) -> NDArray[np.int32]:
    """Label the parts of the picture that have the colours of a heap, not those beside it."""
    cv2 = opencv()
    lab = cv2.cvtColor(cv2.GaussianBlur(colours, (0, 0), 1.0), cv2.COLOR_RGB2LAB)
    steps = [(lab[..., k].astype(np.int64) * n) // 256 for k, n in enumerate(_STEPS)]
    cells = np.ravel_multi_index(tuple(steps), _STEPS)
    size = 2 * max(1, round(particle_in(heap) / 4)) + 1
    shape = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (size, size))
    top = int(np.flatnonzero(heap.any(axis=1))[0])
    inside = cv2.erode(heap.astype(np.uint8), shape) > 0
    beside = ~(cv2.dilate(heap.astype(np.uint8), shape, iterations=2) > 0)
    beside[:top] = False
    frequencies = []
    for where in (inside, beside):
        counts = np.bincount(cells[where], minlength=math.prod(_STEPS)).reshape(_STEPS)
        smooth = ndimage.gaussian_filter(counts.astype(float), 0.7)
        frequencies.append(smooth / max(smooth.sum(), 1.0) + 1e-5)
    like = (frequencies[0] > _RATIO * frequencies[1]).ravel()[cells].astype(np.uint8)
    closed = cv2.morphologyEx(like, cv2.MORPH_CLOSE, shape)
    opened = cv2.morphologyEx(closed, cv2.MORPH_OPEN, shape)
    labels: NDArray[np.int32] = cv2.connectedComponents(opened, connectivity=4)[1]
    return labels


def _wedges(parts: NDArray[np.int32], heap: Mask, axis: float) -> tuple[Mask, ...]:
    """Return the material above the heap: one part on each side of the slot.

    Raises
    ------
    NotMeasurableError
        There are no two.
    """
    above = parts.copy()
    above[np.flatnonzero(heap.any(axis=1))[0] :] = 0
    areas = np.bincount(above.ravel())
    sides: tuple[list[Mask], list[Mask]] = ([], [])
    for label in np.flatnonzero(areas > _WEDGE * heap.sum()):
        if label:
            mask = above == label
            sides[int(np.nonzero(mask)[1].mean() > axis)].append(mask)
    if any(len(side) != 1 for side in sides):
        raise NotMeasurableError(messages.NO_WEDGES(left=len(sides[0]), right=len(sides[1])))
    return sides[0][0], sides[1][0]


def _shelf(wedges: tuple[Mask, ...]) -> tuple[Callable[[Array], Array], tuple[float, float]]:
    """Return the row of the shelf by column, and the ends of the slot."""
    places, rows, ends = [], [], []
    for wedge in wedges:
        columns = np.flatnonzero(wedge.any(axis=0))
        cut = round(_ENDS * len(columns))
        some = columns[cut : len(columns) - cut]
        places.append(some + 0.5)
        rows.append(_lower(wedge, some))
        ends.append((float(columns[0]), float(columns[-1] + 1)))
    line = np.polyfit(np.concatenate(places), np.concatenate(rows), 1)

    def shelf(x: Array) -> Array:
        found: Array = line[0] * x + line[1]
        return found

    return shelf, (ends[0][1], ends[1][0])
