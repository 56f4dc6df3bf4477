"""The free surface of a bed in pictures of a drum, by the colours of the bed and of what is not."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from grainfit.arrays import Array
from grainfit.errors import NotMeasurableError
from grainfit.photographs import messages
from grainfit.photographs.drum_circle import Colours, DrumCircle
from grainfit.photographs.pictures import opencv

Floats = NDArray[np.float32]

#: Radius of the drum and side of the square in which a surface is looked for, pixels.
RADIUS, _SIZE = 150, 320
#: The same for the straight line that divides the drum best.
_COARSE, _COARSE_SIZE = 28, 61
#: Share of the radius within which colours count: the edge of the drum has its own.
_WITHIN = 0.955
#: Inclinations and distances from the axis of lines that are tried, degrees and radii.
_INCLINATIONS, _OFFSETS = np.arange(-75.0, 76.0, 3.0), np.arange(-0.8, 0.65, 0.05)
#: Share of the drum that a bed takes at least and at most.
_FILL = (0.04, 0.8)
#: Least share of the scatter of colours that the line explains.
_DIVIDED = 0.12
#: Colours: steps of lightness and of both hues; largest logarithm of a ratio of frequencies.
_STEPS, _SURE = (24, 12, 12), 3.0
#: Colours this near to the surface, in radii, are not used at first, and then.
_MARGINS = (0.12, 0.05)
#: Least mean difference of the logarithms just below and just above the surface.
_CONTRAST = 1.8
#: Shares of a circle at which bed and empty drum may end, from the outermost, half the width of a
#: ring, and the share of the agreement within that it must have.
_REACHES, _RING_WIDTH, _HALF = (0.97, 0.7, -0.01), 0.008, 0.5
#: Share from which they reach to the circle: beyond `_WITHIN` nothing is looked at.
REACHED = 0.935
#: Most of what is above the surface that may look like the bed.
_SPECKS = 0.15
#: Most of what is below the surface, this far within the circle of the drum or of its rim, that may
#: look like the empty drum.
_HOLES, _WITHIN_RIM = 0.05, 0.85
#: Share of the radius to both sides of the middle in which the surface is smooth, the length over
#: which its particles are averaged, places, and the steps of the fit and its smallest distance.
_SMOOTH, _AVERAGED, _FITS, _CLOSE = 0.85, 11, 20, 0.005
#: Ends of the surface at which no height is measured, in radii from the middle, and its distance
#: from the edge of what is looked at.
_ENDS, _BESIDE = 0.93, 0.02
#: Depths in the drum at which the bed may be what is seen.
_DEPTHS = 7


@dataclass(frozen=True)
class BedColours:
    """Colours of a bed and of the empty drum.

    Parameters
    ----------
    ratios : ndarray of shape (lightness, hue, hue)
        Logarithm of the frequency in the bed over that in the empty drum.
    inclination : float
        Of the line that divides them, rising to the right, degrees.
    """

    ratios: Floats
    inclination: float

    def heights(
        self, colours: Colours, circle: DrumCircle, levels: Sequence[float] = (0.0,)
    ) -> Array:
        """Return the height of the surface over the line through the middle of the drum.

        Parameters
        ----------
        colours : ndarray of uint8 of shape (rows, columns, 3)
            The picture.
        circle : DrumCircle
            The drum in it.
        levels : sequence of float
            Logarithms of the ratio of frequencies from which a colour is that of the bed.

        Returns
        -------
        ndarray of shape (levels, n)
            In radii, at the places of `places`.
        """
        likely = self.likely(colours, circle)
        return np.array([_heights(likely - np.float32(level)) for level in levels])

    def likely(self, colours: Colours, circle: DrumCircle) -> Floats:
        """Return a square with the logarithms of the ratio; the surface is along its rows."""
        square = _square(colours, circle, RADIUS, _SIZE, self.inclination)
        found = self.ratios[_indices(square)]
        found[~_disc(RADIUS, _SIZE)] = 0
        smooth: Floats = opencv().GaussianBlur(found, (0, 0), 1.2)
        return smooth

    def reach(self, frames: Sequence[Colours], circle: DrumCircle) -> float | None:
        """Return the share of a circle to which bed and empty drum reach, if any.

        Where it is less than `REACHED`, the circle is the outer one of a rim.
        """
        x = places()
        distance = np.hypot(*np.meshgrid(x, x))
        each = [self.likely(frame, circle) for frame in frames]
        # Positive where a colour is that of its side of the surface.
        agreed = np.mean([np.where(-x[:, None] < _heights(one), one, -one) for one in each], axis=0)
        rings = np.arange(*_REACHES)
        inside = float(agreed[distance < rings[-1]].mean())
        like = [
            agreed[np.abs(distance - ring) < _RING_WIDTH].mean() > _HALF * inside for ring in rings
        ]
        return float(rings[like.index(True)]) if inside > 0 and any(like) else None


def places() -> Array:
    """Return the places along the surface, uphill to the right, in radii."""
    found: Array = (np.arange(_SIZE) - (_SIZE - 1) / 2) / RADIUS
    return found


def learn_colours(frames: Sequence[Colours], circle: DrumCircle) -> BedColours:
    """Learn the colours of the bed and of the empty drum from pictures of the same drum.

    Raises
    ------
    NotMeasurableError
        There is no free surface, and why.
    """
    inclination, offset = _dividing_line([_small(frame, circle) for frame in frames])
    surface = np.full(_SIZE, offset)
    squares: list[Colours] = []
    known: BedColours | None = None
    for margin in (_MARGINS[0], *_MARGINS):
        squares = [_square(frame, circle, RADIUS, _SIZE, inclination) for frame in frames]
        known = BedColours(_ratios(squares, surface, margin), inclination)
        each = np.concatenate([known.heights(frame, circle) for frame in frames])
        surface = np.median(each, axis=0)
        middle = np.abs(places()) < 0.6
        slope = np.polyfit(places()[middle], surface[middle], 1)[0]
        tilt = math.degrees(math.atan(slope))
        if abs(tilt) > 1.0:
            # The surface is along the rows.
            surface = surface - slope * places()
            inclination = float(np.clip(inclination + tilt, -80, 80))
    assert known is not None
    known = BedColours(_ratios(squares, surface, _MARGINS[1]), known.inclination)
    _require_surface(known, frames, circle)
    return known


def _square(
    colours: Colours, circle: DrumCircle, radius: float, size: int, inclination: float
) -> Colours:
    cv2 = opencv()
    matrix = circle.turned(radius, size, inclination)
    if circle.half > 1.6 * radius:
        # A reduced picture without aliases.
        colours = cv2.GaussianBlur(colours, (0, 0), 0.4 * circle.half / radius)
    square = cv2.warpAffine(
        colours, matrix, (size, size), flags=cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE
    )
    found: Colours = cv2.cvtColor(square, cv2.COLOR_RGB2LAB)
    return found


def _small(colours: Colours, circle: DrumCircle) -> Array:
    square = _square(colours, circle, _COARSE, _COARSE_SIZE, 0.0)
    found: Array = opencv().GaussianBlur(square, (0, 0), 0.8).astype(np.float64)
    return found


@cache
def _disc(radius: float, size: int) -> NDArray[np.bool_]:
    x = (np.arange(size) - (size - 1) / 2) / radius
    found: NDArray[np.bool_] = np.hypot(*np.meshgrid(x, x)) < _WITHIN
    return found


@cache
def _lines() -> tuple[Array, Floats]:
    """Lines that may divide a drum, and what is below each of them."""
    disc = _disc(_COARSE, _COARSE_SIZE)
    rows, columns = np.nonzero(disc)
    x = (columns - (_COARSE_SIZE - 1) / 2) / _COARSE
    y = ((_COARSE_SIZE - 1) / 2 - rows) / _COARSE
    lines, below = [], []
    for inclination in _INCLINATIONS:
        a = math.radians(float(inclination))
        above = y * math.cos(a) - x * math.sin(a)
        for offset in _OFFSETS:
            inside = above < offset
            if _FILL[0] < inside.mean() < _FILL[1]:
                lines.append((float(inclination), float(offset)))
                below.append(inside)
    return np.array(lines), np.array(below, dtype=np.float32)


def _dividing_line(squares: Sequence[Array]) -> tuple[float, float]:
    """Return the line whose two sides differ most: inclination, degrees, and offset, radii."""
    lines, below = _lines()
    values = np.mean(squares, axis=0)[_disc(_COARSE, _COARSE_SIZE)]
    values -= values.mean(axis=0)
    count = below.sum(axis=1)
    sums = below @ values.astype(np.float32)
    total = len(values)
    # Sum of squares between the two sides.
    between = (sums**2).sum(axis=1) * (1 / count + 1 / (total - count))
    share = between / max(float((values**2).sum()), 1e-9)
    best = int(share.argmax())
    spread = float(np.sqrt((values**2).sum(axis=1).mean()))
    if share[best] < _DIVIDED or spread < 3:
        raise NotMeasurableError(messages.NO_SURFACE())
    return float(lines[best, 0]), float(lines[best, 1])


def _indices(square: Colours) -> tuple[NDArray[np.uint8], ...]:
    scaled = [
        (square[..., k].astype(np.uint16) * steps // 256).astype(np.uint8)
        for k, steps in enumerate((_STEPS[0], 3 * _STEPS[1], 3 * _STEPS[2]))
    ]
    # Hues are near grey: the middle third has the steps.
    hues = [
        np.clip(scaled[k].astype(np.int16) - _STEPS[k], 0, _STEPS[k] - 1).astype(np.uint8)
        for k in (1, 2)
    ]
    return scaled[0], hues[0], hues[1]


def _ratios(squares: Sequence[Colours], surface: Array, margin: float) -> Floats:
    """Logarithm of the frequency of each colour in the bed over that in the empty drum."""
    disc = _disc(RADIUS, _SIZE)
    heights = ((_SIZE - 1) / 2 - np.arange(_SIZE))[:, None] / RADIUS
    sides = [disc & (heights < surface - margin), disc & (heights > surface + margin)]
    if min(side.sum() for side in sides) < 50:
        raise NotMeasurableError(messages.NO_SURFACE())
    cells = [np.ravel_multi_index(_indices(square), _STEPS) for square in squares]
    frequencies = []
    for side in sides:
        each = np.concatenate([cell[side] for cell in cells])
        counts = np.bincount(each, minlength=math.prod(_STEPS)).reshape(_STEPS).astype(float)
        smooth = ndimage.gaussian_filter(counts, (0.8, 0.6, 0.6))
        frequencies.append(smooth / smooth.sum())
    low = 2e-5
    found = np.log((frequencies[0] + low) / (frequencies[1] + low))
    clipped: Floats = np.clip(found, -_SURE, _SURE).astype(np.float32)
    return clipped


def _heights(likely: Floats) -> Array:
    """Height that divides each column best into bed below and no bed above, radii."""
    from_below = likely[::-1]
    summed = np.cumsum(from_below, axis=0)
    best = summed.argmax(axis=0)
    columns = np.arange(likely.shape[1])
    # Between two pixels, where the logarithm passes zero.
    after = np.minimum(best + 1, len(likely) - 1)
    at, beyond = from_below[best, columns], from_below[after, columns]
    fall = np.where(at - beyond > 1e-6, at - beyond, 1.0)
    share = np.where((at > 0) & (beyond <= 0), at / fall, 0.5)
    found = (best + share - (_SIZE - 1) / 2) / RADIUS
    x = places()
    limit = np.sqrt(np.maximum(_WITHIN**2 - x**2, 0.0))
    found = ndimage.median_filter(np.clip(found, -limit, limit), 5, mode="nearest")
    seen = np.flatnonzero((np.abs(x) < _ENDS) & (np.abs(found) < limit - _BESIDE))
    if len(seen):
        # Beside its ends, where the edge of the drum is, the surface goes on as it is there. Taken
        # at the edge of what is looked at, it would turn the bed to the line along its rows.
        found[: seen[0]], found[seen[-1] + 1 :] = found[seen[0]], found[seen[-1]]
    heights: Array = found
    return heights


def without_perspective(heights: Array, distance: float, length: float) -> Array:
    """Return the surface of a bed that is alike all along the drum, from its outlines.

    What lies deeper in the drum appears nearer to its axis, so that an outline shows the bed at the
    back in the middle, and that at the front at its ends: the bed looks too flat, by half a degree
    from eight radii away. The bed is the highest one that no depth would show above the outline.

    Parameters
    ----------
    heights : ndarray of shape (..., n)
        Outlines at `places`, in radii, seen along the axis.
    distance, length : float
        Of the camera before the front of the drum, and of the drum, in radii.
    """
    x = places()
    rows = heights.reshape(-1, len(x))
    found = rows.copy()
    for depth in np.linspace(0.0, length, _DEPTHS)[1:]:
        scale = distance / (distance + depth)
        shown = [np.interp(scale * x, x, row) / scale for row in rows]
        found = np.minimum(found, np.array(shown))
    return found.reshape(heights.shape)


def inclination_of(heights: Array) -> Array:
    """Inclination of the line to the centre of the area below a surface, against its rows, degrees.

    Parameters
    ----------
    heights : ndarray of shape (..., n)
        Of the surface at `places`, in radii.
    """
    x = places()
    reach = np.sqrt(np.maximum(1 - x**2, 0.0))
    top = np.clip(heights, -reach, reach)
    depth = top + reach
    along = (depth * x).sum(axis=-1)
    above = ((top**2 - reach**2) / 2).sum(axis=-1)
    found: Array = np.degrees(np.arctan2(along, -above))
    return found


def unevenness(heights: Array) -> float:
    """Return how far a surface jumps or bulges from a smooth one, in radii.

    The smooth one is the cubic with the least sum of distances: a part of the surface that is
    elsewhere does not draw it there.

    Parameters
    ----------
    heights : ndarray of shape (frames, n)
        Of the surface at `places`, in radii.
    """
    inner = np.abs(places()) < _SMOOTH
    mean = np.median(heights, axis=0)[inner]
    cubic = np.vander(places()[inner], 4)
    weights = np.ones(len(mean))
    for _ in range(_FITS):
        fitted = np.linalg.lstsq(cubic * weights[:, None], mean * weights, rcond=None)[0]
        rest = mean - cubic @ fitted
        weights = 1 / np.sqrt(np.maximum(np.abs(rest), _CLOSE))
    return float(np.abs(ndimage.uniform_filter1d(rest, _AVERAGED)).max())


def fill_level_of(heights: Array) -> float:
    """Return the share of the drum that is below a surface."""
    x = places()
    reach = np.sqrt(np.maximum(1 - x**2, 0.0))
    return float((np.clip(heights, -reach, reach) + reach).sum() / (2 * reach.sum()))


def _require_surface(known: BedColours, frames: Sequence[Colours], circle: DrumCircle) -> None:
    """Raise `NotMeasurableError` unless what is below the surface differs from what is above."""
    rows = ((_SIZE - 1) / 2 - np.arange(_SIZE))[:, None] / RADIUS
    inside = _disc(RADIUS, _SIZE)
    deep = inside & (np.hypot(rows, places()) < _WITHIN_RIM)
    steps, specks, holes = [], [], []
    for frame in frames:
        likely = known.likely(frame, circle)
        above = rows - _heights(likely)
        middle = inside & (np.abs(places()) < 0.8)
        under, over = middle & (above < -0.02) & (above > -0.1), middle & (above > 0.02)
        near, below = over & (above < 0.1), deep & (above < -0.02)
        if min(under.sum(), near.sum(), below.sum()) < 100:
            raise NotMeasurableError(messages.NO_SURFACE())
        steps.append(float(likely[under].mean() - likely[near].mean()))
        specks.append(float((likely[over] > 0).mean()))
        holes.append(float((likely[below] < 0).mean()))
    if np.median(steps) < _CONTRAST:
        shown = messages.SURFACE_WITHOUT_CONTRAST(found=np.median(steps), needed=_CONTRAST)
        raise NotMeasurableError(shown)
    if np.median(specks) > _SPECKS:
        share = 100 * float(np.median(specks))
        raise NotMeasurableError(messages.DIRTY_DRUM(share=share, most=100 * _SPECKS))
    if np.median(holes) > _HOLES:
        share = 100 * float(np.median(holes))
        raise NotMeasurableError(messages.BED_LIKE_DRUM(share=share, most=100 * _HOLES))
