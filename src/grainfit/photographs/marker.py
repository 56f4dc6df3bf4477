"""A printed sheet of markers: it tells where up is in a picture, and how long a pixel is."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from grainfit.arrays import Array
from grainfit.files import in_place_of
from grainfit.photographs.pictures import opencv

#: Paper (A4, across), side of a marker, and its distance from the edges of the paper, m.
WIDTH, HEIGHT = 0.297, 0.210
SIDE, _EDGE = 0.040, 0.012
#: Markers, from the far left clockwise, and modules along a side of one, border included.
MARKERS, _MODULES = (0, 1, 2, 3), 6
#: Fewest markers that tell where the sheet is.
_FEWEST = 2
#: Standard uncertainty of the sheet's being level, degrees, and of a corner, pixels.
_LEVEL, _CORNER = 0.2, 0.5
#: Corners of a flat sheet are where they should be within these, over the side of a marker.
_FLAT = 0.04
_POINTS = 72 / 0.0254
_WORDS = (
    "grainfit: print at 100 %, this line is 100 mm long. Lay it flat and level below the heap, or "
    "before it."
)


@dataclass(frozen=True)
class MarkerSheet:
    """The sheet of markers in a picture.

    Parameters
    ----------
    up : ndarray of shape (3,)
        Upward direction in the axes of the camera.
    elevation, error : float
        Of the camera, seen from the middle of the sheet, and its standard uncertainty, degrees.
    edge : ndarray of shape (4, 2)
        Corners of the sheet, columns and rows.
    height : float
        Of the camera above the sheet, m.
    """

    up: Array
    elevation: float
    error: float
    edge: Array
    height: float


def find_marker_sheet(
    colours: NDArray[np.uint8], focal: float, middle: tuple[float, float]
) -> MarkerSheet | None:
    """Find the sheet of markers; None where fewer than two of its markers are seen.

    Parameters
    ----------
    colours : ndarray of uint8 of shape (rows, columns, 3)
        The picture.
    focal : float
        Focal length, pixels.
    middle : tuple of float
        Where the optical axis is: column and row.
    """
    cv2 = opencv()
    options = cv2.aruco.DetectorParameters()
    options.cornerRefinementMethod = cv2.aruco.CORNER_REFINE_SUBPIX
    grey = cv2.cvtColor(colours, cv2.COLOR_RGB2GRAY)
    found, numbers, _ = cv2.aruco.ArucoDetector(_dictionary(), options).detectMarkers(grey)
    seen = {} if numbers is None else dict(zip(numbers.ravel().tolist(), found, strict=True))
    known = [number for number in MARKERS if number in seen]
    if len(known) < _FEWEST:
        return None
    places = np.concatenate([_corners(number) for number in known])
    corners = np.concatenate([seen[number].reshape(4, 2) for number in known]).astype(float)
    lens = np.array([[focal, 0, middle[0]], [0, focal, middle[1]], [0, 0, 1.0]])
    ok, turn, shift = cv2.solvePnP(places, corners, lens, None, flags=cv2.SOLVEPNP_IPPE)
    if not ok:
        return None
    turn, shift = cv2.solvePnPRefineLM(places, corners, lens, None, turn, shift)
    projected, slopes = cv2.projectPoints(places, turn, shift, lens, None)
    off = projected.reshape(-1, 2) - corners
    side = float(np.mean([np.ptp(seen[number][0], axis=0).max() for number in known]))
    if np.sqrt((off**2).sum(axis=1).mean()) > max(_FLAT * side, 1.0):
        return None
    slopes = slopes[:, :6]
    noise = max(float((off**2).sum()) / (off.size - 6), _CORNER**2)
    spread = np.linalg.cholesky(np.linalg.inv(slopes.T @ slopes) * noise)
    elevation = _elevation(turn, shift)
    changes = [
        _elevation(turn + step[:3, None], shift + step[3:, None]) - elevation for step in spread.T
    ]
    up = _up(turn)
    edge = cv2.projectPoints(_paper(), turn, shift, lens, None)[0].reshape(-1, 2)
    return MarkerSheet(
        up,
        elevation,
        math.hypot(_LEVEL, *changes),
        edge,
        float(-up @ shift.ravel()),
    )


def write_marker_sheet(path: Path) -> None:
    """Write the sheet as a PDF of one page, to be printed at its own size."""
    # Imported here: reports read pictures and draw no sheet.
    from reportlab.pdfgen.canvas import Canvas

    cv2 = opencv()
    boxes = []
    for number in MARKERS:
        bits = cv2.aruco.generateImageMarker(_dictionary(), number, _MODULES)
        left, top = _corners(number)[0, :2]
        module = SIDE / _MODULES
        boxes += [
            (left + column * module, top - (row + 1) * module, module, module)
            for row, column in np.argwhere(bits == 0)
        ]
    # A scale of 100 mm, to be measured on the print.
    boxes.append((-0.05, -HEIGHT / 2 + _EDGE, 0.1, 0.0006))
    with in_place_of(path) as place:
        canvas = Canvas(str(place), pagesize=(_POINTS * WIDTH, _POINTS * HEIGHT), invariant=1)
        for x, y, width, height in boxes:
            left, bottom = x + WIDTH / 2, y + HEIGHT / 2
            canvas.rect(*(_POINTS * one for one in (left, bottom, width, height)), 0, 1)
        canvas.setFont("Helvetica", 7)
        canvas.drawCentredString(_POINTS * WIDTH / 2, _POINTS * (_EDGE + 0.003), _WORDS)
        canvas.showPage()
        canvas.save()


def _dictionary() -> Any:
    cv2 = opencv()
    return cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_4X4_50)


def _corners(number: int) -> Array:
    """Return the corners of a marker on the sheet, clockwise from its far left, m.

    The middle of the sheet is the origin, x is to the right, y away, z up.
    """
    half = (WIDTH / 2 - _EDGE - SIDE / 2, HEIGHT / 2 - _EDGE - SIDE / 2)
    signs = ((-1, 1), (1, 1), (1, -1), (-1, -1))
    middle = np.array([half[0] * signs[number][0], half[1] * signs[number][1]])
    flat = middle + SIDE / 2 * np.array(signs)
    return np.column_stack([flat, np.zeros(4)])


def _paper() -> Array:
    x, y = WIDTH / 2, HEIGHT / 2
    return np.array([[-x, y, 0], [x, y, 0], [x, -y, 0], [-x, -y, 0.0]])


def _up(turn: Array) -> Array:
    found: Array = opencv().Rodrigues(turn)[0][:, 2]
    return found


def _elevation(turn: Array, shift: Array) -> float:
    """Return the elevation of the camera seen from the middle of the sheet, degrees."""
    towards = shift.ravel() / np.linalg.norm(shift)
    return math.degrees(math.asin(float(np.clip(-towards @ _up(turn), -1, 1))))
