"""Targets that are measured on videos or photographs of a drum when the file is read."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict
from functools import partial
from typing import TYPE_CHECKING, Any

from grainfit.calibration_file import messages
from grainfit.calibration_file.originals import (
    NamedFile,
    groups_of,
    measured_once,
    note_target,
)
from grainfit.calibration_file.photographed import PHOTOS, Original, in_words
from grainfit.calibration_file.photos import OF_ANGLE, measured_now, target_of
from grainfit.calibration_file.targets import TargetTable
from grainfit.evaluation import Response
from grainfit.formatting import turns_per_minute
from grainfit.options.kinds import Flag, OneOrMore, Quantity, Text
from grainfit.options.places import Findings, Place
from grainfit.options.tables import Key, Table, Values
from grainfit.problem import Target

if TYPE_CHECKING:
    from grainfit.photographs.drum import DrumSize
    from grainfit.photographs.kept_drum import KeptDrum

#: Key that makes a target one of videos.
VIDEO = "video"
#: Responses that videos and photographs of a drum tell, by type of test.
FILMED: Mapping[str, tuple[str, ...]] = {
    "drum": ("dynamic_angle", "surface_angle", "upper_angle", "lower_angle"),
}

_VIDEO = Key(
    VIDEO,
    OneOrMore(Text()),
    "Video of the turning drum, along its axis, or several, with * and ? as in a shell; of both "
    "ways in which it turns, the mean does not depend on how the camera is rolled. They are "
    "measured when the file is read.",
    required=True,
    example='"drum.mp4"',
)
_STILLS = Key(
    PHOTOS,
    OneOrMore(Text()),
    "Instead of a video, five pictures or more of the turning drum, some seconds apart, with * and "
    "? as in a shell; or folders with such pictures.",
    required=True,
    example='["drum_*.jpg"]',
)
_SHARED = (
    Key(
        "marker",
        Flag(),
        "Whether the marker sheet is to be seen: pictures without it are refused.",
        default="false: it is used where it is seen",
        example="true",
    ),
    Key(
        "level",
        Quantity("deg", above_zero=True, highest=10.0),
        "Standard uncertainty of how level the camera is.",
        default="by the marker sheet or by both ways of turning; otherwise 0.5 deg",
        example='"0.1 deg"',
    ),
    Key(
        "distance",
        Quantity("m", above_zero=True),
        "Of the camera before the front of the drum: takes perspective out of the dynamic angle, "
        "with drum_radius and the length.",
        example='"50 cm"',
    ),
    Key(
        "length",
        Quantity("m", above_zero=True),
        "Of the filmed drum along its axis; needs a distance.",
        default="drum_length of a test with end_caps",
        example='"20 mm"',
    ),
    *OF_ANGLE,
)


def drum_tables(otherwise: TargetTable, test: Mapping[str, Any]) -> dict[str, Table]:
    """Return the keys of a target that videos tell, and of one that stills tell.

    Parameters
    ----------
    otherwise : TargetTable
        Of a target that is given.
    test : mapping of str to object
        Keys of its test, as they are written.
    """
    return {
        key.name: Table((key, *_SHARED), measured_now(otherwise, partial(_number, key.name, test)))
        for key in (_VIDEO, _STILLS)
    }


def _number(key: str, test: Mapping[str, Any], values: Values, place: Place) -> Target | None:
    if None in values.values():
        return None
    groups = groups_of(values[key], place.at(key), videos=key == VIDEO)
    size = _size(values, test, place)
    if groups is None or size is None:
        return None
    found = _measured(groups, size, values, place)
    if found is None:
        return None
    files = {one.sha256: one for group in groups for one in group}
    said = list(_said(found, files))
    if not found.responses:
        place.at(key).fault(messages.NO_PICTURE_MEASURED, reasons=" ".join(said))
        return None
    target = target_of(Response(*found.responses[place.key]), values, place, key)
    if target is None:
        return None
    value, error = target.value, target.standard_uncertainty
    about = _shown(found)
    note_target(
        [
            Original(one.file, one.sha256, found.version, found.name, about.get(one.sha256, {}))
            for one in files.values()
        ],
        messages.DRUM_PHOTOGRAPHED(
            response=place.key.replace("_", " "),
            result=in_words(value, error, found.parts[place.key]),
        ),
        said,
        place,
        speed=found.speed,
    )
    return target


def _shown(found: KeptDrum) -> dict[str, dict[str, Any]]:
    """Return what a report shows of each video and of the stills, by the hash of the file."""
    from grainfit.photographs.kept import KeptPicture

    shown = {
        one.sha256: {**asdict(one.picture), "heap": number}
        for number, one in enumerate(found.series, 1)
        if one.picture is not None
    }
    refused = {
        digest: {**asdict(KeptPicture(found.name, digest, found.version, why)), "heap": 0}
        for digest, why in found.refused.items()
    }
    return {**shown, **refused}


def _size(values: Values, test: Mapping[str, Any], place: Place) -> DrumSize | None:
    """Return the lengths of the drum as far as perspective needs them; None after a fault."""
    from grainfit.photographs.drum import DrumSize

    if "distance" not in values:
        if "length" not in values:
            return DrumSize()
        place.at("length").fault(messages.LENGTH_WITHOUT_DISTANCE)
        return None
    # Their own faults are noted where they are.
    unheard = Place(Findings(place.findings.folder))
    radius = Quantity("m", above_zero=True).read(test.get("drum_radius"), unheard)
    length = values.get("length")
    if length is None and test.get("end_caps") is True:
        length = Quantity("m", above_zero=True).read(test.get("drum_length"), unheard)
    if radius is None or length is None:
        place.at("distance").fault(messages.DISTANCE_ALONE)
        return None
    return DrumSize(radius, values["distance"], length)


def _measured(
    groups: Sequence[Sequence[NamedFile]], size: DrumSize, values: Values, place: Place
) -> KeptDrum | None:
    """Measure once what shows a drum; None after noting what cannot be read or kept."""
    from grainfit.photographs.kept_drum import measure_drum_once

    files = [one for group in groups for one in group]
    measure = partial(
        measure_drum_once,
        [[one.path for one in group] for group in groups],
        size=size,
        level=values.get("level"),
        marker=values.get("marker", False),
    )
    return measured_once(measure, files, place, files[0].place)


def _said(found: KeptDrum, files: Mapping[str, NamedFile]) -> Iterator[str]:
    """Yield what was found on each video and on the stills, in words."""
    for one in found.series:
        frames = messages.STILLS(count=one.frames)
        if one.seconds is not None:
            frames = messages.FRAMES(count=one.frames, seconds=one.seconds)
        yield messages.DRUM_MEASURED(
            file=files[one.sha256].file,
            frames=frames,
            side="right" if one.rises_right else "left",
            fill=one.fill_level,
        )
    if found.speed is not None:
        yield messages.DRUM_SPEED(speed=turns_per_minute(found.speed[0]))
    for digest, reason in found.refused.items():
        yield messages.PICTURE_REFUSED(file=files[digest].file, reason=reason)
