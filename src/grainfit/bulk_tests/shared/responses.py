"""Responses that several bulk tests share."""

from __future__ import annotations

from collections.abc import Mapping

from grainfit.bulk_tests.recorded_trials import RecordedTrials
from grainfit.bulk_tests.response_info import CurveInfo, ResponseInfo

#: Of a bed that is poured into an upright cylinder.
BULK_DENSITY = ResponseInfo(
    "kg/m^3",
    "ρ_b",
    "bulk density: mass of the bed over its volume, voids included",
    '{ value = "1500 kg/m^3", uncertainty = "1 %" }',
    RecordedTrials(0.006, (0.048, 0.078)),
)


#: Why a heap has no shape of its own.
AT_EDGE = (
    "the heap reaches the edge of the plate: use a larger plate_radius, or, if the plate of the "
    "laboratory is rough, plate_sliding_friction and plate_rolling_friction"
)


def heap_responses(trials: Mapping[str, RecordedTrials]) -> dict[str, ResponseInfo]:
    """Return the responses of a heap on a plate.

    Parameters
    ----------
    trials : mapping of str to RecordedTrials
        By response, where they were measured.
    """
    return {
        "angle_of_repose": ResponseInfo(
            "deg",
            "α",
            "angle of repose: inclination of the heap's flanks",
            '{ value = "22 deg", uncertainty = "0.5 deg" }',
            trials.get("angle_of_repose"),
            highest=90.0,
            why="A flank is not steeper than a wall.",
            absent=AT_EDGE,
        ),
        "base_radius": ResponseInfo(
            "m",
            "r",
            "base radius: half the width of the heap, one particle diameter above the plate or at "
            "the height of its rim",
            '{ value = "130 mm", uncertainty = "2 mm" }',
            trials.get("base_radius"),
            absent=AT_EDGE,
        ),
        "heap_height": ResponseInfo(
            "m",
            "h",
            "heap height: highest point of the heap above the plate",
            '{ value = "53 mm", uncertainty = "1 mm" }',
            trials.get("heap_height"),
            absent=AT_EDGE,
        ),
    }


#: The outline of a heap on a plate.
HEAP_PROFILE = CurveInfo(
    "m",
    "z",
    "height over radius: height of the heap's outline, averaged over both sides of all silhouettes",
    "radius",
    "m",
    lowest=0.0,
    why="It is the height above the plate.",
    absent=AT_EDGE,
)
