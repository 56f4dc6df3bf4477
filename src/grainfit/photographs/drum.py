"""Angles of the bed in a photographed drum, over the frames of a video or over stills."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import NamedTuple

import numpy as np

from grainfit.arrays import Array
from grainfit.errors import NotMeasurableError
from grainfit.evaluation import Response
from grainfit.measurement.avalanches import Avalanches
from grainfit.measurement.dynamic_angles import DynamicAngles, Surface
from grainfit.photographs import messages
from grainfit.photographs.camera import USUAL_FOCAL
from grainfit.photographs.drum_circle import (
    Colours,
    DrumCircle,
    circles_in,
    is_steady,
    require_along_axis,
)
from grainfit.photographs.drum_surface import (
    REACHED,
    BedColours,
    fill_level_of,
    inclination_of,
    learn_colours,
    places,
    unevenness,
    without_perspective,
)
from grainfit.photographs.marker import find_marker_sheet
from grainfit.photographs.rim_speed import rim_of, rotational_speed
from grainfit.photographs.videos import Video

#: Fewest frames of a video, and fewest stills.
FEWEST_FRAMES, FEWEST_STILLS = 8, 5
#: Frames from which the colours are taken.
_LEARNT = 12
#: The surface is also taken where colours are so much more, or less, those of the bed.
_LEVELS = (0.0, -0.5, 0.5)
#: Largest standard uncertainty of the dynamic angle by where the surface is, degrees; and in one
#: picture alone, which shows fewer of the bed's colours.
_UNSURE, _UNSURE_IN_ONE = 1.0, 2.5
#: The outline of a bed is that of its highest particles over the length of the drum, a simulated
#: surface the mean of all: by so much an angle of the outline is less, degrees for a roughness of
#: the outline of one radius, and its standard deviation (7 simulated drums of 8 to 14 particle
#: diameters in radius, with and without end caps; those of `benchmarks/photographed_drums.py` are
#: others).
_HIGHEST: Mapping[str, tuple[float, float]] = {
    "dynamic_angle": (0.0, 14.0),
    "surface_angle": (50.0, 20.0),
    "upper_angle": (39.0, 35.0),
    "lower_angle": (73.0, 55.0),
}
#: Standard uncertainty of the dynamic angle by perspective that is not known, degrees: at 5 to 8
#: radii the same drums look flatter by 0.8 to not at all.
_PERSPECTIVE = 0.5
#: Share of the radius to both sides of the middle in which the roughness is taken.
_ROUGH = 0.6
#: Farthest that the mean surface may be from a smooth one, in radii, and in roughnesses of the
#: outline over the root of the number of frames if these are more; and in one picture alone, in
#: which an avalanche that is on its way bends the surface by up to five.
_UNEVEN, _PARTICLES, _PARTICLES_IN_ONE = 0.08, 8.0, 6.0
#: A bed whose inclination scatters by less, degrees, stands still.
_STILL = 0.03
#: Steepest bed, degrees.
_STEEPEST = 70.0


class DrumSize(NamedTuple):
    """Lengths of a drum, m; the radius is 1 where it is not known.

    Parameters
    ----------
    radius : float
        Inner radius.
    distance, length : float or None
        Of the camera before the front of the drum, and of the drum along its axis.
    """

    radius: float = 1.0
    distance: float | None = None
    length: float | None = None


@dataclass(frozen=True)
class PhotographedBed:
    """The bed of a drum in pictures, rising towards positive places.

    Parameters
    ----------
    turn : float
        Inclination of the line along which places are counted, degrees.
    heights : ndarray of shape (frames, n)
        Of the surface over this line through the axis of the drum, in its radius.
    size : DrumSize
        Of the drum.
    """

    turn: float
    heights: Array
    size: DrumSize

    @property
    def radius(self) -> float:
        """Of the drum, m; 1 where it is not known."""
        return self.size.radius

    @cached_property
    def inclinations(self) -> Array:
        """Inclination of the line from the axis to the centre of the bed in every frame, degrees.

        The bed is what is below the surface in the drum, so that this is right even if the circle
        of the drum is not quite. Perspective is taken out where distance and length are known.
        """
        heights, (radius, distance, length) = self.heights, self.size
        if distance is not None and length is not None:
            heights = without_perspective(heights, distance / radius, length / radius)
        found: Array = self.turn + inclination_of(heights)
        return found

    @cached_property
    def roughness(self) -> float:
        """Scatter of the outline about a smooth line, in radii; about a quarter of a diameter."""
        middle = np.abs(places()) < _ROUGH
        x = places()[middle]
        smooth = np.vander(x, 4)
        fitted = smooth @ np.linalg.lstsq(smooth, self.heights[:, middle].T, rcond=None)[0]
        rest = np.abs(self.heights[:, middle] - fitted.T)
        return float(1.4826 * np.median(np.median(rest, axis=1)))

    def surface(self, inclination: float, chosen: slice = slice(None)) -> Surface:  # noqa: ARG002
        """Return the free surface: below it half of the frames have the bed.

        Its coordinate is inclined as all frames are, by about the mean inclination.
        """
        heights = np.median(self.heights[chosen], axis=0)
        heights = np.where(np.hypot(places(), heights) < 1, heights, math.nan)
        return Surface(self.radius * places(), self.radius * heights, self.turn)


class StillAngles(DynamicAngles[PhotographedBed]):
    """Angles over stills: each shows a state of its own."""

    @cached_property
    def avalanches(self) -> Avalanches:
        """Each still is a part of its own."""
        count = len(self.bed.heights)
        return Avalanches(tuple(range(count + 1)), count)


@dataclass(frozen=True)
class DrumSeries:
    """What was measured on a video, or on stills, of one turning drum.

    Parameters
    ----------
    path : Path
        The video, or the first still.
    shown : ndarray of uint8 of shape (rows, columns, 3)
        One of its frames.
    circle : DrumCircle
        The drum in this frame.
    level : float
        Inclination of the horizontal in this frame, rising to the right, degrees.
    by_sheet : bool
        Whether the sheet of markers tells it.
    rises_right : bool
        Whether the bed rises to the right.
    angles : DynamicAngles
        The bed, by the evaluation of simulated drums.
    responses : dict
        Angles with the standard errors of their means over time, degrees.
    unsure : dict
        Standard uncertainties of each by where the surface is taken to be, and by the particles
        that its outline shows, degrees.
    interval : float or None
        Time between frames, s; None for stills.
    speed : Response or None
        Rotational speed, rad/s; None where no mark is seen.
    """

    path: Path
    shown: Colours
    circle: DrumCircle
    level: float
    by_sheet: bool
    rises_right: bool
    angles: DynamicAngles[PhotographedBed]
    responses: dict[str, Response]
    unsure: dict[str, dict[str, float]]
    interval: float | None
    speed: Response | None

    @property
    def fill_level(self) -> float:
        """Share of the drum that is below the surface."""
        return fill_level_of(np.median(self.angles.bed.heights, axis=0))

    def drawn(self, points: Iterable[tuple[float, float]]) -> Array:
        """Return columns and rows of places across and heights, both uphill from the axis."""
        across, height = np.array(list(points)).reshape(-1, 2).T / self.angles.bed.radius
        across = across if self.rises_right else -across
        a = math.radians(self.level)
        x = across * math.cos(a) - height * math.sin(a)
        y = across * math.sin(a) + height * math.cos(a)
        return self.circle.to_picture(np.column_stack([x, -y]))


def measure_video(video: Video, size: DrumSize) -> DrumSeries:
    """Measure the angles of the bed of a drum in a video.

    Raises
    ------
    NotMeasurableError
        It cannot be measured, and why.
    """
    if len(video) < FEWEST_FRAMES:
        raise NotMeasurableError(messages.FEW_FRAMES(found=len(video), needed=FEWEST_FRAMES))
    some = video.some(_LEARNT)
    known, circle = _bed_of(some)
    heights, rims = [], []
    for frame in video.frames():
        heights.append(known.heights(frame, circle, _LEVELS))
        rims.append(rim_of(frame, circle))
    speed = rotational_speed(rims, video.interval)
    level, by_sheet = _level_of(some[0], circle, None)
    beds, rises_right = _beds(known.inclination - level, np.array(heights), size)
    _require_turning(beds[0], speed)
    _require_smooth(beds[0])
    found = [DynamicAngles(bed) for bed in beds]
    try:
        responses = _corrected(found[0])
    except NotMeasurableError:
        seconds = len(heights) * video.interval
        raise NotMeasurableError(messages.SHORT_VIDEO(seconds=seconds)) from None
    change = found[0].unsteadiness
    if change is not None:
        raise NotMeasurableError(messages.UNSTEADY(change=change))
    return DrumSeries(
        video.path,
        some[0],
        circle,
        level,
        by_sheet,
        rises_right,
        found[0],
        responses,
        _unsure(found),
        video.interval,
        None if speed is None else replace(speed, value=abs(speed.value)),
    )


@dataclass(frozen=True)
class DrumStill:
    """The surface in one picture of a drum.

    Parameters
    ----------
    path : Path
        The picture.
    colours : ndarray of uint8 of shape (rows, columns, 3)
        Its colours.
    circle : DrumCircle
        The drum in it.
    level : float
        Inclination of the horizontal in it, degrees.
    by_sheet : bool
        Whether the sheet of markers tells it.
    turn : float
        Inclination to the horizontal of the line along which places are counted, degrees.
    heights : ndarray of shape (levels, n)
        Of the surface over this line, in radii.
    """

    path: Path
    colours: Colours
    circle: DrumCircle
    level: float
    by_sheet: bool
    turn: float
    heights: Array


def measure_still(path: Path, colours: Colours, focal: float | None) -> DrumStill:
    """Find the surface of the bed in one picture of a drum.

    Raises
    ------
    NotMeasurableError
        It cannot be measured, and why.
    """
    known, circle = _bed_of([colours])
    level, by_sheet = _level_of(colours, circle, focal)
    heights = known.heights(colours, circle, _LEVELS)
    turn = known.inclination - level
    beds, _ = _beds(turn, heights[None], DrumSize())
    _require_flowing(beds[0])
    _require_smooth(beds[0])
    _require_sure([float(bed.inclinations[0]) for bed in beds], _UNSURE_IN_ONE)
    return DrumStill(path, colours, circle, level, by_sheet, turn, heights)


def measure_stills(stills: Sequence[DrumStill], size: DrumSize) -> DrumSeries:
    """Measure the angles of the bed over stills of one drum.

    Raises
    ------
    NotMeasurableError
        There are too few, or they show no bed that flows down its surface.
    """
    if len(stills) < FEWEST_STILLS:
        raise NotMeasurableError(messages.FEW_STILLS(found=len(stills), needed=FEWEST_STILLS))
    turn = float(np.median([still.turn for still in stills]))
    heights = np.array([_turned(still, turn) for still in stills])
    beds, rises_right = _beds(turn, heights, size)
    _require_turning(beds[0], None)
    _require_smooth(beds[0])
    found = [StillAngles(bed) for bed in beds]
    first = stills[0]
    return DrumSeries(
        first.path,
        first.colours,
        first.circle,
        first.level,
        all(still.by_sheet for still in stills),
        rises_right,
        found[0],
        _corrected(found[0]),
        _unsure(found),
        None,
        None,
    )


def _turned(still: DrumStill, turn: float) -> Array:
    """Return the surface over a line that is inclined otherwise."""
    a = math.radians(still.turn - turn)
    x = places()
    rows = []
    for heights in still.heights:
        along = x * math.cos(a) - heights * math.sin(a)
        above = x * math.sin(a) + heights * math.cos(a)
        order = np.argsort(along, kind="stable")
        rows.append(np.interp(x, along[order], above[order]))
    return np.array(rows)


def _bed_of(frames: Sequence[Colours]) -> tuple[BedColours, DrumCircle]:
    """Return the colours of the bed, and the drum: the largest circle that these reach to."""
    middle = frames[0]
    if len(frames) > 1:
        middle = np.median(np.array(frames), axis=0).astype(np.uint8)
    try:
        circles = circles_in(middle)
    except NotMeasurableError:
        # The mean of a camera that moves shows no circle.
        circles = circles_in(frames[0])
    reason: NotMeasurableError | None = None
    within_rim = False
    while circles:
        circle = circles.pop(0)
        if not is_steady(circle, [frames[0], frames[len(frames) // 2], frames[-1]]):
            reason = reason or NotMeasurableError(messages.CAMERA_MOVES())
            continue
        try:
            require_along_axis(circle)
            known = learn_colours(frames, circle)
        except NotMeasurableError as error:
            reason = reason or error
            continue
        share = known.reach(frames[:: max(1, len(frames) // 3)], circle)
        if share is None:
            continue
        if share > REACHED:
            return known, circle
        if not circles and not within_rim:
            # The inner edge of the rim stands out less than its outer one.
            circles.append(circle.scaled(share))
            within_rim = True
    raise reason or NotMeasurableError(messages.NO_SURFACE())


def _level_of(colours: Colours, circle: DrumCircle, focal: float | None) -> tuple[float, bool]:
    """Return the inclination of the horizontal on the front of the drum, degrees.

    And whether the sheet of markers tells it: without it, the rows of the picture are horizontal.
    """
    rows, columns = colours.shape[:2]
    middle = ((columns - 1) / 2, (rows - 1) / 2)
    focal = focal or USUAL_FOCAL * max(rows, columns)
    sheet = find_marker_sheet(colours, focal, middle)
    upward = np.array([0.0, -1.0])
    if sheet is not None:
        x, y = (np.array(circle.middle) - np.array(middle)) / focal
        upward = np.array([sheet.up[0] - x * sheet.up[2], sheet.up[1] - y * sheet.up[2]])
    x, y = circle.offset(upward)
    return -math.degrees(math.atan2(x, -y)), sheet is not None


def _beds(turn: float, heights: Array, size: DrumSize) -> tuple[list[PhotographedBed], bool]:
    """Return the bed at each level, rising towards positive places; and whether to the right."""
    by_level = heights.transpose(1, 0, 2)
    rises_right = turn > 0
    if not rises_right:
        turn, by_level = -turn, by_level[..., ::-1]
    return [PhotographedBed(turn, level, size) for level in by_level], rises_right


def _require_flowing(bed: PhotographedBed) -> None:
    if bed.turn > _STEEPEST:
        raise NotMeasurableError(messages.TURNS_OVER(angle=bed.turn))


def _require_turning(bed: PhotographedBed, speed: Response | None) -> None:
    _require_flowing(bed)
    if speed is None and float(bed.inclinations.std()) < _STILL:
        raise NotMeasurableError(messages.STILL_DRUM())


def _require_smooth(bed: PhotographedBed) -> None:
    count = len(bed.heights)
    share = _PARTICLES / math.sqrt(count) if count > 1 else _PARTICLES_IN_ONE
    particles = share * bed.roughness
    found, most = unevenness(bed.heights), max(_UNEVEN, particles)
    if found > most:
        raise NotMeasurableError(messages.UNEVEN_SURFACE(share=100 * found, most=100 * most))


def _require_sure(angles: Sequence[float], most: float = _UNSURE) -> None:
    """Raise `NotMeasurableError` if the dynamic angle hangs on where the surface is taken to be."""
    if np.ptp(angles) / 2 > most:
        raise NotMeasurableError(messages.UNSURE_SURFACE(low=min(angles), high=max(angles)))


def _corrected(found: DynamicAngles[PhotographedBed]) -> dict[str, Response]:
    """Return the angles of the mean surface from those of the outline."""
    rough = found.bed.roughness
    return {
        name: Response(value.value + rough * _HIGHEST[name][0], value.standard_error)
        for name, value in found.responses().items()
    }


def _unsure(found: Sequence[DynamicAngles[PhotographedBed]]) -> dict[str, dict[str, float]]:
    """Standard uncertainties by where the surface is taken to be, and by the particles."""
    values = [
        {name: flank.angle for name, flank in one.flanks().items()} | {"dynamic_angle": one.mean}
        for one in found
    ]
    _require_sure([one["dynamic_angle"] for one in values])
    spread = {name: np.ptp([one[name] for one in values]) / 2 for name in values[0]}
    rough = found[0].bed.roughness
    unsure = {
        name: {"surface": float(spread[name]), "particles": rough * _HIGHEST[name][1]}
        for name in values[0]
    }
    if None in found[0].bed.size:
        unsure["dynamic_angle"]["perspective"] = _PERSPECTIVE
    return unsure
