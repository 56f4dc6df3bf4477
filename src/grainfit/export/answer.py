"""The answer that a card is made of, or why there is none."""

from __future__ import annotations

from grainfit.campaign.workdir import RESULT_NAME
from grainfit.errors import Fault, InputError, StoreError
from grainfit.reading import CalibrationReading
from grainfit.result import Result


def read_answer(reading: CalibrationReading) -> Result:
    """Return the result of a calibration that has an answer.

    Raises
    ------
    InputError
        There is none yet.
    StoreError
        The result is damaged.
    """
    if reading.result_fault:
        raise StoreError(reading.result_fault)
    if reading.result is None or not reading.result.parameters:
        raise InputError(_no_answer(reading))
    return reading.result


def _no_answer(reading: CalibrationReading) -> Fault:
    folder = str(reading.folder)
    message, remedy = {
        "running": (
            f"the calibration in {folder!r} is running.",
            f"Wait for its end: grainfit status {folder}",
        ),
        "interrupted": (
            f"the calibration in {folder!r} was interrupted before.",
            "Start it again: it goes on where it was.",
        ),
        "failed": (
            f"the calibration in {folder!r} failed.",
            f"Mend what made it fail and start it again: grainfit status {folder}",
        ),
    }.get(
        reading.state,
        (
            f"{str(reading.folder / RESULT_NAME)!r} is missing.",
            "Start the calibration again: it is written anew, and no finished run is repeated.",
        ),
    )
    return Fault("", f"there is no answer yet; {message}", remedy)
