"""The camera: where up is in a picture, and what it makes of the flanks of a cone.

A cone whose flanks are inclined by a, seen from a direction e above the horizontal, shows flanks
that are inclined by a': the outline is made by the two generators whose normals are at right angles
to the line of sight. They lie behind the sides by the azimuth f with ``sin f = tan e / tan a``, and
in the picture ``tan^2 a' = tan^2 a cos^2 e - sin^2 e``. With e >= a there are none. All planes that
touch a cone go through its apex, so this holds in perspective, too, where the picture is turned to
the camera that looks at the apex.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy.optimize import least_squares
from scipy.spatial.distance import cdist

from grainfit.arrays import Array

#: Focal length of a picture that does not tell it, over its longer side: 29 mm on film, as the main
#: camera of telephones; and the range of it, from a wide one to a tele lens.
USUAL_FOCAL, FOCAL_RANGE = 0.8, (0.7, 4.0)
#: Circles of one foot agree within so many standard errors.
_ERRORS_APART = 3.0
#: What is left of the depth of the lower edge of a heap once its gaps are closed.
_CLOSED = 0.7


def apparent_angle(angle: float, elevation: float) -> float:
    """Return the inclination at which the flanks of a cone appear, degrees; NaN without flanks.

    Parameters
    ----------
    angle : float
        Inclination of the flanks, degrees.
    elevation : float
        Of the camera above the horizontal, seen from the apex, degrees.
    """
    e = math.radians(elevation)
    square = (math.tan(math.radians(angle)) * math.cos(e)) ** 2 - math.sin(e) ** 2
    return math.degrees(math.atan(math.sqrt(square))) if square > 0 else math.nan


def true_angle(apparent: float, elevation: float) -> float:
    """Return the inclination of the flanks of a cone from the one at which they appear, degrees."""
    e = math.radians(elevation)
    tangent = math.hypot(math.tan(math.radians(apparent)), math.sin(e)) / math.cos(e)
    return math.degrees(math.atan(tangent))


@dataclass(frozen=True)
class Camera:
    """A camera, and the upward direction in its axes.

    Parameters
    ----------
    focal : float
        Focal length, pixels.
    middle : tuple of float
        Where the optical axis is in the picture: column and row.
    up : ndarray of shape (3,)
        Unit vector: to the right, down and forward.
    """

    focal: float
    middle: tuple[float, float]
    up: Array

    def ray(self, place: tuple[float, float]) -> Array:
        """Return the unit vector from the camera to a place of the picture."""
        return ray(self.focal, self.middle, place)

    def elevation(self, place: tuple[float, float]) -> float:
        """Return the elevation of the camera seen from what is at a place, degrees."""
        return math.degrees(math.asin(float(np.clip(-self.ray(place) @ self.up, -1, 1))))

    def turned(self, place: tuple[float, float], origin: tuple[float, float]) -> Array:
        """Return the homography to the picture of a camera that looks at a place, upright.

        The place comes to `origin`; the scale there stays about as it is.
        """
        forward = self.ray(place)
        right = np.cross(forward, self.up)
        right /= np.linalg.norm(right)
        axes = np.array([right, np.cross(forward, right), forward])
        to_ray = np.array(
            [
                [1 / self.focal, 0, -self.middle[0] / self.focal],
                [0, 1 / self.focal, -self.middle[1] / self.focal],
                [0, 0, 1],
            ]
        )
        # The scale at the place: a picture is stretched away from its middle.
        scale = self.focal / float(forward[2])
        to_place = np.array([[scale, 0, origin[0]], [0, scale, origin[1]], [0, 0, 1.0]])
        found: Array = to_place @ axes @ to_ray
        return found


def ray(focal: float, middle: tuple[float, float], place: tuple[float, float]) -> Array:
    """Return the unit vector from a camera to a place of its picture."""
    found = np.array([(place[0] - middle[0]) / focal, (place[1] - middle[1]) / focal, 1.0])
    unit: Array = found / np.linalg.norm(found)
    return unit


def up_from(elevation: float, roll: float, towards: Array) -> Array:
    """Return the upward direction of a camera that is seen at an elevation from a ray's end.

    Parameters
    ----------
    elevation, roll : float
        rad.
    towards : ndarray of shape (3,)
        Unit vector to what is seen.
    """
    # The picture's upward direction at right angles to the ray, rolled about it.
    above = np.array([math.sin(roll), -math.cos(roll), 0.0])
    above -= towards * (towards @ above)
    above /= np.linalg.norm(above)
    up: Array = above * math.cos(elevation) - towards * math.sin(elevation)
    return up


@dataclass(frozen=True)
class Foot:
    """The circle of a heap's foot in a picture.

    Parameters
    ----------
    up : ndarray of shape (3,)
        Upward direction in the axes of the camera.
    elevation, error : float
        Of the camera, seen from the middle of the foot, and its standard error, degrees.
    roll : float
        rad.
    middle : tuple of float
        Where the middle of the foot is: column and row.
    radius : float
        Of the circle, over its distance from the camera.
    misfit, free : float
        Sum of the squares, robust, and degrees of freedom of the fit.
    """

    up: Array
    elevation: float
    error: float
    roll: float
    middle: tuple[float, float]
    radius: float
    misfit: float
    free: float

    def agrees_with(self, other: Foot) -> bool:
        """Return whether the edge is seen on this circle nearly as well as on a better one.

        By the ratio of their likelihoods, as far apart as three standard errors: the error of an
        elevation is no measure where the front of a foot is nearly straight.
        """
        worse = self.misfit / max(other.misfit, 1e-9) - 1
        return worse * other.free < _ERRORS_APART**2


def _depth_in_front(sine: float) -> float:
    """Depth of the lower edge of a heap behind that of a full ring of particles, in diameters.

    As `grainfit.measurement.angle_of_repose.outline_depth`, for the wedge between the plate and the
    flank: centres are spread at random, and a column of the picture shows a sphere within the depth
    g unless a volume of ``16/15 sqrt(d g) g^2 / (2 s)`` holds none, with
    ``s = sin e (cos e + sin e / tan a)``. An inclination a of 30 degrees is near enough.

    Parameters
    ----------
    sine : float
        Of the elevation e of the camera.
    """
    sine = min(max(sine, 0.0), 1.0)
    wedge = sine * (math.sqrt(1 - sine**2) + math.sqrt(3) * sine)
    number = 0.6 / (math.pi / 6)
    mean: float = math.gamma(1.4) * (8 / 15 * number / max(wedge, 1e-9)) ** -0.4
    return _CLOSED * mean


def foot_of(
    arc: Array,
    focal: float,
    middle: tuple[float, float],
    particle: float,
    up: Array | None = None,
    *,
    whole: bool = False,
) -> Foot:
    """Fit the circle of the outermost particles of a heap to the lower edge of its picture.

    The circle is in perspective. The edge is that of spheres whose centres are on the circle: it
    is farther out than the circle by half a particle diameter, less what there is between the
    foremost particles (`_depth_in_front`).

    Parameters
    ----------
    arc : ndarray of shape (n, 2)
        Lower edge of the heap: columns and rows.
    focal : float
        pixels.
    middle : tuple of float
        Where the optical axis is.
    particle : float
        Particle diameter, pixels.
    up : ndarray of shape (3,), optional
        Upward direction, where it is known.
    whole : bool
        Whether places of the whole circle are given, as of a plate, and not of its front only.
    """
    left, right = arc[arc[:, 0].argmin()], arc[arc[:, 0].argmax()]
    half = max(float(np.hypot(*(right - left))) / 2 - particle / 2, 1.0)
    centre = (left + right) / 2
    roll = math.atan2(right[1] - left[1], right[0] - left[0])
    depth = max(float(arc[:, 1].max() - centre[1]), 1.0)
    # The front, from left to right; the back of a heap is hidden.
    turn = np.radians(np.linspace(0, 360, 181) if whole else np.linspace(172, 368, 99))
    in_front = np.maximum(-np.sin(turn), 0.0)
    offset = np.array(middle)

    def edge(guess: Array) -> tuple[Array, Array]:
        towards = ray(focal, middle, (guess[2], guess[3]))
        upward = up_from(guess[0], guess[1], towards) if up is None else up
        across = np.cross(towards, upward)
        across /= np.linalg.norm(across)
        circle = np.outer(np.cos(turn), across) + np.outer(np.sin(turn), np.cross(upward, across))
        points = towards + guess[4] * circle
        places = points[:, :2] / points[:, 2:] * focal + offset
        tangent = np.gradient(places, axis=0)
        tangent /= np.linalg.norm(tangent, axis=1)[:, None]
        normal = np.column_stack([-tangent[:, 1], tangent[:, 0]])
        offset_of_edge = particle * (0.5 - _depth_in_front(-float(towards @ upward)) * in_front)
        return places + offset_of_edge[:, None] * normal, normal

    def misfit(guess: Array) -> Array:
        points, normal = edge(guess)
        nearest = cdist(arc, points, "sqeuclidean").argmin(axis=1)
        distance: Array = ((arc - points[nearest]) * normal[nearest]).sum(axis=1)
        return distance

    start = np.array(
        [
            math.asin(min(max(depth - particle / 2, 0.5) / half, 0.9)),
            roll,
            centre[0],
            centre[1],
            half / focal,
        ]
    )
    scale = np.array([0.05, 0.05, 5.0, 5.0, 0.01 * half / focal])
    limits = (
        [0.0, -0.3, *(centre - half), 0.5 * half / focal],
        [1.2, 0.3, *(centre + half), 2 * half / focal],
    )
    # Nearby, the circle of a plate is far from its ellipse: robust weights find no way from there.
    for loss in ("linear", "soft_l1") if whole else ("soft_l1",):
        fit = least_squares(
            misfit,
            start,
            x_scale=scale,
            bounds=limits,
            loss=loss,
            f_scale=max(particle / 4, 1.0),
            max_nfev=100,
        )
        start = fit.x
    # Neighbouring places of the edge show the same particle.
    length = float(np.abs(np.diff(arc[:, 0])).sum())
    independent = max(length / max(2 * particle, 4.0), 6.0)
    free = max(independent - 5, 1.0)
    variance = float(np.mean(fit.fun**2)) * len(arc) / free
    # By steps of a pixel: nearest places change from one to the next.
    steps = np.diag(scale / 5)
    jacobian = np.array(
        [(misfit(fit.x + step) - misfit(fit.x - step)) / (2 * step.sum()) for step in steps]
    )
    jacobian *= (1 + (fit.fun / max(particle / 4, 1.0)) ** 2) ** -0.25
    spread = np.linalg.pinv(jacobian @ jacobian.T) * variance
    towards = ray(focal, middle, (fit.x[2], fit.x[3]))
    found = up_from(fit.x[0], fit.x[1], towards) if up is None else up
    return Foot(
        found,
        math.degrees(math.asin(float(np.clip(-(towards @ found), -1, 1)))),
        math.degrees(math.sqrt(max(float(spread[0, 0]), 0.0))),
        float(fit.x[1]),
        (float(fit.x[2]), float(fit.x[3])),
        float(fit.x[4]),
        float(fit.cost),
        free,
    )
