"""Angles of which each photograph is a repeat, measured when the file is read; slopes."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from grainfit.calibration_file import messages
from grainfit.calibration_file.originals import NamedFile, begun_with, groups_of, note_target
from grainfit.calibration_file.photographed import PHOTOS, Original, in_words
from grainfit.errors import InputError
from grainfit.options.kinds import OneOrMore, Quantity, Text
from grainfit.options.places import Place
from grainfit.options.tables import Key, Values

if TYPE_CHECKING:
    from grainfit.photographs.kept_repeats import KeptRepeats

#: Keys of friction on a wall that is measured on pictures of a slope.
SLOPE_KEYS = (
    Key(
        PHOTOS,
        OneOrMore(Text()),
        "Pictures of an inclined plane of the wall's material at which sliding or rolling begins, "
        "from the side, each a repeat, with * and ? as in a shell. They are measured when the file "
        "is read; the parameter is free about the tangent of the angle.",
        required=True,
        example='["plane_*.jpg"]',
    ),
    Key(
        "level",
        Quantity("deg", above_zero=True, highest=10.0),
        "Standard uncertainty of how level the camera is.",
        default="by the marker sheet where it is seen; otherwise 0.5 deg",
        example='"0.1 deg"',
    ),
)


def slope_in(values: Values, place: Place) -> tuple[float, float] | None:
    """Return the angle of photographed slopes and its standard uncertainty, degrees.

    None after noting a fault.
    """
    from grainfit.photographs.kept_repeats import SLOPE, slopes_once

    measure = partial(slopes_once, level=values.get("level"))
    found = measured_repeats(values, place, measure, SLOPE)
    if found is None:
        return None
    kept, files = found
    # As 'grainfit photo' prints them.
    value, error = (round(number, 2) for number in kept.angles[SLOPE])
    note_repeats(kept, files, SLOPE, in_words(value, error, kept.parts[SLOPE]), place)
    return value, error


def measured_repeats(
    values: Values, place: Place, measure: Callable[..., KeptRepeats], angle: str
) -> tuple[KeptRepeats, dict[str, NamedFile]] | None:
    """Measure once what the pictures of a target or a parameter show; None after a fault.

    Parameters
    ----------
    values : dict
        Keys of its table.
    place : Place
        Of it.
    measure : callable
        Returns what is kept of the pictures, by their hashes, the folder and ``keep_version``.
    angle : str
        The angle that is needed.

    Returns
    -------
    tuple of KeptRepeats and dict of str to NamedFile
        What was measured, and the pictures by their hashes.
    """
    from grainfit.photographs.kept import FOLDER

    groups = None if None in values.values() else groups_of(values[PHOTOS], place.at(PHOTOS))
    if groups is None:
        return None
    files = {one.sha256: one for group in groups for one in group}
    folder, begun = place.findings.work_folder() / FOLDER, begun_with(place)
    hashes: dict[Path, str] = {one.path: one.sha256 for one in files.values()}
    as_begun = begun == {one.file: one.sha256 for one in files.values()}
    try:
        kept = measure(hashes, folder, keep_version=as_begun)
    except InputError as error:
        # The words of the fault name the file.
        named = (one for one in files.values() if str(one.path) in str(error))
        next(named, next(iter(files.values()))).place.refuse(error.faults[0])
        return None
    except OSError as error:
        place.at(PHOTOS).fault(messages.NOT_KEPT, folder=folder, reason=error.strerror)
        return None
    if angle not in kept.angles:
        reasons = " ".join(kept.refused.values())
        place.at(PHOTOS).fault(messages.NO_PICTURE_MEASURED, reasons=reasons)
        return None
    return kept, files


def note_repeats(
    kept: KeptRepeats, files: Mapping[str, NamedFile], angle: str, result: str, place: Place
) -> None:
    """Keep with the findings what was measured: an angle, whose result is given in words."""
    note_target(
        [Original(one.file, one.sha256, kept.version, kept.name, {}) for one in files.values()],
        messages.REPEATS_PHOTOGRAPHED(
            response=place.key.replace("_", " "), result=result, count=len(kept.pictures)
        ),
        list(_said(kept, files, angle)),
        place,
    )


def _said(kept: KeptRepeats, files: Mapping[str, NamedFile], angle: str) -> Iterator[str]:
    for digest, angles in kept.pictures.items():
        if angle in angles:
            yield messages.REPEAT_MEASURED(file=files[digest].file, angle=angles[angle])
    for digest, reason in kept.refused.items():
        if angle not in kept.pictures.get(digest, {}):
            yield messages.PICTURE_REFUSED(file=files[digest].file, reason=reason)
