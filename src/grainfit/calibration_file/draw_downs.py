"""Targets of a draw-down that are measured on photographs when the file is read."""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial
from typing import Any

from grainfit.calibration_file import messages
from grainfit.calibration_file.photographed import PHOTOS, in_words
from grainfit.calibration_file.photographed_repeats import measured_repeats, note_repeats
from grainfit.calibration_file.photos import OF_ANGLE, measured_now, target_of
from grainfit.calibration_file.targets import TargetTable
from grainfit.evaluation import Response
from grainfit.options.kinds import OneOrMore, Quantity, Text
from grainfit.options.places import Findings, Place
from grainfit.options.tables import Key, Table, Values
from grainfit.problem import Target

#: Responses that photographs of draw-downs tell, by type of test.
DRAWN_DOWN: Mapping[str, tuple[str, ...]] = {"draw_down": ("angle_of_repose", "shear_angle")}

_LENGTH = Quantity("m", above_zero=True)
_DRAW_DOWN_KEYS = (
    Key(
        PHOTOS,
        OneOrMore(Text()),
        "Pictures of draw-downs from the front, each of a draw-down of its own, with * and ? as in "
        "a shell. They are measured when the file is read.",
        required=True,
        example='["boxes_*.jpg"]',
    ),
    Key(
        "diameter",
        _LENGTH,
        "Of the particles in the pictures: says where flanks end.",
        default="by the roughness of the outline",
        example='"3 mm"',
    ),
    Key(
        "box",
        _LENGTH,
        "Inner width of the box in the pictures; needs a diameter.",
        default="width of the test",
        example='"72 mm"',
    ),
    *OF_ANGLE,
)


def draw_down_table(otherwise: TargetTable, test: Mapping[str, Any]) -> Table:
    """Return the keys of a target that photographs of draw-downs tell.

    Parameters
    ----------
    otherwise : TargetTable
        Of a target that is given.
    test : mapping of str to object
        Keys of its test, as they are written.
    """
    return Table(_DRAW_DOWN_KEYS, measured_now(otherwise, partial(_number, test)))


def _number(test: Mapping[str, Any], values: Values, place: Place) -> Target | None:
    from grainfit.photographs.kept_repeats import draw_downs_once

    diameter, width = values.get("diameter"), values.get("box")
    if width is not None and diameter is None:
        place.at("box").fault(messages.BOX_WITHOUT_DIAMETER)
        return None
    if diameter is not None and width is None:
        # Its own faults are noted where it is.
        width = _LENGTH.read(test.get("width"), Place(Findings(place.findings.folder)))
        if width is None:
            place.at("diameter").fault(messages.DIAMETER_WITHOUT_BOX)
            return None
    diameters = width / diameter if diameter is not None else None
    measure = partial(draw_downs_once, diameters=diameters)
    found = measured_repeats(values, place, measure, place.key)
    if found is None:
        return None
    kept, files = found
    target = target_of(Response(*kept.angles[place.key]), values, place, PHOTOS)
    if target is not None:
        parts = kept.parts[place.key]
        result = in_words(target.value, target.standard_uncertainty, parts)
        note_repeats(kept, files, place.key, result, place)
    return target
