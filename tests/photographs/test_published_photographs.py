"""Photographs of laboratories: those of a folder that an environment variable names.

``GRAINFIT_PHOTOGRAPHS`` is a folder with pictures and a table, ``angles.csv``, with the columns
``file``, ``test`` (heap, drum or slope) and ``angle``: traced by hand, in degrees. A drum is a
video, a folder of stills, or one picture that is the mean of many.
"""

from __future__ import annotations

import csv
import os
from pathlib import Path

import pytest

import grainfit as gf
from grainfit.photographs.drum import DrumSize, PhotographedBed, measure_still
from grainfit.photographs.pictures import is_picture, read_picture

FOLDER = os.environ.get("GRAINFIT_PHOTOGRAPHS", "")
#: Largest difference from the angle by hand, degrees, and least share that is measured.
WITHIN, MEASURED = 1.5, 0.8


def _measured(path: Path, test: str) -> float:
    if test == "heap":
        return gf.photo(path).angle_of_repose.value
    if test == "slope":
        return gf.photo(path, "slope").angle.value
    if not is_picture(path):
        return gf.photo(path, "drum").dynamic_angle.value
    picture = read_picture(path)
    still = measure_still(path, picture.colours, picture.focal)
    bed = PhotographedBed(still.turn, still.heights[:1], DrumSize())
    return abs(float(bed.inclinations[0]))


@pytest.mark.skipif(not FOLDER, reason="GRAINFIT_PHOTOGRAPHS names no folder of photographs")
def test_photographs_of_laboratories_have_the_angles_that_were_traced_by_hand() -> None:
    folder = Path(FOLDER)
    with (folder / "angles.csv").open(encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    refused: dict[str, str] = {}
    wrong: dict[str, tuple[float, float]] = {}
    for row in rows:
        by_hand = float(row["angle"])
        try:
            found = _measured(folder / row["file"], row["test"])
        except gf.NotMeasurableError as error:
            refused[row["file"]] = str(error)
            continue
        if abs(found - by_hand) > WITHIN:
            wrong[row["file"]] = (found, by_hand)

    assert not wrong
    assert len(rows) - len(refused) >= MEASURED * len(rows), refused
