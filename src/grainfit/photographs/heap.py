"""The angle of repose of a heap in one picture."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from grainfit.arrays import Array
from grainfit.errors import NotMeasurableError
from grainfit.measurement.angle_of_repose import View, angle_of_repose_in, outline_depth
from grainfit.measurement.silhouette import Silhouette
from grainfit.photographs import messages
from grainfit.photographs.by_hand import Points
from grainfit.photographs.camera import (
    FOCAL_RANGE,
    USUAL_FOCAL,
    Camera,
    Foot,
    apparent_angle,
    foot_of,
    ray,
    true_angle,
    up_from,
)
from grainfit.photographs.four_points import Rectangle, rectangle_of
from grainfit.photographs.marker import MarkerSheet, find_marker_sheet
from grainfit.photographs.pictures import Picture, opencv
from grainfit.photographs.plate import Plate, Rim, drawn_rim, find_rim
from grainfit.photographs.separation import Separated, drawn_outline, separate
from grainfit.photographs.upright import Upright, mirrored, parts_of_pixel

#: Flanks are seen up to the angle less this, degrees.
FLANKS_VANISH = 8.0
#: Largest standard uncertainty of the angle by the elevation of the camera, degrees.
_UNSURE = 0.6
#: The other levels at which the edge of the heap may be taken, and how far the angles at them may
#: be apart, degrees.
_LEVELS, _APART = (0.28, 0.55), 1.5
#: Standard uncertainty of an elevation that is stated in degrees, and of one from the foot for the
#: foot that is no circle.
_STATED, _NO_CIRCLE = 0.5, 0.3
#: Standard uncertainty of a particle diameter that is estimated, relative.
_ESTIMATED = 0.3
#: Scatter of the depth of an outline over its mean: that of Rayleigh's distribution.
_SCATTER_OF_DEPTH = math.sqrt(4 / math.pi - 1)
#: Length along a flank that shows one particle, in particle diameters.
_INDEPENDENT = 1.2
#: Least particle diameter that the outline shows, pixels.
_FINEST = 1.5
#: Standard uncertainty of an angle by the pixels, the lens and the compression, degrees.
_PICTURE = 0.2
#: Standard uncertainty of an angle by an outline that is drawn by hand, degrees.
_BY_HAND = 0.5
#: A foot wider than the flanks by this factor is not theirs: a plate, or a shadow.
_WIDER_FOOT = 1.3

#: What tells the elevation of the camera, in words, and in a sentence.
_SEEN_BY = {
    type(None): "by its foot",
    Plate: "by the plate",
    MarkerSheet: "by the marker sheet",
    Rectangle: "by four points",
}
_TOLD_BY = {
    Plate: "the edge of the plate",
    MarkerSheet: "the marker sheet",
    Rectangle: "the four points",
}

Field = NDArray[np.float32]
Mask = NDArray[np.bool_]


@dataclass(frozen=True)
class HeapInPicture:
    """What was measured on one picture of a heap.

    Parameters
    ----------
    picture : Picture
        The picture in its working size.
    angle : float
        Mean inclination of its two flanks, degrees.
    parts : dict
        Standard uncertainties by their source, degrees.
    elevation, elevation_error : float
        Of the camera above the horizontal, seen from the apex, and its standard uncertainty,
        degrees.
    plate : Plate, MarkerSheet or None
        The plate, the sheet of markers or the rectangle, where it is seen.
    seen_by : str
        What the elevation follows from: the sheet, the plate, the foot of the heap, or what is
        given; and what was drawn by hand.
    roll : float
        By which the picture was turned, degrees.
    silhouette : Silhouette
        Upright, as from the side: what the flanks were fitted to, lengths in pixels.
    view : View
        The flanks, in its lengths.
    ground, diameter : float
        Where the flanks begin, and particle diameter, pixels.
    scale : float or None
        Length of a pixel of the silhouette, m; None without a known length.
    height : float or None
        Of the highest particle above the plate, m; None without a known length.
    outline : ndarray of shape (n, 2)
        Of the heap, columns and rows in the picture.
    drawn : tuple of ndarray
        Left and right flank, and the foot, columns and rows in the picture.
    back : callable
        Returns columns and rows in the picture of places of the silhouette, shape (n, 2).
    """

    picture: Picture
    angle: float
    parts: dict[str, float]
    elevation: float
    elevation_error: float
    plate: Plate | MarkerSheet | None
    seen_by: str
    roll: float
    silhouette: Silhouette
    view: View
    ground: float
    diameter: float
    scale: float | None
    height: float | None
    outline: Array
    drawn: tuple[Array, Array, Array]
    back: Callable[[Array], Array]

    @property
    def flanks(self) -> tuple[float, ...]:
        """Inclinations of the flanks that were measured, degrees."""
        return tuple(flank.angle for flank in (self.view.left, self.view.right) if flank)

    @property
    def uncertainty(self) -> float:
        """Standard uncertainty of the angle of these two flanks, degrees."""
        return math.sqrt(sum(part**2 for part in self.parts.values()))


@dataclass(frozen=True)
class _Found:
    """Angle on one mask with one camera."""

    angle: float
    silhouette: Silhouette
    view: View
    ground: float
    diameter: float
    elevation: float
    back: Callable[[Array], Array]


def measure_heap(
    picture: Picture,
    elevation: float | None = None,
    plate_diameter: float | None = None,
    diameter: float | None = None,
    rectangle: tuple[float, float] | None = None,
    seen: Seen | None = None,
) -> HeapInPicture:
    """Measure the angle of repose of the heap in a picture.

    Parameters
    ----------
    picture : Picture
        The whole heap, seen from the side or from slightly above.
    elevation : float, optional
        Of the camera above the horizontal, degrees; from the edge of the plate, or else from the
        foot of the heap, if not given.
    plate_diameter, diameter : float, optional
        Of the plate, by which lengths are known, and of the particles, m.
    rectangle : pair of float, optional
        Sides of the rectangle whose corners are given by hand, m.
    seen : Seen, optional
        What is found without a camera, if it has been found before.

    Raises
    ------
    NotMeasurableError
        The picture cannot be measured, and why.
    """
    seen = seen or Seen()
    seen.look(picture)
    separated, mask = seen.separated, seen.mask
    focal = picture.focal or USUAL_FOCAL * max(picture.colours.shape[:2])

    def camera_of(focal: float) -> tuple[Foot, float, Plate | MarkerSheet | None]:
        return _seen_from(picture, seen, focal, elevation, rectangle)

    foot, error, plate = camera_of(focal)
    lengths = _lengths(plate, plate_diameter, foot, focal, picture.middle, mask)
    scale = lengths[0] if lengths else None
    particle = diameter / scale if diameter and scale else None
    axis = picture.by_hand.axis[0] if picture.by_hand.axis else None
    found = _angle(seen.field, Camera(focal, picture.middle, foot.up), foot.middle, particle, axis)
    _require_flanks(found.angle, found.elevation, error)
    _require_foot(found)

    def other(
        field: Field = seen.field, focal: float = focal, foot: Foot = foot, size: float = 1
    ) -> float:
        camera = Camera(focal, picture.middle, foot.up)
        return _angle(field, camera, foot.middle, size * found.diameter, axis).angle

    parts = {"picture": _PICTURE, "outline": _BY_HAND}
    if not picture.by_hand.outline:
        parts["outline"] = _unsure_outline(separated, found.angle, other)
    parts["elevation"] = _unsure_elevation(found.angle, found.elevation, error)
    if particle is None:
        parts["particle size"] = abs(other(size=1 + _ESTIMATED) - found.angle)
    if picture.focal is None:
        focals = [limit * max(picture.colours.shape[:2]) for limit in FOCAL_RANGE]
        try:
            angles = [other(focal=length, foot=camera_of(length)[0]) for length in focals]
        except NotMeasurableError as refused:
            raise NotMeasurableError(messages.NO_FOCAL_LENGTH(why=refused)) from refused
        # Any focal length within the range is as likely as another.
        parts["focal length"] = (max(angles) - min(angles)) / math.sqrt(12)
    up = foot.up
    how = "given" if elevation is not None else _SEEN_BY[type(plate)]
    return HeapInPicture(
        picture,
        found.angle,
        parts,
        found.elevation,
        error,
        plate,
        ", ".join(words for words in (how, picture.by_hand.words) if words),
        math.degrees(math.atan2(up[0], -up[1])),
        found.silhouette,
        found.view,
        found.ground,
        found.diameter,
        scale,
        lengths[1] if lengths else None,
        contour_of(mask),
        _drawn(found),
        found.back,
    )


class Seen:
    """What is found on a picture without a camera: the heap, and the edge of the plate.

    Parts that were drawn by hand are taken as drawn; the others are found once.
    """

    def __init__(self) -> None:
        self._drawn: tuple[Points, Points] | None = None
        self._automatic: Separated | None = None
        self._rims: dict[Points, Rim | None] = {}
        self.separated: Separated
        self.field: Field
        self.mask: Mask
        self.rim: Rim | None = None

    def look(self, picture: Picture) -> None:
        """Find what has not been found yet.

        Raises
        ------
        NotMeasurableError
            There is no heap.
        """
        drawn = picture.by_hand
        if self._drawn == (drawn.outline, drawn.plate):
            return
        rows, columns = picture.colours.shape[:2]
        if drawn.outline:
            self.separated = drawn_outline(drawn.outline, (rows, columns))
        else:
            self._automatic = self._automatic or separate(picture.colours)
            self.separated = self._automatic
        self.field = self.separated.field()
        self.mask = self.field > 0
        if drawn.plate:
            self.rim = drawn_rim(*np.array(drawn.plate))
        else:
            if drawn.outline not in self._rims:
                # With an outline that is being dragged, every one is another.
                self._rims = {drawn.outline: find_rim(picture.colours, self.mask)}
            self.rim = self._rims[drawn.outline]
        self._drawn = (drawn.outline, drawn.plate)


def _seen_from(
    picture: Picture,
    seen: Seen,
    focal: float,
    stated: float | None,
    rectangle: tuple[float, float] | None,
) -> tuple[Foot, float, Plate | MarkerSheet | None]:
    """Return the foot, the standard uncertainty of the elevation, degrees, and sheet or plate.

    Where one of them is seen, or the elevation is stated, the foot follows from it.
    """
    middle, drawn = picture.middle, picture.by_hand
    particle = particle_in(seen.mask)
    arc = _lower_edge(seen.mask, particle)
    foot = foot_of(arc, focal, middle, particle)
    error = math.hypot(foot.error, _NO_CIRCLE)
    plate: Plate | MarkerSheet | None = None
    if drawn.corners:
        plate = rectangle_of(drawn.corners, focal, middle, rectangle)
    elif not drawn.plate:
        plate = find_marker_sheet(picture.colours, focal, middle)
    if plate is None and seen.rim is not None:
        plate = seen.rim.plate(focal, middle)
    better = foot
    if plate is not None:
        better = foot_of(arc, focal, middle, particle, plate.up)
        spread = math.hypot(error, plate.error)
        # What is drawn by hand needs no witness.
        if not (drawn.corners or drawn.plate or better.agrees_with(foot)):
            _require_agreement(foot.elevation, better.elevation, spread, _TOLD_BY[type(plate)])
        error = plate.error
    if stated is not None:
        _require_agreement(better.elevation, stated, math.hypot(error, _STATED), "what is given")
        towards = ray(focal, middle, foot.middle)
        up = up_from(math.radians(stated), foot.roll, towards)
        return foot_of(arc, focal, middle, particle, up), _STATED, plate
    return better, error, plate


def _lengths(
    plate: Plate | MarkerSheet | None,
    plate_diameter: float | None,
    foot: Foot,
    focal: float,
    middle: tuple[float, float],
    mask: Mask,
) -> tuple[float, float] | None:
    """Return the length of a pixel at the apex and its height above the plate, m, if known.

    The camera is so high above the plane of the plate, and so far from the axis, which is taken to
    be over the middle of a plate, or of the foot on a sheet.
    """
    if isinstance(plate, Rectangle) and math.isnan(plate.height):
        return None
    if plate is None and plate_diameter is not None:
        raise NotMeasurableError(messages.NO_PLATE())
    if plate is None or not (isinstance(plate, MarkerSheet) or plate_diameter):
        return None
    camera = Camera(focal, middle, plate.up)
    apex = _apex(mask, camera)
    above = math.radians(camera.elevation(apex))
    if isinstance(plate, MarkerSheet):
        elevation, up = math.radians(camera.elevation(foot.middle)), plate.height
        # The circle of the foot is that of the middles of its particles.
        particle = particle_in(mask) * up / math.sin(elevation) / focal
        along = (up - particle / 2) / math.tan(elevation)
    else:
        # The edge of a circle is widest before its middle, where it is nearer.
        width = plate.half_width / focal * float(camera.ray(foot.middle)[2])
        elevation = math.radians(plate.elevation)
        distance = (plate_diameter or 0.0) / 2 * math.hypot(1 / width, math.cos(elevation))
        along, up = distance * math.cos(elevation), distance * math.sin(elevation)
    pixel = along / math.cos(above) * float(camera.ray(apex)[2]) / focal
    return pixel, up - along * math.tan(above)


def _require_agreement(foot: float, elevation: float, error: float, other: str) -> None:
    if abs(foot - elevation) > 3 * error:
        raise NotMeasurableError(
            messages.ELEVATIONS_DISAGREE(foot=foot, other=other, elevation=elevation)
        )


def _lower_edge(mask: Mask, particle: float) -> Array:
    """Lower edge of a heap without the gaps between its particles, columns and rows."""
    cv2 = opencv()
    size = max(3, round(2 * particle))
    shape = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (size, size))
    padded = np.pad(mask.astype(np.uint8), size)
    mask = cv2.morphologyEx(padded, cv2.MORPH_CLOSE, shape)[size:-size, size:-size] > 0
    columns = np.flatnonzero(mask.any(axis=0))
    rows = mask.shape[0] - np.argmax(mask[::-1, columns], axis=0) - 0.5
    every = max(1, len(columns) // 100)
    return np.column_stack([columns, rows]).astype(np.float64)[::every]


def particle_in(mask: Mask, end: float = 0.0) -> float:
    """Particle diameter by the roughness of the outline, pixels, on the flanks as they appear.

    These end at a share of the height of the heap: below is the foot.
    """
    columns = np.flatnonzero(mask.any(axis=0))
    outline = mask.shape[0] - np.argmax(mask[:, columns], axis=0).astype(np.float64)
    top = int(outline.argmax())
    foot = float(np.median(np.r_[outline[:3], outline[-3:]]))
    found = []
    for side in (slice(None, top), slice(top, None)):
        heights, places = outline[side], columns[side].astype(np.float64)
        share = (heights - foot) / max(outline[top] - foot, 1.0)
        flank = (share > min(max(0.15, end + 0.05), 0.6)) & (share < 0.85)
        if flank.sum() > 20:
            found.append(diameter_by_roughness(places[flank], heights[flank], float(columns[top])))
    return float(np.mean(found)) if found else _FINEST


def diameter_by_roughness(places: Array, heights: Array, axis: float) -> float:
    """Return the particle diameter whose outline scatters about a line as this one.

    Parameters
    ----------
    places, heights : ndarray of shape (n,)
        Outline of one flank, in pixels.
    axis : float
        Place of the axis.
    """
    line = np.polyfit(places, heights, 1)
    # A flank is slightly curved; that is no roughness.
    rest = heights - np.polyval(np.polyfit(places, heights, 2), places)
    square = max(float(np.mean(rest**2)) - 1 / 12, 0.0)
    angle = math.degrees(math.atan(abs(float(line[0]))))
    length = float(np.ptp(places))
    diameter = 10.0
    for _ in range(30):
        # The fitted curve follows the particles, where they are few.
        independent = max(length / (_INDEPENDENT * diameter), 4.5)
        scatter = math.sqrt(square / (1 - 3 / independent))
        depth = float(outline_depth(np.abs(places - axis), angle, diameter).mean())
        diameter *= math.sqrt(max(scatter / (_SCATTER_OF_DEPTH * depth), 0.01))
        diameter = max(diameter, _FINEST)
    return diameter


def _angle(
    field: Field,
    camera: Camera,
    foot: tuple[float, float],
    given: float | None = None,
    drawn_axis: tuple[float, float] | None = None,
) -> _Found:
    """Measure the angle of a heap that is seen by a camera.

    Parameters
    ----------
    field : ndarray of float32 of shape (rows, columns)
        Positive within the heap, zero at its edge.
    camera : Camera
        The camera.
    foot, drawn_axis : tuple of float
        Where the middle of its foot is, and its axis at the apex if it is drawn by hand: column
        and row.
    given : float, optional
        Particle diameter, pixels; by the roughness of the outline if not given.
    """
    mask = field > 0
    apex = _apex(mask, camera)
    width = float(np.ptp(np.flatnonzero(mask.any(axis=0))))
    height = float(np.ptp(np.flatnonzero(mask.any(axis=1))))
    margin = 0.1 * width
    size = (math.ceil(1.4 * width), math.ceil(height + 0.3 * width + margin))
    parts = parts_of_pixel(width)
    upright = Upright(field, camera.turned(apex, (size[0] / 2, margin)), size, parts)
    flat = upright.silhouette()
    diameter = given or particle_in(flat.image) / parts
    outline = flat.outline()
    smooth = _smoothed(outline, diameter * parts)
    top = size[1] - float(np.nanmax(smooth))  # row of the apex
    level = upright.place(foot)[1] + diameter / 2
    elevation = camera.elevation(apex)
    # Height of the apex above the plate below it, in perspective.
    e, drop = math.radians(elevation), level - top
    if drop <= diameter:
        raise NotMeasurableError(messages.COARSE(height=drop + diameter / 2, diameter=diameter))
    scale = _turned_focal(camera, apex)
    tall = scale * drop / (scale * math.cos(e) - drop * math.sin(e))
    heights = (size[1] - level, size[1] - top)
    axis = upright.place(drawn_axis)[0] if drawn_axis else _axis(outline, *heights) / parts
    apparent = _first_guess(flat, *heights)
    for _ in range(4):
        angle = true_angle(apparent, elevation)
        stretch = math.tan(math.radians(angle)) / math.tan(math.radians(apparent))
        silhouette = upright.silhouette(stretch, tall + stretch * top, axis)
        end = _end_of_flanks(angle, elevation, tall, scale)
        if given is None:
            diameter = particle_in(flat.image, end / drop) / parts
        ground = diameter + tall - stretch * (drop - end)
        # From behind, the same outline is seen, mirrored: two flanks alone would be refused where
        # they differ by more than four degrees, as those of coarse heaps do.
        both = [silhouette, mirrored(silhouette)]
        measured = angle_of_repose_in(both, [0.0, 180.0], ground, diameter)
        tangent = math.tan(math.radians(measured.value)) / stretch
        before, apparent = apparent, math.degrees(math.atan(tangent))
        if abs(before - apparent) < 0.02:
            break

    def back(points: Array) -> Array:
        rows = top + (tall - points[:, 1]) / stretch
        return upright.back(np.column_stack([points[:, 0] + axis, rows]))

    angle = true_angle(apparent, elevation)
    return _Found(angle, silhouette, measured.views[0], ground, diameter, elevation, back)


def _turned_focal(camera: Camera, place: tuple[float, float]) -> float:
    """Return the focal length of the camera that `Camera.turned` makes, pixels."""
    return camera.focal / float(camera.ray(place)[2])


def _apex(mask: Mask, camera: Camera) -> tuple[float, float]:
    """Place of the apex in a picture: the highest place along the upward direction."""
    rows, columns = np.nonzero(mask)
    up = np.array([camera.up[0], camera.up[1]])
    heights = columns * up[0] + rows * up[1]
    highest = heights >= np.max(heights) - 2
    return float(columns[highest].mean()), float(rows[highest].mean())


def _smoothed(outline: Array, diameter: float) -> Array:
    """Moving mean of an outline over two particle diameters; zero beside the heap."""
    size = max(1, round(2 * diameter))
    filled = np.nan_to_num(outline, nan=0.0)
    found: Array = np.convolve(filled, np.ones(size) / size, "same")
    return found


def _axis(outline: Array, level: float, top: float) -> float:
    """Column of the axis: the middle of the heap over its upper half."""
    filled = np.nan_to_num(outline, nan=0.0)
    middles = []
    for share in np.linspace(0.4, 0.8, 9):
        above = np.flatnonzero(filled > level + share * (top - level))
        if len(above):
            middles.append((above[0] + above[-1] + 1) / 2)
    return float(np.mean(middles))


def _first_guess(silhouette: Silhouette, level: float, top: float) -> float:
    """Apparent inclination by the width of the heap at two heights, degrees."""
    filled = np.nan_to_num(silhouette.outline(), nan=0.0)
    sides = [(filled > level + share * (top - level)).sum() / 2 for share in (0.35, 0.75)]
    width = max(float(sides[0] - sides[1]) * silhouette.pixel_size, 1.0)
    return float(np.clip(math.degrees(math.atan(0.4 * (top - level) / width)), 2.0, 70.0))


def _end_of_flanks(angle: float, elevation: float, tall: float, focal: float) -> float:
    """Height in the picture, above the middle of the foot, below which the outline is the foot.

    The generators in view end behind the sides of the foot, farther from the camera than the apex,
    which is `focal` pixels away; the picture is that of a camera that looks at it.
    """
    e, slope = math.radians(elevation), math.tan(math.radians(angle))
    behind = min(math.tan(e) / slope, 1.0)
    reach = tall / slope

    def row(back: float) -> float:
        """Row below the apex of a place at the level of the foot, so far behind the axis."""
        return (
            focal
            * (tall * math.cos(e) - back * math.sin(e))
            / (focal + back * math.cos(e) + tall * math.sin(e))
        )

    return row(0.0) - row(behind * reach)


def _require_flanks(angle: float, elevation: float, error: float) -> None:
    if elevation > angle - FLANKS_VANISH:
        raise NotMeasurableError(
            messages.TOO_HIGH(elevation=elevation, angle=angle, limit=angle - FLANKS_VANISH)
        )
    unsure = _unsure_elevation(angle, elevation, error)
    if unsure > _UNSURE:
        raise NotMeasurableError(
            messages.UNSURE_ELEVATION(elevation=elevation, error=error, angle_error=unsure)
        )


def _require_foot(found: _Found) -> None:
    """Raise `NotMeasurableError` if the foot does not belong to the flanks."""
    reaches = [
        abs(flank.start[0]) + flank.start[1] / math.tan(math.radians(flank.angle))
        for flank in (found.view.left, found.view.right)
        if flank is not None
    ]
    columns = np.flatnonzero(found.silhouette.image.any(axis=0))
    half = float(np.ptp(columns)) / 2 * found.silhouette.pixel_size
    if half > _WIDER_FOOT * float(np.mean(reaches)):
        factor = half / float(np.mean(reaches))
        raise NotMeasurableError(messages.WIDE_FOOT(factor=factor, most=_WIDER_FOOT))


def _unsure_elevation(angle: float, elevation: float, error: float) -> float:
    """Standard uncertainty of an angle by that of the elevation, degrees."""
    apparent = apparent_angle(angle, elevation)
    if math.isnan(apparent):
        return math.inf
    # From above and from below, a cone looks the same. Beside the horizontal an elevation and its
    # error do not matter in the first order.
    size = abs(elevation)
    others = (size + error, max(size - error, 0.0))
    return max(abs(true_angle(apparent, other) - angle) for other in others)


def _unsure_outline(separated: Separated, angle: float, other: Callable[..., float]) -> float:
    """Standard uncertainty by where the heap is taken to end, degrees."""
    found = [angle]
    for level in _LEVELS:
        found.append(other(field=separated.field(level)))
    if max(found) - min(found) > _APART:
        raise NotMeasurableError(messages.UNSURE_OUTLINE(low=min(found), high=max(found)))
    return (max(found) - min(found)) / 2


def contour_of(mask: Mask) -> Array:
    """Return the largest outline of a mask, columns and rows, shape (n, 2)."""
    cv2 = opencv()
    found, _ = cv2.findContours(mask.astype(np.uint8), cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
    outline: Array = max(found, key=len).reshape(-1, 2).astype(np.float64)
    return outline


def _drawn(found: _Found) -> tuple[Array, Array, Array]:
    """Flanks and the line of the ground, in the picture."""
    lines = []
    for flank in (found.view.left, found.view.right):
        points = [] if flank is None else [flank.start, flank.end]
        lines.append(found.back(np.array(points).reshape(-1, 2)))
    reach = max(abs(f.start[0]) for f in (found.view.left, found.view.right) if f is not None)
    ground = np.array([[-1.25 * reach, 0.0], [1.25 * reach, 0.0]])
    return lines[0], lines[1], found.back(ground)
