"""Measure the dynamic angle on published pictures of a drum, which fill the pictures.

Clone ``uob-positron-imaging-centre/DigitalTwins``,
``uob-positron-imaging-centre/ACCES-GranuDrum-Calibration`` and
``anicusan/InteractiveGranuDrumCalibration`` from GitHub into one folder, then

    python -m studies.benchmarks pictures --clones FOLDER

The angle is that of the line from the axis to the centre of the bed, as of a simulated drum. It is
also measured on the particles of two published simulations, whose outline is a picture as well.
"""

from __future__ import annotations

import csv
import itertools
import math
import re
from collections.abc import Iterable, Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from PIL import Image
from scipy import ndimage
from scipy.spatial import cKDTree

from studies.benchmarks.published import DATA

#: Speeds of the look-up, rpm.
LOOKUP_SPEEDS = (10, 30, 50)
_SIZES, _RESTITUTIONS = (1.1, 1.5), (0.1, 0.5, 0.9, 0.99)
_SLIDINGS, _ROLLINGS = (0.15, 0.2, 0.3, 0.5, 0.8, 1.0), (0.0, 0.01, 0.05, 0.1, 0.2, 0.4, 0.7)
#: Pictures of one powder: calibration that used them, speed in rpm, path below the clones.
_PHOTOGRAPHS = (
    ("first", 45, "DigitalTwins/GranuDrum/access_calibration/granudrum_45rpm_mcc.bmp"),
    *(
        (
            "second",
            speed,
            "ACCES-GranuDrum-Calibration/ACCES-DEM-Calibration/Measurements/"
            f"gd_nature_{speed}rpm_averaged.bmp",
        )
        for speed in (10, 15, 30, 45)
    ),
)
#: Published particles: speed in rpm, and their folder below the clones.
_PARTICLES = {
    speed: f"ACCES-GranuDrum-Calibration/ACCES-DEM-Calibration/TrialSimulations/"
    f"sim0144_{speed}rpm/post"
    for speed in (15, 45)
}
_DRUM_RADIUS, _PIXELS = 0.042, 401
#: Share of the radius within which the bed is looked for: the edge of the drum is drawn.
_WITHIN = 0.94
#: Share of the median brightness of the bed from which a place is of the bed.
_BRIGHT = 0.35
_FAINT = 40


def measure_pictures(clones: Path) -> list[Path]:
    """Write the tables of angles; return their paths."""
    photographs = [
        (series, speed, *_rounded(_measured(clones / path, is_dark=True)))
        for series, speed, path in _PHOTOGRAPHS
    ]
    folder = clones / "InteractiveGranuDrumCalibration"
    simulated = []
    grids = [range(1, 3), range(4), range(6), range(7)]
    for size, restitution, sliding, rolling in itertools.product(*grids):
        # The last number is the cohesion: none.
        name = f"gd_{size}_{restitution}_{sliding}_{rolling}_0.jpg"
        angles = [
            _rounded(_measured(folder / f"gd_{speed}rpm_images" / name, is_dark=False))[0]
            for speed in LOOKUP_SPEEDS
        ]
        given = (_SIZES[size - 1], _RESTITUTIONS[restitution])
        simulated.append((*given, _SLIDINGS[sliding], _ROLLINGS[rolling], *angles))
    speeds = [f"angle_{speed}rpm_deg" for speed in LOOKUP_SPEEDS]
    return [
        measure_particles(clones),
        _write("photographs", ["calibration", "speed_rpm", "angle_deg", "fill"], photographs),
        _write("lookup", ["size_mm", "restitution", "sliding", "rolling", *speeds], simulated),
    ]


def measure_particles(clones: Path) -> Path:
    """Write the angles of published particles, by centre of mass and by outline; return the path.

    Parameters
    ----------
    clones : Path
        Folder with the clone of ``ACCES-GranuDrum-Calibration``.
    """
    rows = []
    for speed, folder in _PARTICLES.items():
        states = [_read_vtk(path) for path in sorted((clones / folder).glob("particles_*.vtk"))]
        angles = np.array([_angles(*state) for state in states])
        volume = float((4 / 3 * math.pi * states[0][1] ** 3).sum())
        row = (speed, len(states), len(states[0][1]), *angles.mean(axis=0), angles[:, 0].std())
        rows.append((*row[:3], *(round(value, 2) for value in row[3:]), f"{volume:.4g}"))
    angles_of = ("angle_deg", "outline_deg", "scatter_deg")
    return _write("particles", ["speed_rpm", "states", "count", *angles_of, "volume_m3"], rows)


def _read_vtk(path: Path) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Read positions and radii of particles, m, from a binary VTK file of LIGGGHTS."""
    content = path.read_bytes()
    points = re.search(rb"POINTS (\d+) float\n", content)
    assert points
    count, start = int(points[1]), points.end()
    places = np.frombuffer(content, ">f4", 3 * count, start).reshape(-1, 3)
    found = re.search(rb"radius 1 %d double\n" % count, content)
    assert found
    radii = np.frombuffer(content, ">f8", count, found.end())
    return places.astype(float), radii.astype(float)


def _angles(places: NDArray[np.float64], radii: NDArray[np.float64]) -> tuple[float, float]:
    """Return the inclination by the centre of mass, and by the outline seen along the drum."""
    centre = np.average(places, axis=0, weights=radii**3)
    along = np.linspace(-1, 1, _PIXELS) * _DRUM_RADIUS
    pixels = np.stack(np.meshgrid(along, along), axis=-1).reshape(-1, 2)
    pixels = pixels[np.hypot(*pixels.T) < _WITHIN * _DRUM_RADIUS]
    near = cKDTree(places[:, [0, 2]]).query(pixels)[0] < np.median(radii)
    x, z = pixels[near].mean(axis=0)
    first, second = (
        math.degrees(math.atan2(-one, -two)) for one, two in ((centre[0], centre[2]), (x, z))
    )
    return first, second


def _measured(path: Path, *, is_dark: bool) -> tuple[float, float]:
    """Return the dynamic angle, degrees, and the share of the drum that the bed takes."""
    with Image.open(path) as picture:
        grey = np.asarray(picture.convert("L"), dtype=float)
    side = len(grey)
    row, column = np.mgrid[0:side, 0:side]
    across, up = (column - (side - 1) / 2) / (side / 2), ((side - 1) / 2 - row) / (side / 2)
    inside = np.hypot(across, up) < _WITHIN
    bed: NDArray[np.bool_]
    if is_dark:
        bed = inside & (grey < (grey[inside].max() + grey[inside].min()) / 2)
    else:
        smooth = ndimage.gaussian_filter(grey, side / 200)
        bed = inside & (smooth > _BRIGHT * np.median(smooth[inside & (smooth > _FAINT)]))
    angle = math.degrees(math.atan2(-across[bed].mean(), -up[bed].mean()))
    return angle, float(bed.sum() / inside.sum())


def _rounded(measured: tuple[float, float]) -> tuple[float, float]:
    return round(measured[0], 2), round(measured[1], 3)


def _write(name: str, header: Sequence[str], rows: Iterable[Sequence[object]]) -> Path:
    path = DATA / "granudrum" / f"{name}.csv"
    with path.open("w", encoding="utf-8", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(header)
        writer.writerows(rows)
    return path
