"""The heap and the wedges of a draw-down in one picture, seen through its front."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

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
from grainfit.messages import Message
from grainfit.photographs import messages
from grainfit.photographs.heap import particle_in
from grainfit.photographs.pictures import Picture, opencv
from grainfit.photographs.separation import separate

Mask = NDArray[np.bool_]

_REPOSE, _SHEAR = "angle_of_repose", "shear_angle"

#: Steps of lightness and of both hues, and least ratio of the frequencies of a colour in the heap
#: and beside it, from which it is that of the material; and others at which it may be.
_STEPS, _RATIO, _RATIOS = (16, 24, 24), 3.0, (1.5, 6.0)
#: How far the angles at these may be apart, and the two flanks of one draw-down, degrees.
_APART, _UNEQUAL = 1.5, 4.0
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
    _require_whole(rough)
    ratios = _ratios(picture.colours, rough)
    seen = _seen_at(ratios, rough, _RATIO)
    if diameters is not None and seen.no_wedges:
        raise NotMeasurableError(seen.no_wedges)
    diameter, unsure = particle_in(seen.heap), _SIZE
    if diameters is not None:
        between = np.flatnonzero(np.any(seen.wedges, axis=0).any(axis=0))
        diameter, unsure = float(np.ptp(between) + 1) / diameters, _KNOWN_SIZE
    others = [_seen_at(ratios, rough, ratio).beds(diameter) for ratio in _RATIOS]
    angles, parts = {}, {}
    lines: list[Array] = []
    no_wedges = seen.no_wedges
    for name, bed in seen.beds(diameter).items():
        try:
            found = bed.measure(diameter)
            _require_alike(found)
            outline = _unsure_outline(found, name, others, diameter)
            parts[name] = {**_parts(bed, found, diameter, unsure), "outline": outline}
        except NotMeasurableError as error:
            if name == _REPOSE:
                raise
            no_wedges = messages.NO_SHEAR_ANGLE(reason=error)
            continue
        angles[name] = found.value
        lines += bed.lines(found, diameter)
    masks = (seen.heap, *seen.wedges)
    return DrawDownInPicture(picture, angles, parts, masks, tuple(lines), no_wedges)


class _Bed(NamedTuple):
    """A surface whose inclination is measured: that of the heap, or that of both wedges.

    Parameters
    ----------
    measure : callable
        Measures it, with a particle diameter in pixels.
    middle, base : float
        Column and row of the origin of its places.
    """

    measure: Callable[[float], Inclination]
    middle: float
    base: float

    def lines(self, found: Inclination, diameter: float) -> list[Array]:
        """Return its fitted flanks, columns and rows."""
        lines = []
        for flank in found.flanks:
            ends = np.array([flank.start, flank.end])
            rows = self.base - ends[:, 1] - _ABOVE * diameter
            lines.append(np.column_stack([self.middle + ends[:, 0], rows]))
        return lines


@dataclass(frozen=True)
class _Seen:
    """Heap and wedges where colours from some ratio of frequencies on are those of the material."""

    heap: Mask
    wedges: tuple[Mask, ...]
    no_wedges: str

    @cached_property
    def floor(self) -> float:
        """Row of the floor."""
        return float(np.median(_lower(self.heap, np.flatnonzero(self.heap.any(axis=0)))))

    def beds(self, diameter: float) -> dict[str, _Bed]:
        """Return the surfaces by the angles that they have; of the wedges where they are seen."""
        axis = _axis(self.heap, self.floor)
        pile = _surface((self.heap,), axis, lambda _: self.floor, diameter)
        beds = {_REPOSE: _Bed(lambda d: inclination_of_pile(pile, d), axis, self.floor)}
        if self.wedges:
            shelf, (low, high) = _shelf(self.wedges)
            middle = (low + high) / 2
            above = _surface(self.wedges, middle, shelf, diameter)
            base = float(shelf(np.array([middle]))[0])
            beds[_SHEAR] = _Bed(lambda d: inclination_of_wedges(above, high - low, d), middle, base)
        return beds


def _seen_at(ratios: Array, rough: Mask, least: float) -> _Seen:
    """Return heap and wedges where a ratio is at least so much."""
    material = _labels(ratios > least, rough)
    overlap = np.bincount(material[rough])
    heap = material == int(overlap[1:].argmax()) + 1 if len(overlap) > 1 else rough
    _require_whole(heap)
    floor = float(np.median(_lower(heap, np.flatnonzero(heap.any(axis=0)))))
    try:
        return _Seen(heap, _wedges(material, heap, _axis(heap, floor)), "")
    except NotMeasurableError as error:
        return _Seen(heap, (), str(error))


def _parts(bed: _Bed, found: Inclination, diameter: float, unsure: float) -> dict[str, float]:
    """Return standard uncertainties of an angle by their source, degrees."""
    sizes = [bed.measure(factor * diameter).value for factor in (1 - unsure, 1 + unsure)]
    # A surface that is seen from above or from below looks flatter: tan a' = tan a cos e.
    tangent = math.tan(math.radians(found.value)) / math.cos(math.radians(_ELEVATION))
    return {
        "flanks": found.standard_error,
        "particle size": float(np.ptp([*sizes, found.value])) / 2,
        "elevation": math.degrees(math.atan(tangent)) - found.value,
        "picture": _PICTURE,
    }


def _unsure_outline(
    found: Inclination, name: str, others: Sequence[dict[str, _Bed]], diameter: float
) -> float:
    """Standard uncertainty of an angle by which colours are those of the material, degrees."""
    angles = [found.value]
    angles += [beds[name].measure(diameter).value for beds in others if name in beds]
    if np.ptp(angles) > _APART:
        raise NotMeasurableError(messages.UNSURE_OUTLINE(low=min(angles), high=max(angles)))
    return float(np.ptp(angles)) / 2


def _require_alike(found: Inclination) -> None:
    """Raise `NotMeasurableError` if the two flanks are not those of one draw-down."""
    low, high = sorted(flank.angle for flank in found.flanks)
    if high - low > _UNEQUAL:
        raise NotMeasurableError(messages.UNEQUAL_FLANKS(low=low, high=high, most=_UNEQUAL))


def _require_whole(mask: Mask, said: Message = messages.CUT_OFF) -> None:
    inner = mask[1:-1, 1:-1]
    if inner.sum() < mask.sum():
        raise NotMeasurableError(said())


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


def _ratios(colours: NDArray[np.uint8], heap: Mask) -> Array:
    """Return how much more frequent the colours of a picture are in a heap than beside it."""
    cv2 = opencv()
    lab = cv2.cvtColor(cv2.GaussianBlur(colours, (0, 0), 1.0), cv2.COLOR_RGB2LAB)
    steps = [(lab[..., k].astype(np.int64) * n) // 256 for k, n in enumerate(_STEPS)]
    cells = np.ravel_multi_index(tuple(steps), _STEPS)
    shape = _grain(heap)
    top = int(np.flatnonzero(heap.any(axis=1))[0])
    inside = cv2.erode(heap.astype(np.uint8), shape) > 0
    beside = ~(cv2.dilate(heap.astype(np.uint8), shape, iterations=2) > 0)
    beside[:top] = False
    frequencies = []
    for where in (inside, beside):
        counts = np.bincount(cells[where], minlength=math.prod(_STEPS)).reshape(_STEPS)
        smooth = ndimage.gaussian_filter(counts.astype(float), 0.7)
        frequencies.append(smooth / max(smooth.sum(), 1.0) + 1e-5)
    found: Array = (frequencies[0] / frequencies[1]).ravel()[cells]
    return found


def _labels(material: Mask, heap: Mask) -> NDArray[np.int32]:
    """Label the connected parts of material, without gaps and specks smaller than particles."""
    cv2, shape = opencv(), _grain(heap)
    closed = cv2.morphologyEx(material.astype(np.uint8), cv2.MORPH_CLOSE, shape)
    opened = cv2.morphologyEx(closed, cv2.MORPH_OPEN, shape)
    labels: NDArray[np.int32] = cv2.connectedComponents(opened, connectivity=4)[1]
    return labels


def _grain(heap: Mask) -> NDArray[np.uint8]:
    """Return a disc of about half a particle diameter."""
    size = 2 * max(1, round(particle_in(heap) / 4)) + 1
    found: NDArray[np.uint8] = opencv().getStructuringElement(opencv().MORPH_ELLIPSE, (size, size))
    return found


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
    for side in sides:
        _require_whole(side[0], messages.WEDGES_CUT_OFF)
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
