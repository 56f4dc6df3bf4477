"""Angle of repose of a heap from silhouettes at several azimuths.

A silhouette shows not the heap's surface but its outermost particles. Far from the axis
many particles compete for the outline and it lies close under the surface that envelops them all;
near the axis few do and it lies deeper. A line fitted to the outline is therefore too flat, by
about half a degree for a heap some ten particle diameters high. `outline_depth` gives that depth in
closed form, and it is added to the outline before anything is fitted.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from grainfit.arrays import Array
from grainfit.errors import NotMeasurableError
from grainfit.evaluation import Response
from grainfit.measurement import messages
from grainfit.measurement.grid import require_grid
from grainfit.measurement.particles import Particles
from grainfit.measurement.silhouette import Silhouette, render_silhouette

#: Resolution of silhouettes and outlines: pixels in a particle diameter.
PIXELS_PER_DIAMETER = 20
#: The flanks are fitted between these parts of the height above the ground.
_WINDOW = (0.1, 0.9)
#: Solid fraction of a randomly packed heap.
_SOLID_FRACTION = 0.6
#: A heap lower than this above the ground, in diameters, has no flank but single particles.
_LOWEST_HEAP = 1.5
#: A flank shorter than this, in diameters, is a step.
_SHORTEST_FLANK = 2.0
#: Flanks outside these inclinations are a layer or a wall, degrees.
_FLANK_LIMITS = (2.0, 60.0)
#: Flanks this many degrees of azimuth apart show different particles.
_CORRELATION_AZIMUTH = 60.0
#: Share of all flanks that must be measurable, and the largest standard error, degrees.
_FEWEST_FLANKS = 0.75
_LARGEST_ERROR = 2.0
#: Largest distance of the heap's centroid from the axis, in radii of the heap's base.
_LARGEST_OFFSET = 0.15
#: Largest difference between the inclinations of the upper and the lower half of the flanks,
#: degrees, and in standard errors: cones of simulated beads have one of 0 to 5 degrees.
_LARGEST_BEND, _SIGNIFICANT = 15.0, 3.0


@dataclass(frozen=True)
class Flank:
    """One side of a heap in one silhouette.

    Parameters
    ----------
    angle : float
        Inclination to the horizontal, degrees.
    start, end : tuple of float
        Lower and upper end of the fitted line, horizontal coordinate and height, m.
    """

    angle: float
    start: tuple[float, float]
    end: tuple[float, float]


@dataclass(frozen=True)
class View:
    """A heap seen from one azimuth.

    Parameters
    ----------
    azimuth : float
        Angle about the z axis between the x axis and the picture's horizontal axis, degrees.
    left, right : Flank or None
        Its two flanks; None where there is none to measure.
    """

    azimuth: float
    left: Flank | None
    right: Flank | None


@dataclass(frozen=True)
class AngleOfRepose:
    """Angle of repose of one heap.

    Parameters
    ----------
    value : float
        Mean inclination of the flanks, degrees.
    standard_error : float
        Standard error of `value` as a measurement of this heap, degrees.
    views : tuple of View
        Fitted flanks, one view for each azimuth.
    """

    value: float
    standard_error: float
    views: tuple[View, ...]

    @property
    def response(self) -> Response:
        """Value and standard error, degrees."""
        return Response(self.value, self.standard_error)


def on_plate(particles: Particles, plate_radius: float) -> Particles:
    """Return the particles that lie on the plate; the others fell off its edge.

    A particle lies on the plate if its centre is above the plate (z > 0) and no further from the
    z axis than the plate's radius plus a quarter of a particle diameter.
    """
    if len(particles) == 0:
        return particles
    distance = np.hypot(particles.positions[:, 0], particles.positions[:, 1])
    reach = plate_radius + particles.diameter / 4
    return particles.select((particles.positions[:, 2] > 0) & (distance < reach))


def heap_silhouette(heap: Particles, azimuth: float, plate_radius: float) -> Silhouette:
    """Render the silhouette that `angle_of_repose` measures from one azimuth (degrees).

    The picture ends where no heap of these particles could reach, however flat or steep, so that a
    particle that flew away does not make it huge.
    """
    diameter = heap.diameter
    top = float((heap.positions[:, 2] + heap.radii).max())
    volume = 4 / 3 * math.pi * float((heap.radii**3).sum()) / _SOLID_FRACTION
    flattest, steepest = (math.tan(math.radians(limit)) for limit in _FLANK_LIMITS)
    widest = (3 * volume / (math.pi * flattest)) ** (1 / 3)
    highest = 2 * (3 * volume * steepest**2 / math.pi) ** (1 / 3)
    return render_silhouette(
        heap,
        azimuth,
        min(plate_radius, widest) + diameter,
        min(top, highest) + diameter,
        diameter / PIXELS_PER_DIAMETER,
    )


def azimuths_of(views: int) -> list[float]:
    """Return azimuths that are evenly spread over half a turn, degrees."""
    return [180.0 * view / views for view in range(views)]


def heap_silhouettes(heap: Particles, plate_radius: float, views: int) -> list[Silhouette]:
    """Render the silhouettes of a heap from all `azimuths_of` so many views; none of no heap."""
    if not len(heap):
        return []
    return [heap_silhouette(heap, azimuth, plate_radius) for azimuth in azimuths_of(views)]


def angle_of_repose(
    particles: Particles,
    ground: float,
    plate_radius: float,
    views: int = 12,
    silhouettes: Sequence[Silhouette] | None = None,
) -> AngleOfRepose:
    """Measure the angle of repose of a heap about the z axis.

    Parameters
    ----------
    particles : Particles
        The particles at rest, on a plate at z = 0; those that fell off the plate are ignored.
    ground : float
        Height from which the heap's height is measured, m; the flanks are fitted between 10 and
        90 % of it. This is the plate's rim or, without a rim, one particle diameter, because the
        lowest layer is held by the plate and not by the heap.
    plate_radius : float
        Radius of the plate, m.
    views : int
        Number of azimuths, evenly spread over half a turn.
    silhouettes : sequence of Silhouette, optional
        Those of `heap_silhouettes`, if they have been rendered already.

    Returns
    -------
    AngleOfRepose
        The mean inclination of all flanks, and the views it was measured on.

    Raises
    ------
    NotMeasurableError
        There is no heap with flanks all around, and why.
    """
    heap = on_plate(particles, plate_radius)
    if len(heap) == 0:
        raise NotMeasurableError(messages.NOT_ON_PLATE(count=len(particles)))
    if silhouettes is None:
        silhouettes = heap_silhouettes(heap, plate_radius, views)
    return angle_of_repose_in(silhouettes, azimuths_of(views), ground, heap.diameter)


def angle_of_repose_in(
    silhouettes: Sequence[Silhouette],
    azimuths: Sequence[float],
    ground: float,
    diameter: float,
) -> AngleOfRepose:
    """Measure the angle of repose of a heap on its silhouettes, rendered or photographed.

    Parameters
    ----------
    silhouettes : sequence of Silhouette
        The heap from different sides; its axis is at the horizontal coordinate 0.
    azimuths : sequence of float
        Azimuth of each silhouette, degrees.
    ground : float
        Height from which the flanks are measured, m.
    diameter : float
        Median particle diameter, m.

    Raises
    ------
    NotMeasurableError
        There is no heap with flanks all around, and why.
    """
    try:
        return _measure(silhouettes, azimuths, ground, diameter)
    except NotMeasurableError as error:
        raise NotMeasurableError(messages.NO_ANGLE(reason=error)) from None


def outline_depth(distance: Array, angle: float, diameter: float) -> Array:
    """Mean depth of a conical heap's outline below the surface that envelops its particles.

    The centres of the particles are taken as spread at random, with the number density of a random
    packing, under a cone. A column of the silhouette at distance u from the axis shows a sphere
    that reaches to within the normal depth g of the enveloping cone unless a certain volume holds
    no centre. That volume is a parabola along the flank (spheres curve down) times a parabola
    across it (the cone does), which gives ``P(depth > g) = exp(-pi n g^2 sqrt(r u / sin(angle)))``
    and by integration the mean ``1 / (2 sqrt(n)) (r u / sin(angle))^(-1/4)``, here turned from the
    normal into the vertical direction.

    Parameters
    ----------
    distance : ndarray
        Horizontal distance from the axis, m.
    angle : float
        Inclination of the cone, degrees.
    diameter : float
        Particle diameter, m.

    Returns
    -------
    ndarray
        Mean vertical depth, m.
    """
    number_density = _SOLID_FRACTION / (math.pi / 6 * diameter**3)
    # A flatter or nearer outline than this is seen by no flank that can be measured.
    inclination = math.radians(max(angle, _FLANK_LIMITS[0]))
    reach = np.maximum(distance, diameter / 2) * (diameter / 2) / math.sin(inclination)
    depth: Array = reach**-0.25 / (2 * math.sqrt(number_density) * math.cos(inclination))
    return depth


def _measure(
    silhouettes: Sequence[Silhouette], azimuths: Sequence[float], ground: float, diameter: float
) -> AngleOfRepose:
    distance, outlines = _radial_outlines(silhouettes, diameter)
    profile = _smooth(outlines.mean(axis=0))
    _require_heap(distance, outlines, profile, ground, diameter)
    window = _window(outlines, profile, ground, diameter)
    flanks = _fit_flanks(distance[window], outlines[:, window], diameter)
    angles = np.array([math.nan if flank is None else flank.angle for flank in flanks])
    error = _require_flanks(angles)
    _require_one_slope(distance[window], outlines[:, window], float(np.nanmean(angles)), diameter)
    views = tuple(
        View(azimuth, _mirror(flanks[2 * i + 1]), flanks[2 * i])
        for i, azimuth in enumerate(azimuths)
    )
    return AngleOfRepose(float(np.nanmean(angles)), error, views)


def _radial_outlines(silhouettes: Sequence[Silhouette], diameter: float) -> tuple[Array, Array]:
    """Outlines over the distance from the axis: right and left half of each view, one per row."""
    reach = max(float(np.abs(s.columns).max()) for s in silhouettes)
    step = diameter / PIXELS_PER_DIAMETER
    require_grid("outlines", 2 * len(silhouettes), reach / step)
    distance = np.arange(0.5, round(reach / step), dtype=np.float64) * step
    rows = []
    for silhouette in silhouettes:
        outline = np.nan_to_num(silhouette.outline(), nan=0.0)
        rows += [
            np.interp(side * distance, silhouette.columns, outline, left=0.0, right=0.0)
            for side in (1, -1)
        ]
    return distance, np.array(rows)


def _smooth(profile: Array) -> Array:
    """Moving mean over two particle diameters of a profile that is mirrored at the axis."""
    size = 2 * PIXELS_PER_DIAMETER
    mirrored = np.concatenate([profile[::-1], profile])
    smooth: Array = np.convolve(mirrored, np.ones(size) / size, "same")[len(profile) :]
    return smooth


def _require_heap(
    distance: Array, outlines: Array, profile: Array, ground: float, diameter: float
) -> None:
    apex = float(profile.max())
    lowest = max(ground, diameter) + _LOWEST_HEAP * diameter
    if apex < lowest:
        raise NotMeasurableError(messages.NO_HEAP(height=apex / diameter, needed=lowest / diameter))
    above = np.maximum(outlines - ground, 0.0)
    right, left = above[0::2], above[1::2]
    areas = (right + left).sum(axis=1)
    offsets = (right - left) @ distance / np.where(areas > 0, areas, 1.0)
    # Radius of the cone that has the silhouette's mean distance from the axis.
    base = 3 * float((above @ distance).sum() / above.sum())
    offset = float(np.abs(offsets).max())
    if offset > _LARGEST_OFFSET * base:
        raise NotMeasurableError(
            messages.ONE_SIDED_HEAP(offset=offset / diameter, base=base / diameter)
        )


def _window(outlines: Array, profile: Array, ground: float, diameter: float) -> slice:
    """Columns of the flanks, chosen by position: choosing by height would bias the slope."""
    low, high = (ground + part * (profile.max() - ground) for part in _WINDOW)
    begin = len(profile) - int(np.argmax(profile[::-1] > high))
    # The lowest layer has no slope, and where it ends at the plate's edge there is a step.
    below = np.flatnonzero(profile[begin:] < max(low, diameter))
    foot = begin + int(below[0]) if len(below) else len(profile)
    reach = outlines.shape[1] - np.argmax(outlines[:, ::-1] > 0, axis=1)
    end = min(foot, int(np.median(reach)) - PIXELS_PER_DIAMETER)
    if end - begin < _SHORTEST_FLANK * PIXELS_PER_DIAMETER:
        raise NotMeasurableError(messages.COLUMN_OR_LAYER(height=profile.max() / diameter))
    return slice(begin, end)


def _require_flanks(angles: Array) -> float:
    """Return the standard error of their mean."""
    found = angles[np.isfinite(angles)]
    if len(found) < _FEWEST_FLANKS * len(angles):
        low, high = _FLANK_LIMITS
        counts = {"found": len(found), "count": len(angles), "percent": 100 * _FEWEST_FLANKS}
        raise NotMeasurableError(messages.FEW_FLANKS(**counts, low=low, high=high))
    error = _standard_error(found)
    if error > _LARGEST_ERROR:
        raise NotMeasurableError(messages.FLANKS_DISAGREE(low=found.min(), high=found.max()))
    return error


def _require_one_slope(distance: Array, outlines: Array, angle: float, diameter: float) -> None:
    """Raise `NotMeasurableError` if the flanks are bent: one angle would be that of neither part.

    A cohesive heap may stand as a stump on a flat foot, or have a rounded top.
    """
    surfaces = outlines + outline_depth(distance, angle, diameter)
    middle = len(distance) // 2
    parts = np.array(
        [
            [
                math.degrees(math.atan(-robust_line(distance[part], surface[part])[0]))
                for part in (slice(middle), slice(middle, None))
            ]
            for surface in surfaces
        ]
    )
    upper, lower = parts.mean(axis=0)
    error = _standard_error(parts[:, 0] - parts[:, 1])
    if abs(upper - lower) > max(_LARGEST_BEND, _SIGNIFICANT * error):
        raise NotMeasurableError(messages.TWO_SLOPES(upper=upper, lower=lower))


def _fit_flanks(distance: Array, outlines: Array, diameter: float) -> list[Flank | None]:
    slope, _ = np.polyfit(distance, outlines.mean(axis=0), 1)
    flanks: list[Flank | None] = []
    # The depth depends weakly on the angle: two iterations converge to a hundredth of a degree.
    for _ in range(3):
        depth = outline_depth(distance, math.degrees(math.atan(-slope)), diameter)
        lines = [robust_line(distance, outline + depth) for outline in outlines]
        slope = float(np.median([line[0] for line in lines]))
    for (slope, intercept), outline in zip(lines, outlines, strict=True):
        angle = math.degrees(math.atan(-slope))
        if not _FLANK_LIMITS[0] <= angle <= _FLANK_LIMITS[1] or not outline.all():
            flanks.append(None)
            continue
        lower, upper = float(distance[-1]), float(distance[0])
        drawn = intercept - float(depth.mean())
        flanks.append(Flank(angle, (lower, slope * lower + drawn), (upper, slope * upper + drawn)))
    return flanks


def robust_line(x: Array, y: Array) -> tuple[float, float]:
    """Slope and intercept with Huber's weights, which a particle perched on a flank cannot tilt.

    References
    ----------
    Huber, Robust Statistics (1981); 1.345 gives 95 % efficiency on normal residuals.
    """
    weights = np.ones_like(x)
    smallest = 1e-6 * float(np.ptp(x))
    for _ in range(10):
        total = weights.sum()
        mean_x, mean_y = weights @ x / total, weights @ y / total
        along, across = x - mean_x, y - mean_y
        slope = weights @ (along * across) / (weights @ along**2)
        residuals = np.abs(across - slope * along)
        limit = 1.345 * 1.4826 * max(_median(residuals), smallest)
        weights = limit / np.maximum(residuals, limit)
    return float(slope), float(mean_y - slope * mean_x)


def _median(values: Array) -> float:
    """Return what `numpy.median` does, in a quarter of its time for a hundred values."""
    ordered = np.sort(values)
    return float(ordered[(len(values) - 1) // 2] + ordered[len(values) // 2]) / 2.0


def _mirror(flank: Flank | None) -> Flank | None:
    if flank is None:
        return None
    return Flank(flank.angle, (-flank.start[0], flank.start[1]), (-flank.end[0], flank.end[1]))


def _standard_error(angles: Array) -> float:
    """Standard error of the mean inclination of flanks that partly show the same particles.

    A flank shows the particles of about 60 degrees of azimuth: on simulated heaps of glass beads
    and on synthetic cones the correlation of two flanks' angles is 0.7, 0.4, 0.2 and 0.1 when they
    are 15, 30, 45 and 60 degrees apart, and its integral is 60 degrees. So any number of
    views counts as six flanks. One heap is too little to estimate its own correlation from: that
    scattered twice as much and was no better on average.
    """
    independent = min(float(len(angles)), 360.0 / _CORRELATION_AZIMUTH)
    return float(np.std(angles)) / math.sqrt(independent - 1)
