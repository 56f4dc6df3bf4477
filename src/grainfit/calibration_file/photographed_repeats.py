"""Angles of which each photograph is a repeat, measured when the file is read; slopes."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from functools import partial
from typing import TYPE_CHECKING

from grainfit.calibration_file import messages
from grainfit.calibration_file.originals import (
    NamedFile,
    groups_of,
    measured_once,
    note_target,
)
from grainfit.calibration_file.photographed import PHOTOS, Original, in_words
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
    groups = None if None in values.values() else groups_of(values[PHOTOS], place.at(PHOTOS))
    if groups is None:
        return None
    files = {one.sha256: one for group in groups for one in group}
    kept = measured_once(measure, list(files.values()), place, place.at(PHOTOS))
    if kept is None:
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
