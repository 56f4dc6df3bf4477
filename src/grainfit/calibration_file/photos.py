"""Targets that are measured on photographs of heaps when the calibration file is read."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass, replace
from typing import TYPE_CHECKING, Any, get_args

from grainfit.bulk_tests.accuracy import Accuracy
from grainfit.calibration_file import messages
from grainfit.calibration_file.content import PlannedTarget
from grainfit.calibration_file.curves import CurveTable
from grainfit.calibration_file.originals import begun_with, groups_of, note_target
from grainfit.calibration_file.photographed import PHOTOS, Original, in_words
from grainfit.calibration_file.targets import Deviation, PlannedTargetTable, TargetTable, absolute
from grainfit.errors import Fault, InputError, NotMeasurableError
from grainfit.evaluation import Response
from grainfit.options.kinds import Choice, Flag, OneOrMore, Quantity, Text
from grainfit.options.places import Place
from grainfit.options.tables import Key, Table, Values
from grainfit.problem import CurveTarget, Target
from grainfit.problem.target import Statistic

if TYPE_CHECKING:
    from grainfit.photographs.kept import KeptPicture

#: Responses that photographs tell, by type of test.
PHOTOGRAPHED: Mapping[str, tuple[str, ...]] = {
    "heap": ("angle_of_repose", "profile"),
    "funnel": ("angle_of_repose", "profile"),
}


def photo_table(otherwise: TargetTable | CurveTable) -> Table:
    """Return the keys of a target that photographs tell, of the same response as another kind."""
    if isinstance(otherwise, CurveTable):
        return Table(_photo_keys(otherwise.unit), _curve)
    return Table((*_photo_keys("deg"), *OF_NUMBER), measured_now(otherwise, _number))


#: Further keys of a target that is a number.
OF_NUMBER = (
    Key("weight", Quantity("", above_zero=True), "As of a target that is given by its value."),
    Key("statistic", Choice(get_args(Statistic)), "As of a target that is given by its value."),
)


#: Further keys of a target that is an angle.
OF_ANGLE = (
    Key(
        "tolerance",
        Deviation("deg"),
        "Largest accepted deviation of the calibrated response: what is good enough.",
        default="as of a target that is given by its value",
        example='"1 deg"',
    ),
    *OF_NUMBER,
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
    target = target_of(response, values, place, PHOTOS)
    if target is not None:
        _note(measured, in_words(target.value, target.standard_uncertainty, parts), place)
    return target


def target_of(measured: Response, values: Values, place: Place, key: str) -> Target | None:
    """Return the target of an angle that was measured, degrees; None after noting a fault."""
    # As 'grainfit photo' prints them.
    value, error = round(measured.value, 2), round(measured.standard_error, 2)
    others: dict[str, Any] = {key: values[key] for key in ("weight", "statistic") if key in values}
    if "tolerance" in values:
        others["tolerance"] = absolute(values["tolerance"], value)
    try:
        return Target(place.key, value, error, unit="deg", **others)
    except InputError as error_of_value:
        place.note(error_of_value, values, place.at(key))
        return None


def measured_now(
    otherwise: TargetTable, read: Callable[[Values, Place], Target | None]
) -> Callable[[Values, Place], Target | PlannedTarget | None]:
    """Return the reader of a target that is measured now, as that of another table is read."""
    if not isinstance(otherwise, PlannedTargetTable):
        return read

    def planned(values: Values, place: Place) -> PlannedTarget | None:
        found = read(values, place)
        if found is None:
            return None
        return PlannedTarget(found.value, Accuracy(found.standard_uncertainty))

    return planned


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
        place.at(PHOTOS).refuse(Fault("", str(error)))
        return None
    result = messages.PHOTOGRAPHED_CURVE(
        count=len(curve.values),
        reach=1000 * curve.coordinates[-1],
        error=1000 * float(curve.standard_uncertainties.mean()),
    )
    _note(measured, result, place)
    return curve


@dataclass(frozen=True)
class _Heaps:
    """Measured pictures of each heap, and those that were refused."""

    heaps: tuple[tuple[KeptPicture, ...], ...]
    refused: tuple[KeptPicture, ...]


def _note(measured: _Heaps, result: str, place: Place) -> None:
    """Keep with the findings what was measured."""
    groups = enumerate((*measured.heaps, measured.refused), 1)
    originals = [
        Original(one.file, one.sha256, one.version, one.name, {**asdict(one), "heap": number})
        for number, group in groups
        for one in group
    ]
    heaps = enumerate(measured.heaps, 1)
    said = [
        messages.PICTURE_MEASURED(
            file=one.file,
            heap=number,
            angle=one.angle,
            error=one.uncertainty,
            flanks=" and ".join(f"{angle:.1f}" for angle in one.flanks),
            elevation=one.elevation,
            elevation_error=one.elevation_error,
            seen_by=one.seen_by,
        )
        for number, heap in heaps
        for one in heap
    ]
    said += [messages.PICTURE_REFUSED(file=f.file, reason=f.refused) for f in measured.refused]
    result = messages.PHOTOGRAPHS(
        response=place.key,
        result=result,
        count=len(originals) - len(measured.refused),
        heaps=len(measured.heaps),
    )
    note_target(originals, result, said, place)


def _measured(values: Values, place: Place) -> _Heaps | None:
    """Measure the pictures of a target; None after noting every fault."""
    from grainfit.photographs.kept import FOLDER, KnownOfPicture, measure_once

    groups = None if None in values.values() else groups_of(values[PHOTOS], place.at(PHOTOS))
    if groups is None:
        return None
    folder = place.findings.work_folder() / FOLDER
    begun = begun_with(place)
    known = KnownOfPicture(
        values.get("elevation"),
        values.get("plate"),
        values.get("diameter"),
        values.get("marker", False),
    )
    if known.diameter is not None and known.plate_diameter is None and not known.marker:
        place.at("diameter").fault(messages.NO_KNOWN_LENGTH)
        return None
    heaps: list[tuple[KeptPicture, ...]] = []
    refused: list[KeptPicture] = []
    for group in groups:
        heap: list[KeptPicture] = []
        for one in group:
            is_of_calibration = begun.get(one.file) == one.sha256
            try:
                found = measure_once(one.path, known, folder, keep_version=is_of_calibration)
            except InputError as error:
                one.place.refuse(error.faults[0])
                return None
            except OSError as error:
                not_kept = messages.NOT_KEPT.fault("", folder=folder, reason=error.strerror)
                one.place.refuse(not_kept)
                return None
            (refused if found.refused else heap).append(replace(found, file=one.file))
        if heap:
            heaps.append(tuple(heap))
    if not heaps:
        reasons = " ".join(f"{one.file}: {one.refused}" for one in refused)
        place.at(PHOTOS).fault(messages.NO_PICTURE_MEASURED, reasons=reasons)
        return None
    return _Heaps(tuple(heaps), tuple(refused))
