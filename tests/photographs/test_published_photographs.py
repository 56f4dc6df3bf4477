"""Published pictures, and photographs of laboratories: those of a folder that a variable names.

``GRAINFIT_PHOTOGRAPHS`` is a folder with clones of the repositories in ``published_pictures.json``,
each under the name of the repository: pictures whose angle was traced by hand, and some that show
none. Or it has pictures of its own and a table, ``angles.csv``, with the columns ``file``, ``test``
(heap, drum or slope) and ``angle``: traced by hand, in degrees. A drum is a video, a folder of
stills, or one picture that is the mean of many. No picture is a part of grainfit.
"""

from __future__ import annotations

import csv
import hashlib
import json
import math
import os
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import grainfit as gf
from grainfit.photographs.drum import DrumSize, PhotographedBed, measure_still
from grainfit.photographs.pictures import is_picture, read_picture

FOLDER = os.environ.get("GRAINFIT_PHOTOGRAPHS", "")
#: Largest difference from the angle by hand, degrees, and least share that is measured.
WITHIN, MEASURED = 1.5, 0.8
PUBLISHED = json.loads(Path(__file__).with_name("published_pictures.json").read_text())

needs_photographs = pytest.mark.skipif(
    not FOLDER, reason="GRAINFIT_PHOTOGRAPHS names no folder of photographs"
)


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


def _in_clone(repository: str, path: str, sha256: str) -> Path | None:
    """Return a published picture; None where its repository was not cloned."""
    clone = Path(FOLDER) / repository.rpartition("/")[2]
    if not clone.is_dir():
        return None
    picture = clone / path
    digest = hashlib.sha256(picture.read_bytes()).hexdigest()
    assert digest == sha256, f"{picture} is not the picture that was traced: check out the commit"
    return picture


def _traced() -> Iterator[tuple[Path, str, float]]:
    """Yield pictures with their test and their angle by hand."""
    table = Path(FOLDER) / "angles.csv"
    if table.is_file():
        with table.open(encoding="utf-8") as file:
            for row in csv.DictReader(file):
                yield Path(FOLDER) / row["file"], row["test"], float(row["angle"])
    for one in PUBLISHED["traced"]:
        picture = _in_clone(one["repository"], one["path"], one["sha256"])
        if picture is not None:
            yield picture, one["test"], one["angle"]


def _angle_of(traced: dict[str, Any]) -> float:
    """Return the inclination of the line from a drum's middle to the centre of its bed.

    The bed is what is between the traced surface and the circle below it.
    """
    x, y, radius = traced["circle"]
    surface = np.array(traced["surface"]) - [x, y]
    last, first = (math.atan2(surface[end, 1], surface[end, 0]) for end in (-1, 0))
    turn = np.linspace(last, first + (2 * math.pi if first < last else 0), 400)
    edge = np.vstack([surface, radius * np.column_stack([np.cos(turn), np.sin(turn)])])
    following = np.roll(edge, -1, axis=0)
    doubled = edge[:, 0] * following[:, 1] - following[:, 0] * edge[:, 1]
    across, down = ((edge + following) * doubled[:, None]).sum(axis=0) / (3 * doubled.sum())
    return math.degrees(math.atan2(abs(across), down))


def test_the_angles_by_hand_are_those_of_the_traced_points() -> None:
    for one in PUBLISHED["traced"]:
        assert _angle_of(one) == pytest.approx(one["angle"], abs=0.01), one["path"]


@needs_photographs
def test_photographs_have_the_angles_that_were_traced_by_hand() -> None:
    refused: dict[str, str] = {}
    wrong: dict[str, tuple[float, float]] = {}
    traced = list(_traced())
    assert traced, "the folder has neither a table of angles nor a clone"
    for path, test, by_hand in traced:
        try:
            found = _measured(path, test)
        except gf.NotMeasurableError as error:
            refused[path.name] = str(error)
            continue
        print(f"{path.name}: {found:.2f} measured, {by_hand:.2f} by hand")
        if abs(found - by_hand) > WITHIN:
            wrong[path.name] = (found, by_hand)

    assert not wrong
    assert len(traced) - len(refused) >= MEASURED * len(traced), refused


@needs_photographs
@pytest.mark.parametrize("one", PUBLISHED["refused"], ids=lambda one: one["repository"])
def test_pictures_without_an_angle_are_refused(one: dict[str, Any]) -> None:
    found = [_in_clone(one["repository"], *picture) for picture in one["pictures"].items()]
    pictures = [picture for picture in found if picture is not None]
    if not pictures:
        pytest.skip(f"{one['repository']} was not cloned")
    with pytest.raises(gf.NotMeasurableError):
        gf.photo(pictures, one["test"])
