"""The circle of a drum in a picture, seen nearly along its axis."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from grainfit.arrays import Array
from grainfit.errors import NotMeasurableError
from grainfit.photographs import messages
from grainfit.photographs.pictures import opencv

Floats = NDArray[np.float32]
Colours = NDArray[np.uint8]

#: Length of the longer side of the picture in which circles are looked for, pixels.
_LENGTH = 160
#: Distance between the middles that are tried, and between radii, pixels of this picture; and
#: directions in which a change of colour, in Lab over a pixel, counts as an edge.
_GRID, _DIRECTIONS, _CHANGE = (3.0, 1.5), 72, 3.0
#: In pictures that a program has made plain, with less change of brightness than this from pixel to
#: pixel over half of them, edges count that are so many times fainter.
_PLAIN, _FAINTER = 0.02, 3.0
#: Where middles are looked for, over width and height of the picture.
_MIDDLES = (0.2, 0.8)
#: Circles that are looked at closely, and by how much they differ, over their radius.
_MOST, _APART = 14, 0.05
#: Radii that are looked for, over the shorter side of the picture; the least one, pixels.
_RADII, _SMALLEST = (0.15, 0.6), 50.0
#: Share of a circle, and of three of its quarters, at which an edge must be seen; how strong it is,
#: in Lab, and how near, over the radius and in pixels.
_SEEN, _QUARTER, _STEEP, _NEAR = 0.5, 0.3, 4.0, (0.008, 1.2)
#: Steps by which a guess is shifted, and then how far from it its edge is looked for, over its
#: radius.
_STEPS, _REACHES = (0.012, 0.004), (0.02, 0.015)
#: Share of its radius that must be in the picture: instruments save the square about the drum.
_TOUCHES = 0.99
#: Beyond this angle from its axis a drum is seen too obliquely, degrees.
_OBLIQUE = 15.0
_RAYS = 360
#: Share of a small circle that is seen if it is a drum; and of those about one middle, over that
#: of the one of which most is seen.
_CLEAR, _AS_CLEAR = 0.9, 0.8
#: Noise is averaged over pixels as near as this, of colours as near as this (0 to 255), by weights
#: of this width; and the share of a circle that is seen then if it is a drum.
_NOISE, _SEEN_WITHOUT = (9, 12.0, 3.0), 0.8
#: A camera is steady if an edge is seen on the circle in all frames nearly as much as in any.
_STEADY = 0.75


@dataclass(frozen=True)
class DrumCircle:
    """The inner edge of a drum's front in a picture: a circle, seen as an ellipse.

    Parameters
    ----------
    middle : tuple of float
        Column and row.
    half, depth : float
        Its longer and its shorter half axis, pixels.
    turn : float
        Inclination of the longer axis to the columns, rad.
    """

    middle: tuple[float, float]
    half: float
    depth: float
    turn: float

    @property
    def obliqueness(self) -> float:
        """Angle between the axis of the drum and the line of sight, degrees."""
        return math.degrees(math.acos(min(self.depth / self.half, 1.0)))

    @property
    def _stretch(self) -> Array:
        """Matrix from offsets in the picture to those on the drum's front, without turning it."""
        cos, sin = math.cos(self.turn), math.sin(self.turn)
        turn = np.array([[cos, -sin], [sin, cos]])
        found: Array = turn @ np.diag([1 / self.half, 1 / self.depth]) @ turn.T
        return found

    def offset(self, vector: Array) -> Array:
        """Return a vector of the picture on the front of the drum, in its radius."""
        found: Array = self._stretch @ vector
        return found

    def to_picture(self, points: Array) -> Array:
        """Return columns and rows of points on the front: to the right and down, in its radius."""
        found: Array = points @ np.linalg.inv(self._stretch).T + np.array(self.middle)
        return found

    def turned(self, radius: float, size: int, inclination: float) -> Array:
        """Return the affine map to a square picture of the front.

        Parameters
        ----------
        radius : float
            Of the drum in the square, pixels; its middle is that of the square.
        size : int
            Side of the square, pixels.
        inclination : float
            Direction that lies along the rows of the square, rising to the right, degrees.
        """
        a = math.radians(inclination)
        turn = np.array([[math.cos(a), -math.sin(a)], [math.sin(a), math.cos(a)]])
        matrix = radius * turn @ self._stretch
        shift = np.full(2, (size - 1) / 2) - matrix @ np.array(self.middle)
        found: Array = np.column_stack([matrix, shift])
        return found

    def edge(self, factor: float = 1.0) -> Array:
        """Return columns and rows along the circle, or one of so many times its radius."""
        turn = np.linspace(0, 2 * math.pi, _RAYS, endpoint=False)
        return self.to_picture(factor * np.column_stack([np.cos(turn), np.sin(turn)]))

    def scaled(self, share: float) -> DrumCircle:
        """Return a circle about the same middle, of a share of its radius."""
        return replace(self, half=share * self.half, depth=share * self.depth)

    def is_as(self, other: DrumCircle, share: float) -> bool:
        """Return whether another circle is the same one, within a share of the radius."""
        apart = math.hypot(self.middle[0] - other.middle[0], self.middle[1] - other.middle[1])
        return max(apart, abs(self.half - other.half)) <= share * self.half


def circles_in(colours: Colours) -> list[DrumCircle]:
    """Return the circles of a picture that may be a drum, the largest first.

    Raises
    ------
    NotMeasurableError
        There is none, and why.
    """
    circles = _seen_in(colours)
    if not circles:
        # Noise hides a faint edge.
        circles = [one for one in _seen_in(_without_noise(colours)) if one[0] > _SEEN_WITHOUT]
    if not circles:
        raise NotMeasurableError(messages.NO_DRUM())
    # A drum and its rim are about one middle.
    seen, best = max(circles, key=lambda one: one[0])
    if _is_cut_off(best, colours):
        raise NotMeasurableError(messages.DRUM_CUT_OFF())
    near = 0.04 * best.half
    found = [
        one
        for share, one in circles
        if share > _AS_CLEAR * seen and math.dist(one.middle, best.middle) < near
    ]
    found = [_of_shape(one, best) for one in found if not _is_cut_off(one, colours)]
    found.sort(key=lambda one: -one.half)
    if found[0].half < _SMALLEST and seen < _CLEAR:
        # Something round, such as particles beside each other.
        raise NotMeasurableError(messages.NO_DRUM())
    if found[0].half < _SMALLEST:
        shown = messages.SMALL_DRUM(width=2 * found[0].half, needed=2 * _SMALLEST)
        raise NotMeasurableError(shown)
    return found


def _seen_in(colours: Colours) -> list[tuple[float, DrumCircle]]:
    """Return the different circles of a picture, each with the share of it that is seen."""
    smooth = _smooth(colours)
    slopes = _slopes(smooth)
    circles: list[tuple[float, DrumCircle]] = []
    for guess in _guesses(colours):
        seen, circle = _refined(smooth, _nearest(slopes, guess))
        if circle is None:
            continue
        same = [other for other in circles if circle.is_as(other[1], 0.03)]
        if all(other[0] < seen for other in same):
            circles = [other for other in circles if other not in same] + [(seen, circle)]
    return circles


def _without_noise(colours: Colours) -> Colours:
    """Return a picture without the noise of the camera: areas are plain, edges stay."""
    cv2 = opencv()
    found: Colours = cv2.bilateralFilter(cv2.medianBlur(colours, 3), *_NOISE)
    return found


def _of_shape(circle: DrumCircle, best: DrumCircle) -> DrumCircle:
    """Return a circle of the same size that is seen as obliquely as the clearest one.

    The bed and its particles make the edge of the drum less sure than that of its rim.
    """
    size = math.sqrt(circle.half * circle.depth)
    root = math.sqrt(best.depth / best.half)
    return DrumCircle(circle.middle, size / root, size * root, best.turn)


def is_steady(circle: DrumCircle, frames: Sequence[Colours]) -> bool:
    """Return whether a drum is seen at the same place in all of some frames."""
    shifts = np.array([-1.0, 0.0, 1.0]) * _STEPS[0] * circle.half
    x, y, r = np.meshgrid(shifts, shifts, shifts, indexing="ij")
    places = (circle.middle[0] + x, circle.middle[1] + y, circle.half + r)

    def is_seen_alike(some: Sequence[Colours]) -> bool:
        seen = [float(_shares(_slopes(_smooth(frame)), *places).max()) for frame in some]
        return min(seen) > _STEADY * max(seen)

    return is_seen_alike(frames) or is_seen_alike([_without_noise(frame) for frame in frames])


def _smooth(colours: Colours) -> Floats:
    cv2 = opencv()
    soft = cv2.GaussianBlur(colours, (0, 0), 1.0).astype(np.float32) / 255
    found: Floats = cv2.cvtColor(soft, cv2.COLOR_RGB2LAB)
    return _gain(found) * found


def _gain(lab: Floats) -> np.float32:
    """Return by how much to stretch colours: noise does not hide the faint edges of some."""
    change = float(np.median(np.abs(np.diff(lab[..., 0], axis=1))))
    return np.float32(_FAINTER if change < _PLAIN else 1.0)


def _guesses(colours: Colours) -> list[DrumCircle]:
    """Return the circles across which the colours change on most of their circumference."""
    cv2 = opencv()
    factor = min(_LENGTH / max(colours.shape[:2]), 1.0)
    size = (round(colours.shape[1] * factor), round(colours.shape[0] * factor))
    small = cv2.resize(colours, size, interpolation=cv2.INTER_AREA).astype(np.float32) / 255
    lab = cv2.cvtColor(cv2.GaussianBlur(small, (0, 0), 0.8), cv2.COLOR_RGB2LAB)
    slopes = _slopes(_gain(lab) * lab)
    radii = np.arange(_RADII[0] * min(size), _RADII[1] * min(size), _GRID[1])
    found: list[tuple[float, DrumCircle]] = []
    for row in np.arange(_MIDDLES[0] * size[1], _MIDDLES[1] * size[1], _GRID[0]):
        columns = np.arange(_MIDDLES[0] * size[0], _MIDDLES[1] * size[0], _GRID[0])
        share = _shares(slopes, columns[:, None], np.full((1, 1), row), radii[None])
        for column, radius in zip(*np.nonzero(share > 0.7 * share.max()), strict=True):
            middle = ((columns[column] + 0.5) / factor - 0.5, (row + 0.5) / factor - 0.5)
            half = float(radii[radius]) / factor
            found.append(
                (float(share[column, radius]), DrumCircle((middle[0], middle[1]), half, half, 0.0))
            )
    found.sort(key=lambda one: -one[0])
    guesses: list[DrumCircle] = []
    for _, guess in found:
        if not any(guess.is_as(other, _APART) for other in guesses):
            guesses.append(guess)
        if len(guesses) == _MOST:
            break
    return guesses


def _slopes(lab: Floats) -> tuple[Floats, Floats]:
    """Change of the colours across and down."""
    return np.gradient(lab, axis=1), np.gradient(lab, axis=0)


def _shares(slopes: Sequence[Floats], x: Array, y: Array, radii: Array) -> Array:
    """Return on which share of circles the colours change across them; all of one shape."""
    across, down = slopes
    rows, columns = across.shape[:2]
    turn = np.linspace(0, 2 * math.pi, _DIRECTIONS, endpoint=False)
    cos, sin = np.cos(turn), np.sin(turn)
    u = x[..., None] + radii[..., None] * cos
    v = y[..., None] + radii[..., None] * sin
    inside = (u >= 0) & (v >= 0) & (u < columns - 1) & (v < rows - 1)
    place = (
        np.clip(np.round(v), 0, rows - 1).astype(np.intp),
        np.clip(np.round(u), 0, columns - 1).astype(np.intp),
    )
    change = across[place] * cos[:, None] + down[place] * sin[:, None]
    steep = np.minimum(np.linalg.norm(change, axis=-1) / _CHANGE, 1.0) * inside
    share: Array = steep.mean(axis=-1)
    return share


def _nearest(slopes: Sequence[Floats], guess: DrumCircle) -> DrumCircle:
    """Return the circle near a guess on which the colours change most."""
    circle = guess
    for step in _STEPS:
        length = step * circle.half
        shifts = np.arange(-3, 4) * length
        x, y, r = np.meshgrid(shifts, shifts, np.arange(-4, 5) * length, indexing="ij")
        middle = (circle.middle[0] + x, circle.middle[1] + y)
        share = _shares(slopes, *middle, circle.half + r)
        best = np.unravel_index(int(share.argmax()), share.shape)
        half = float(circle.half + r[best])
        circle = DrumCircle((float(middle[0][best]), float(middle[1][best])), half, half, 0.0)
    return circle


def require_along_axis(circle: DrumCircle) -> None:
    """Raise `NotMeasurableError` if a drum is seen too obliquely."""
    if circle.obliqueness > _OBLIQUE:
        shown = messages.OBLIQUE(angle=circle.obliqueness, most=_OBLIQUE)
        raise NotMeasurableError(shown)


def _is_cut_off(circle: DrumCircle, colours: Colours) -> bool:
    x, y = circle.edge(_TOUCHES).T
    rows, columns = colours.shape[:2]
    return bool((x < 0).any() or (y < 0).any() or (x > columns - 1).any() or (y > rows - 1).any())


def _refined(lab: NDArray[np.float32], guess: DrumCircle) -> tuple[float, DrumCircle | None]:
    """Fit an ellipse to the steepest places across a guess; None where too little is seen.

    And the share of it that is seen.
    """
    cv2 = opencv()
    circle = guess
    for reach in _REACHES:
        # Differences over three pixels, four to a pixel.
        step = 6
        ends = max(reach * circle.half, 2.5 * _NEAR[1]) + step / 4
        factors = 1 + np.arange(-ends, ends + 1e-9, 0.25) / circle.half
        turn = np.linspace(0, 2 * math.pi, _RAYS, endpoint=False)
        circular = np.column_stack([np.cos(turn), np.sin(turn)])
        rays = np.stack([circle.to_picture(f * circular) for f in factors]).astype(np.float32)
        values = cv2.remap(
            lab, rays[..., 0], rays[..., 1], cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE
        )
        steep = np.linalg.norm(values[2 * step :] - values[: -2 * step], axis=2)
        best = steep.argmax(axis=0)
        strong = steep[best, np.arange(_RAYS)] > _STEEP
        # Between two samples, by a parabola.
        inner = np.clip(best, 1, len(steep) - 2)
        before, at, after = (steep[inner + k, np.arange(_RAYS)] for k in (-1, 0, 1))
        bend = before - 2 * at + after
        shift = np.where(bend < -1e-6, 0.5 * (before - after) / np.minimum(bend, -1e-6), 0.0)
        place = factors[0] + (best + step + np.clip(shift, -1, 1)) * (factors[1] - factors[0])
        points = circle.to_picture(place[:, None] * circular)
        kept = strong
        for _ in range(5):
            if kept.sum() < _SEEN * _RAYS:
                return 0.0, None
            (x, y), axes, angle = cv2.fitEllipseDirect(points[kept].astype(np.float32))
            wide = int(axes[1] > axes[0])
            half, depth = axes[wide] / 2, axes[1 - wide] / 2
            if not (half > 0 and depth > math.cos(math.radians(_OBLIQUE + 5)) * half):
                return 0.0, None
            turned = math.radians(angle + 90 * wide)
            circle = DrumCircle((float(x), float(y)), float(half), float(depth), turned)
            offset = (points - np.array(circle.middle)) @ circle._stretch.T
            off = np.abs(np.hypot(*offset.T) - 1) * half
            near = max(_NEAR[0] * half, _NEAR[1])
            limit = max(near, min(2.0 * float(np.median(off[kept])), 6 * near))
            kept = strong & (off < limit)
    seen = (strong & (off < near)).reshape(4, -1).mean(axis=1)
    if seen.mean() < _SEEN or sorted(seen)[1] < _QUARTER:
        return 0.0, None
    return float(seen.mean()), circle
