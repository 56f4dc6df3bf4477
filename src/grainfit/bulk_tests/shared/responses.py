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


def heap_responses(absent: str, trials: Mapping[str, RecordedTrials]) -> dict[str, ResponseInfo]:
    """Return the responses of a heap on a plate.

    Parameters
    ----------
    absent : str
        Why a valid run may be without them.
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
            absent=absent,
        ),
        "base_radius": ResponseInfo(
            "m",
            "r",
            "base radius: half the width of the heap, one particle diameter above the plate or at "
            "the height of its rim",
            '{ value = "130 mm", uncertainty = "2 mm" }',
            trials.get("base_radius"),
            absent=absent,
        ),
        "heap_height": ResponseInfo(
            "m",
            "h",
            "heap height: highest point of the heap above the plate",
            '{ value = "53 mm", uncertainty = "1 mm" }',
            trials.get("heap_height"),
            absent=absent,
        ),
    }


def heap_profile(absent: str) -> CurveInfo:
    """Return the outline of a heap on a plate as a curve.

    Parameters
    ----------
    absent : str
        Why a valid run may be without it.
    """
    return CurveInfo(
        "m",
        "z",
        "height over radius: height of the heap's outline, averaged over both sides of all "
        "silhouettes",
        "radius",
        "m",
        absent=absent,
    )
