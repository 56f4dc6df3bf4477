"""Measure the dynamic angle on published pictures of a drum, which fill the pictures.

Clone ``uob-positron-imaging-centre/DigitalTwins``,
``uob-positron-imaging-centre/ACCES-GranuDrum-Calibration`` and
``anicusan/InteractiveGranuDrumCalibration`` from GitHub into one folder, then

    python -m studies.benchmarks pictures --clones FOLDER

The angle is that of the line from the axis to the centre of the bed, as of a simulated drum.
"""

from __future__ import annotations

import csv
import itertools
import math
from collections.abc import Iterable, Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from PIL import Image
from scipy import ndimage

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
        _write("photographs", ["calibration", "speed_rpm", "angle_deg", "fill"], photographs),
        _write("lookup", ["size_mm", "restitution", "sliding", "rolling", *speeds], simulated),
    ]


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
