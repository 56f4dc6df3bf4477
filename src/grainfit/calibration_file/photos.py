"""Targets that are measured on photographs when the calibration file is read."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from fnmatch import fnmatch
from pathlib import Path
from shutil import copy2
from typing import TYPE_CHECKING, Any, get_args

from grainfit.bulk_tests.accuracy import Accuracy
from grainfit.calibration_file import messages
from grainfit.calibration_file.content import PlannedTarget
from grainfit.calibration_file.curves import CurveTable
from grainfit.calibration_file.photographed import PhotographedTarget
from grainfit.calibration_file.targets import Deviation, PlannedTargetTable, TargetTable, absolute
from grainfit.errors import InputError, NotMeasurableError
from grainfit.files import is_file, is_folder, write_atomically
from grainfit.options.kinds import Choice, Flag, OneOrMore, Quantity, Text
from grainfit.options.places import Place, dotted, show
from grainfit.options.tables import Key, Table, Values
from grainfit.problem import CurveTarget, Target
from grainfit.problem.target import Statistic

if TYPE_CHECKING:
    from grainfit.photographs.kept import KeptPicture

#: Key that makes a target one of photographs.
PHOTOS = "photos"
#: Responses that photographs tell, by type of test.
PHOTOGRAPHED: Mapping[str, tuple[str, ...]] = {
    "heap": ("angle_of_repose", "profile"),
    "funnel": ("angle_of_repose", "profile"),
}
#: List of the pictures with which a calibration was begun, beside what was measured on them.
LIST_NAME = "pictures.json"
#: Pictures near the calibration file that are searched for one that was moved.
_MOST_SEARCHED = 300


def photo_table(otherwise: TargetTable | CurveTable) -> Table:
    """Return the keys of a target that photographs tell, of the same response as another kind."""
    if isinstance(otherwise, CurveTable):
        return Table(_photo_keys(otherwise.unit), _curve)
    of_number = (*_photo_keys("deg"), *_OF_NUMBER)
    planned = isinstance(otherwise, PlannedTargetTable)
    return Table(of_number, _planned if planned else _number)


_OF_NUMBER = (
    Key("weight", Quantity("", above_zero=True), "As of a target that is given by its value."),
    Key("statistic", Choice(get_args(Statistic)), "As of a target that is given by its value."),
)


def _photo_keys(unit: str | None) -> tuple[Key, ...]:
    length = Quantity("m", above_zero=True)
    return (
        Key(
            PHOTOS,
            OneOrMore(Text()),
            "Pictures of heaps, each of a heap of its own, with * and ? as in a shell; or folders, "
            "each with pictures of one heap. They are measured when the file is read.",
            required=True,
            example='["heap_*.jpg"]',
        ),
        Key(
            "marker",
            Flag(),
            "Whether the marker sheet is to be seen: pictures without it are refused.",
            default="false: it is used where it is seen",
            example="true",
        ),
        Key("plate", length, "Diameter of the round plate below the heap.", example='"200 mm"'),
        Key(
            "diameter",
            length,
            "Of the particles in the pictures; needs a known length.",
            default="by the roughness of the outline",
            example='"3 mm"',
        ),
        Key(
            "elevation",
            Quantity("deg", lowest=0.0, highest=60.0),
            "Of the camera above the horizontal.",
            default="by sheet, plate or foot of the heap",
            example='"5 deg"',
        ),
        Key(
            "tolerance",
            Deviation(unit),
            "Largest accepted deviation of the calibrated response: what is good enough.",
            default="as of a target that is given by its value, or by a curve",
            example='"1 deg"' if unit == "deg" else '"5 %"',
        ),
    )


def _number(values: Values, place: Place) -> Target | None:
    from grainfit.photographs.photo import mean_of_heaps

    measured = _measured(values, place)
    if measured is None:
        return None
    response, parts = mean_of_heaps(measured.heaps)
    # As 'grainfit photo' prints them.
    value, error = round(response.value, 2), round(response.standard_error, 2)
    sources = ", ".join(f"{name} {part:.2f}" for name, part in parts.items())
    result = f"{value:.2f} ± {error:.2f} deg ({sources})"
    others: dict[str, Any] = {key: values[key] for key in ("weight", "statistic") if key in values}
    if "tolerance" in values:
        others["tolerance"] = absolute(values["tolerance"], value)
    try:
        target = Target(place.key, value, error, unit="deg", **others)
    except InputError as error_of_value:
        place.note(error_of_value, values, place.at(PHOTOS))
        return None
    place.findings.photographs.append(replace(measured, result=result))
    return target


def _planned(values: Values, place: Place) -> PlannedTarget | None:
    target = _number(values, place)
    return (
        None
        if target is None
        else PlannedTarget(target.value, Accuracy(target.standard_uncertainty))
    )


def _curve(values: Values, place: Place) -> CurveTarget | None:
    from grainfit.photographs.outlines import outlines_of

    measured = _measured(values, place)
    if measured is None:
        return None
    given = values.get("tolerance")
    tolerance = given and (f"{100 * given[0]:.15g} %" if given[1] else given[0])
    try:
        found = outlines_of(measured.heaps)
        curve = CurveTarget.of_measurements(
            place.key,
            [(found.distances.round(7), heights.round(7)) for heights in found.heights],
            systematic=found.systematic.round(7).tolist(),
            tolerance=tolerance,
            unit="m",
            coordinate_unit="m",
            coordinate="radius",
        )
    except (NotMeasurableError, InputError) as error:
        place.at(PHOTOS).fault(str(error))
        return None
    result = messages.PHOTOGRAPHED_CURVE(
        count=len(curve.values),
        reach=1000 * curve.coordinates[-1],
        error=1000 * float(curve.standard_uncertainties.mean()),
    )
    place.findings.photographs.append(replace(measured, result=result))
    return curve


def _measured(values: Values, place: Place) -> PhotographedTarget | None:
    """Measure the pictures of a target; None after noting every fault."""
    groups = None if None in values.values() else _groups(values[PHOTOS], place)
    if groups is None:
        return None
    from grainfit.photographs.kept import FOLDER, KnownOfPicture, measure_once

    folder = place.findings.work_folder() / FOLDER
    begun = pictures_begun_with(folder).get(dotted(place.path), {})
    known = KnownOfPicture(
        values.get("elevation"),
        values.get("plate"),
        values.get("diameter"),
        values.get("marker", False),
    )
    if known.diameter is not None and known.plate_diameter is None and not known.marker:
        place.at("diameter").refuse(messages.NO_KNOWN_LENGTH.fault(""))
        return None
    heaps: list[tuple[KeptPicture, ...]] = []
    refused: list[KeptPicture] = []
    seen: dict[str, str] = {}
    for group in groups:
        heap: list[KeptPicture] = []
        for file, path, at in group:
            is_of_calibration = begun.get(file) == _hash(path)
            try:
                one = measure_once(path, known, folder, keep_version=is_of_calibration)
            except InputError as error:
                at.refuse(error.faults[0])
                return None
            except OSError as error:
                at.refuse(messages.NOT_KEPT.fault("", folder=folder, reason=error.strerror))
                return None
            if one.sha256 in seen:
                at.refuse(messages.SAME_PICTURE.fault("", file=file, other=seen[one.sha256]))
                return None
            seen[one.sha256] = file
            (refused if one.refused else heap).append(replace(one, file=file))
        if heap:
            heaps.append(tuple(heap))
    if not heaps:
        reasons = " ".join(f"{one.file}: {one.refused}" for one in refused)
        place.at(PHOTOS).refuse(messages.NO_PICTURE_MEASURED.fault("", reasons=reasons))
        return None
    test = next((part for part in place.path if isinstance(part, int)), 0)
    found = PhotographedTarget(
        dotted(place.path), test, place.key, tuple(heaps), tuple(refused), "", folder
    )
    return replace(found, changes=tuple(_changes(found, begun, place)))


_Pictures = list[tuple[str, Path, Place]]


def _groups(given: Sequence[str], place: Place) -> list[_Pictures] | None:
    """Return the pictures of each heap; None after noting what is not there."""
    from grainfit.photographs.pictures import is_picture

    folder = place.findings.folder
    groups: list[_Pictures] = []
    faults = len(place.findings.faults)
    for number, text in enumerate(given):
        at = place.at(PHOTOS, number)
        found = []
        for path in _matching(folder / text):
            inside = sorted(path.iterdir()) if is_folder(path) else [path]
            pictures = [one for one in inside if is_picture(one) and is_file(one)]
            found += [[(_shown(one, folder), one, at) for one in pictures]] if pictures else []
        if not found:
            where = _where_now(text, place)
            at.refuse(messages.NO_SUCH_PICTURE.fault("", given=show(text), where=where))
        groups += found
    return None if len(place.findings.faults) > faults else groups


def _matching(path: Path) -> list[Path]:
    """Return the files and folders whose name a path with * and ? in its last part stands for."""
    if path.exists() or not is_folder(path.parent):
        return [path]
    return sorted(one for one in path.parent.iterdir() if fnmatch(one.name, path.name))


def _shown(path: Path, folder: Path) -> str:
    with suppress(ValueError):
        return str(path.relative_to(folder))
    return str(path)


def _where_now(file: str, place: Place) -> str:
    """Return where a picture of the calibration is now, as a sentence, or what to do."""
    from grainfit.photographs.kept import FOLDER

    begun = pictures_begun_with(place.findings.work_folder() / FOLDER)
    digest = begun.get(dotted(place.path), {}).get(file)
    moved = digest and _find(digest, place.findings.folder)
    if moved:
        return messages.MOVED_TO(path=moved)
    return messages.NAME_PICTURES(folder=place.findings.folder)


def _find(digest: str, folder: Path) -> str:
    """Return the picture with a hash beside the calibration file, or in a folder there."""
    from grainfit.photographs.pictures import is_picture

    near = [*folder.glob("*"), *folder.glob("*/*")][:_MOST_SEARCHED]
    found = (one for one in near if is_picture(one) and _hash(one) == digest)
    return next((_shown(one, folder) for one in found), "")


def _hash(path: Path) -> str:
    try:
        with path.open("rb") as file:
            return hashlib.file_digest(file, "sha256").hexdigest()
    except OSError:
        return ""


def _changes(found: PhotographedTarget, begun: Mapping[str, str], place: Place) -> Iterator[str]:
    """Yield how pictures differ from those with which the calibration was begun."""
    from grainfit.photographs.kept import version_of_code

    now = {one.file: one.sha256 for one in found.pictures}
    for file, digest in begun.items():
        if file not in now and digest not in now.values():
            where = _find(digest, place.findings.folder)
            yield (
                messages.PICTURE_MOVED(file=file, path=where)
                if where
                else messages.PICTURE_GONE(file=file)
            )
        elif file not in now:
            path = next(name for name, one in now.items() if one == digest)
            yield messages.PICTURE_MOVED(file=file, path=path)
        elif now[file] != digest:
            yield messages.PICTURE_CHANGED(file=file)
    if begun:
        new = [file for file, one in now.items() if file not in begun and one not in begun.values()]
        yield from (messages.PICTURE_NEW(file=file) for file in new)
    with suppress(InputError):
        if any(one.version != version_of_code() for one in found.pictures):
            yield messages.EARLIER_CODE(folder=found.folder)


def pictures_begun_with(folder: Path) -> dict[str, dict[str, str]]:
    """Return the hashes of the pictures with which a calibration was begun, by key and file."""
    try:
        targets = json.loads((folder / LIST_NAME).read_text(encoding="utf-8"))["targets"]
        return {
            str(one["key"]): {str(p["file"]): str(p["sha256"]) for p in one["pictures"]}
            for one in targets
        }
    except (OSError, ValueError, KeyError, TypeError):
        return {}


def keep_pictures(targets: Sequence[tuple[str, PhotographedTarget]], folder: Path) -> None:
    """Write the list of the pictures with which a calibration begins into its work folder.

    Parameters
    ----------
    targets : sequence of (str, PhotographedTarget)
        With the names of the responses in the problem.
    folder : Path
        The work folder.
    """
    from grainfit.photographs.kept import FOLDER

    place = folder / FOLDER
    place.mkdir(parents=True, exist_ok=True)
    listed = []
    for response, target in targets:
        pictures = []
        for number, heap in enumerate((*target.heaps, target.refused), 1):
            for one in heap:
                if target.folder.resolve() != place.resolve():
                    for ending in (".json", ".jpg", "_measured.png", "_refused.png"):
                        with suppress(OSError):
                            copy2(target.folder / f"{one.name}{ending}", place)
                pictures.append({**one.to_json(), "heap": number})
        about = {"key": target.key, "response": response, "result": target.result}
        listed.append({**about, "pictures": pictures})
    write_atomically(place / LIST_NAME, json.dumps({"targets": listed}))


def hashes_of(targets: Sequence[tuple[str, PhotographedTarget]]) -> dict[str, dict[str, str]]:
    """Return the hashes of all pictures by response and file."""
    return {name: {one.file: one.sha256 for one in found.pictures} for name, found in targets}
