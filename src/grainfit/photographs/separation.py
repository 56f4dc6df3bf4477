"""Separate a heap from what is behind and below it.

Colours are put into classes; of all unions of classes the one whose largest part looks most like a
cone that is seen from slightly above is the heap. Then its edge is found anew within a band, by
the difference from the colour just outside of the band, so that neither an uneven light nor the
line between table and backdrop matters.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from grainfit.errors import NotMeasurableError
from grainfit.photographs import messages
from grainfit.photographs.pictures import opencv

#: Length of the longer side in which classes of colours are looked for, pixels.
_COARSE = 320
_CLASSES = 6
#: A heap has this share of the picture at least and at most.
_AREA = (0.004, 0.6)
#: Least agreement of a part with a cone: area of the intersection over area of the union.
_LIKE_A_CONE = 0.87
#: Parts as like to a cone as the best but for this are compared by their contrast.
_AS_LIKE = 0.06
#: Contrast of a part with its surroundings from which it stands out; and how much higher the apex
#: is than the foot is deep: a plate alone is as high as deep.
_STANDS_OUT, _HIGHER = 1.5, 1.2
#: Particles of the heap that classes missed are looked for within this share of its width. Their
#: colours, in steps of so much lightness or hue, are this many times as frequent in the heap.
_AROUND, _COLOUR_STEP, _MORE_FREQUENT = 0.1, 4.0, 3.0
#: Share of the area of the largest heap from which another one is a second heap.
_SECOND = 0.3
#: Half the width of the band in which the edge is found, in pixels of the classes.
_BAND = 2.0
#: Colours are averaged over this share of the width of the heap.
_NEARBY = 0.03
#: What is thinner than this share of the width of the heap does not belong to it.
_SPIKE = 0.015
#: The edge is where this share of the difference between outside and inside is reached.
EDGE_LEVEL = 0.4
#: Least difference of inside and outside, in standard deviations of the outside.
_CONTRAST = 3.5
#: Least width of a heap, pixels.
_SMALLEST = 120

Mask = NDArray[np.bool_]
Array = NDArray[np.float32]
Places = NDArray[np.int64]


@dataclass(frozen=True)
class Separated:
    """A heap in a picture.

    Parameters
    ----------
    edge : ndarray of shape (rows, columns)
        Difference of every pixel from the colour outside of the heap, over the sum of this and
        of its difference from the colour inside.
    rough : ndarray of bool of shape (rows, columns)
        The heap, before its edge was found.
    band : ndarray of bool of shape (rows, columns)
        Where the edge is.
    """

    edge: Array
    rough: Mask
    band: Mask

    def mask(self, level: float = EDGE_LEVEL) -> Mask:
        """Return the heap whose edge is at a share of the difference."""
        cv2 = opencv()
        inside = self.rough & ~self.band
        found = (inside | (self.band & (self.edge > level))).astype(np.uint8)
        found = cv2.morphologyEx(found, cv2.MORPH_CLOSE, np.ones((5, 5), np.uint8))
        # A thin spike is the edge of a plate or of a table.
        size = max(3, round(_SPIKE * float(np.ptp(np.flatnonzero(inside.any(axis=0))))))
        spike = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (size, size))
        found = cv2.morphologyEx(found, cv2.MORPH_OPEN, spike)
        _, labels = cv2.connectedComponents(found)
        heap = labels == np.bincount(labels[inside]).argmax()
        return _filled(heap)

    def field(self, level: float = EDGE_LEVEL) -> Array:
        """Return what is positive within the heap, and zero at its edge, between two pixels."""
        mask = self.mask(level)
        flat = mask - np.float32(level)
        field = np.where(self.band, self.edge - np.float32(level), flat)
        # Gaps that were closed, and spikes that were taken away.
        found: Array = np.where(mask == (field > 0), field, flat)
        return found


def drawn_outline(corners: Sequence[tuple[float, float]], shape: tuple[int, int]) -> Separated:
    """Return the heap within an outline that was drawn by hand on a picture of some shape.

    Raises
    ------
    NotMeasurableError
        It is too small.
    """
    cv2 = opencv()
    found = np.zeros(shape, np.uint8)
    cv2.fillPoly(found, [np.round(np.array(corners)).astype(np.int32)], 1)
    inside = found.astype(bool)
    columns = np.flatnonzero(inside.any(axis=0))
    width = float(np.ptp(columns)) if len(columns) else 0.0
    if width < _SMALLEST:
        raise NotMeasurableError(messages.SMALL(width=width, needed=_SMALLEST))
    return Separated(np.zeros(shape, np.float32), inside, np.zeros(shape, np.bool_))


def separate(colours: NDArray[np.uint8]) -> Separated:
    """Separate the heap from the rest of a picture.

    Raises
    ------
    NotMeasurableError
        There is no heap, or more than one, or it is cut off or does not stand out.
    """
    cv2 = opencv()
    lab = cv2.cvtColor(colours.astype(np.float32) / 255, cv2.COLOR_RGB2LAB)
    rough = _rough_heap(lab)
    width = float(np.ptp(np.flatnonzero(rough.any(axis=0))))
    if width < _SMALLEST:
        raise NotMeasurableError(messages.SMALL(width=width, needed=_SMALLEST))
    half = max(4, round(_BAND * max(lab.shape) / _COARSE))
    nearby = max(half, round(_NEARBY * width))
    rows, columns = (np.flatnonzero(rough.any(axis=axis)) for axis in (1, 0))
    margin = 4 * nearby
    near = (
        slice(max(rows[0] - margin, 0), rows[-1] + margin),
        slice(max(columns[0] - margin, 0), columns[-1] + margin),
    )
    edge = np.zeros(rough.shape, np.float32)
    band = np.zeros_like(rough)
    edge[near], band[near] = _edge(
        cv2.GaussianBlur(lab[near], (0, 0), 0.8), rough[near], half, nearby
    )
    return Separated(edge, rough, band)


def _rough_heap(lab: Array) -> Mask:
    cv2 = opencv()
    rows, columns = lab.shape[:2]
    factor = _COARSE / max(rows, columns)
    size = (round(columns * factor), round(rows * factor))
    small = cv2.resize(lab, size, interpolation=cv2.INTER_AREA)
    small = cv2.bilateralFilter(small, 5, 6.0, 2.0)
    parts, from_above = _parts(small)
    if not parts or parts[0].likeness < _LIKE_A_CONE:
        if any(part.at_border and part.likeness > 0.8 for part in parts[:3]):
            raise NotMeasurableError(messages.CUT_OFF())
        if from_above:
            raise NotMeasurableError(messages.FROM_ABOVE())
        share = 100 * parts[0].likeness if parts else 0.0
        raise NotMeasurableError(messages.NO_HEAP(share=share, needed=100 * _LIKE_A_CONE))
    rivals = [p for p in parts if p.likeness > parts[0].likeness - _AS_LIKE]
    heap = _innermost(max(rivals, key=lambda part: part.contrast), parts)
    if heap.at_border:
        raise NotMeasurableError(messages.CUT_OFF())
    for other in parts:
        apart = not (other.mask & heap.mask).any()
        share = other.area / heap.area
        if apart and other.likeness > _LIKE_A_CONE and _SECOND < share < 1 / _SECOND:
            raise NotMeasurableError(messages.TWO_HEAPS(share=100 * min(share, 1 / share)))
    large = cv2.resize(
        _completed(small, heap.mask).astype(np.float32),
        (columns, rows),
        interpolation=cv2.INTER_LINEAR,
    )
    found: Mask = large > 0.5
    return found


def _completed(small: Array, heap: Mask) -> Mask:
    """Return the heap with what touches it and has its colours: classes miss single particles.

    A colour is that of the heap where it is more frequent in the heap than around it.
    """
    cv2 = opencv()
    width = float(np.ptp(np.flatnonzero(heap.any(axis=0))))
    reach = 2 * round(_AROUND * width) + 1
    around = cv2.dilate(heap.astype(np.uint8), np.ones((reach, reach), np.uint8)).astype(bool)
    beyond = around & ~cv2.dilate(heap.astype(np.uint8), np.ones((5, 5), np.uint8)).astype(bool)
    within = cv2.erode(heap.astype(np.uint8), np.ones((3, 3), np.uint8)).astype(bool)
    if not beyond.any() or not within.any():
        return heap
    cells = np.moveaxis(np.round(small / _COLOUR_STEP).astype(np.int64), -1, 0)
    cells -= cells.min(axis=(1, 2), keepdims=True)
    shape = tuple(int(top) + 1 for top in cells.max(axis=(1, 2)))
    flat = np.ravel_multi_index(tuple(cells), shape)
    counts = [np.bincount(flat[part], minlength=math.prod(shape)) for part in (within, beyond)]
    smooth = [ndimage.gaussian_filter(one.reshape(shape) / one.sum(), 1.0) for one in counts]
    alike = (smooth[0] > _MORE_FREQUENT * smooth[1] + 1e-6).reshape(-1)[flat] & around
    alike = cv2.morphologyEx(alike.astype(np.uint8), cv2.MORPH_OPEN, np.ones((2, 2), np.uint8)) > 0
    _, labels = cv2.connectedComponents((alike | heap).astype(np.uint8), connectivity=4)
    return _filled(labels == np.bincount(labels[heap]).argmax())


def _innermost(part: _Part, parts: list[_Part]) -> _Part:
    """Return the heap within a heap and the plate that it lies on."""
    within = [
        other
        for other in parts
        if other.likeness > _LIKE_A_CONE
        and other.contrast > _STANDS_OUT
        and 0.1 * part.area < other.area < 0.8 * part.area
        and (other.mask & part.mask).sum() > 0.97 * other.area
    ]
    return max(within, key=lambda other: other.contrast) if within else part


@dataclass(frozen=True)
class _Part:
    """A part of the picture whose colours belong together."""

    mask: Mask
    likeness: float
    contrast: float
    at_border: bool

    @property
    def area(self) -> int:
        return int(self.mask.sum())


def _parts(small: Array) -> tuple[list[_Part], bool]:
    """Return parts of the picture, those that are most like a cone first.

    And whether there is something that may be a heap seen from high above.
    """
    cv2 = opencv()
    cv2.setRNGSeed(1)
    samples = small.reshape(-1, 3).astype(np.float32)
    until = (cv2.TERM_CRITERIA_EPS + cv2.TERM_CRITERIA_MAX_ITER, 20, 0.5)
    _, labels, _ = cv2.kmeans(samples, _CLASSES, None, until, 2, cv2.KMEANS_PP_CENTERS)
    labels = labels.reshape(small.shape[:2])
    low, high = (share * labels.size for share in _AREA)
    found: list[_Part] = []
    seen: set[bytes] = set()
    from_above = False
    for union in range(1, 2**_CLASSES - 1):
        chosen = np.array([bool(union >> k & 1) for k in range(_CLASSES)])[labels]
        opened = cv2.morphologyEx(
            chosen.astype(np.uint8), cv2.MORPH_OPEN, np.ones((3, 3), np.uint8)
        )
        count, parts, stats, _ = cv2.connectedComponentsWithStats(opened, connectivity=4)
        for label in range(1, count):
            if not low <= stats[label, cv2.CC_STAT_AREA] <= high:
                continue
            mask = _filled(parts == label)
            key = np.packbits(mask).tobytes()
            if key in seen or mask.sum() > high:
                continue
            seen.add(key)
            likeness, height = _likeness(mask)
            contrast = _contrast(small, mask)
            if height < _HIGHER:
                from_above |= likeness > _LIKE_A_CONE and contrast > _STANDS_OUT
            elif likeness > 0.7:
                border = mask.copy()
                border[1:-1, 1:-1] = False
                found.append(_Part(mask, likeness, contrast, bool(border.any())))
    return sorted(found, key=lambda part: -part.likeness), from_above


def _filled(mask: Mask) -> Mask:
    """Return a mask without its holes."""
    cv2 = opencv()
    outlines, _ = cv2.findContours(mask.astype(np.uint8), cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
    filled = np.zeros(mask.shape, np.uint8)
    cv2.drawContours(filled, outlines, -1, 1, cv2.FILLED)
    return filled.astype(bool)


def _likeness(mask: Mask) -> tuple[float, float]:
    """Agreement of a mask with the picture of a cone, and its height over the depth of its foot.

    The picture of a cone is the hull of an ellipse and a point above it.
    """
    cv2 = opencv()
    rows, columns = np.nonzero(mask)
    left, right = float(columns.min()), float(columns.max())
    if right - left < 8:
        return 0.0, 0.0
    # The feet: the lowest places at the two ends.
    share = 0.03 * (right - left)
    at_left, at_right = columns < left + share, columns > right - share
    feet = np.array(
        [[left, np.median(rows[at_left])], [right, np.median(rows[at_right])]], np.float64
    )
    middle = feet.mean(axis=0)
    span = feet[1] - feet[0]
    roll = math.atan2(span[1], span[0])
    if abs(roll) > math.radians(15):
        return 0.0, 0.0
    down = np.array([-math.sin(roll), math.cos(roll)])
    along = np.array([math.cos(roll), math.sin(roll)])
    places = np.column_stack([columns, rows]) - middle
    heights = -(places @ down)
    top = float(heights.max())
    if top < 3:
        return 0.0, 0.0
    apex = middle + along * float((places @ along)[heights > 0.85 * top].mean())
    half = float(np.hypot(*span)) / 2
    turn = np.linspace(0, 2 * math.pi, 48)
    depth = max(-float(heights.min()), 0.0)
    foot = middle + half * np.outer(np.cos(turn), along) + depth * np.outer(np.sin(turn), down)
    best = 0.0
    # The apex in which the flanks meet lies above the rounded top.
    for rise in (1.0, 1.08, 1.16, 1.25):
        model = np.zeros(mask.shape, np.uint8)
        points = np.vstack([foot, apex - down * (rise * top)])
        hull = cv2.convexHull(np.round(4 * points).astype(np.int32))
        cv2.fillConvexPoly(model, hull, 1, shift=2)
        both = float((mask & (model > 0)).sum())
        best = max(best, both / float((mask | (model > 0)).sum()))
    return best, top / max(depth, 1.0)


def _contrast(small: Array, mask: Mask) -> float:
    """Difference of the colours just inside and just outside, over their scatter."""
    cv2 = opencv()
    shape = np.ones((5, 5), np.uint8)
    grey = mask.astype(np.uint8)
    inner = mask & ~cv2.erode(grey, shape).astype(bool)
    outer = cv2.dilate(grey, shape).astype(bool) & ~mask
    if not inner.any() or not outer.any():
        return 0.0
    apart = np.linalg.norm(small[inner].mean(axis=0) - small[outer].mean(axis=0))
    return float(apart / (np.linalg.norm(small[inner].std(axis=0)) + 2.0))


def _edge(lab: Array, rough: Mask, half: int, nearby: int) -> tuple[Array, Mask]:
    """Return how far each pixel differs from the colour outside of a band, and the band."""
    cv2 = opencv()
    shape = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (2 * half + 1, 2 * half + 1))
    grey = rough.astype(np.uint8)
    inside = cv2.erode(grey, shape).astype(bool)
    outside = ~cv2.dilate(grey, shape).astype(bool)
    if not inside.any() or not outside.any():
        raise NotMeasurableError(messages.CUT_OFF())
    band = ~inside & ~outside
    difference = _unlike_outside(lab, outside, half)
    # Scatter of the outside, and the difference that the inside has, both from nearby.
    ring = outside & cv2.dilate(band.astype(np.uint8), shape).astype(bool)
    noise = _spread(difference, ring, 3 * nearby)
    within = _extended(lab, inside, 2 * nearby)
    signal = np.linalg.norm(within - _extended(lab, outside, nearby), axis=2)
    _require_contrast(signal, noise, band, rough)
    apart = np.linalg.norm(lab - within, axis=2)
    # A difference below the scatter of the outside is grain of the background.
    shown = np.maximum(difference - 2.0 * noise, 0.0)
    return shown / np.maximum(shown + apart, 1e-3), band


def _unlike_outside(lab: Array, outside: Mask, half: int) -> Array:
    """Return the least difference of every pixel from what is outside of the heap around it.

    Backdrop, table and plate may all be near a place: the nearest colour alone would make the edge
    of a plate a part of the heap.
    """
    size = max(2, half // 3)
    means = _means(lab, outside, size)
    means[~outside] = np.inf
    reach = 2 * half
    padded = np.pad(means, ((reach, reach), (reach, reach), (0, 0)), constant_values=np.inf)
    rows, columns = outside.shape
    steps = sorted({round(share * half) for share in (-2, -1.3, -0.6, 0, 0.6, 1.3, 2)})
    least = np.full(outside.shape, np.inf, np.float32)
    for down in steps:
        for across in steps:
            top, left = reach + down, reach + across
            shifted = padded[top : top + rows, left : left + columns]
            least = np.fmin(least, ((lab - shifted) ** 2).sum(axis=2))
    nearest = ((lab - _extended(lab, outside, size)) ** 2).sum(axis=2)
    found: Array = np.sqrt(np.where(np.isfinite(least), least, nearest))
    return found


def _extended(values: Array, where: Mask, size: int) -> Array:
    """Return means of the values of a region near it, and beyond it those of its nearest place."""
    found: Array = _means(values, where, size).reshape(-1, values.shape[2])[_nearest(where)]
    return found


def _means(values: Array, where: Mask, size: int) -> Array:
    """Return means of the values of a region over squares."""
    cv2 = opencv()
    weights = where.astype(np.float32)
    window = (2 * size + 1, 2 * size + 1)
    total = np.maximum(cv2.boxFilter(weights, -1, window, normalize=False), 1.0)
    summed = [
        cv2.boxFilter(values[..., channel] * weights, -1, window, normalize=False) / total
        for channel in range(values.shape[2])
    ]
    return np.stack(summed, axis=-1)


def _nearest(where: Mask) -> Places:
    """Return for each pixel the index of the nearest pixel of a region."""
    cv2 = opencv()
    _, labels = cv2.distanceTransformWithLabels(
        (~where).astype(np.uint8), cv2.DIST_L2, 5, labelType=cv2.DIST_LABEL_PIXEL
    )
    places = np.zeros(int(labels.max()) + 1, np.int64)
    flat = np.flatnonzero(where)
    places[labels.reshape(-1)[flat]] = flat
    found: Places = places[labels]
    return found


def _spread(difference: Array, where: Mask, size: int) -> Array:
    """Root mean square of the difference within a region, near each place."""
    square = np.where(where, difference**2, 0.0).astype(np.float32)
    found: Array = np.sqrt(_extended(square[..., None], where, size)[..., 0])
    return found


def _require_contrast(signal: Array, noise: Array, band: Mask, rough: Mask) -> None:
    columns = np.flatnonzero(rough.any(axis=0))
    middle = (columns[0] + columns[-1]) // 2
    bottom = int(np.flatnonzero(rough.any(axis=1))[-1])
    above = np.zeros_like(band)
    above[: bottom - (bottom - int(np.flatnonzero(rough.any(axis=1))[0])) // 3] = True
    for side, part in (("left", slice(None, middle)), ("right", slice(middle, None))):
        place = (band & above)[:, part]
        ratio = float(np.median(signal[:, part][place] / (noise[:, part][place] + 0.4)))
        if ratio < _CONTRAST:
            raise NotMeasurableError(messages.NO_CONTRAST(side=side, ratio=ratio, needed=_CONTRAST))
