"""The answer of a calibration as its result.json has it, which somebody may have edited."""

from __future__ import annotations

import sys
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, get_args

from grainfit.campaign.workdir import RESULT_NAME
from grainfit.errors import Fault, InputError, StoreError
from grainfit.reading import CalibrationReading
from grainfit.result import ResponseResult, Status


@dataclass(frozen=True)
class CheckedAnswer:
    """What a card takes from a result.

    Parameters
    ----------
    status : str
        How the calibration ended: that of the result, or of a later start that came to no end.
    parameters : mapping of str to float
        Values of the free parameters, SI.
    responses : mapping of str to ResponseResult
        By name of the target.
    notices : tuple of str
        What the user should know.
    """

    status: str
    parameters: Mapping[str, float]
    responses: Mapping[str, ResponseResult]
    notices: tuple[str, ...]


def read_answer(reading: CalibrationReading) -> CheckedAnswer:
    """Return the answer of a calibration.

    Raises
    ------
    InputError
        There is none yet.
    StoreError
        The result is damaged.
    """
    result = reading.result
    if not result or not result.get("parameters"):
        raise InputError(_no_answer(reading))
    try:
        return CheckedAnswer(
            _status(result["status"], reading.state),
            {p.name: _number(result["parameters"][p.name]) for p in reading.problem.parameters},
            {t.name: _response(result["responses"][t.name]) for t in reading.problem.targets},
            tuple(str(notice) for notice in result.get("notices", ())),
        )
    except (KeyError, TypeError, ValueError) as error:
        words = f"{error} is missing" if isinstance(error, KeyError) else str(error)
        raise StoreError(
            f"{str(reading.folder / RESULT_NAME)!r} is damaged: {words}. Start the calibration "
            "again: it is written anew, and no finished run is repeated."
        ) from error


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
            f"{str(reading.folder / RESULT_NAME)!r} is missing or cannot be read.",
            "Start the calibration again: it is written anew, and no finished run is repeated.",
        ),
    )
    return Fault("", f"there is no answer yet; {message}", remedy)


def _status(status: Any, state: str) -> str:
    if status not in get_args(Status):
        raise ValueError(f"{status!r} is no status of a calibration")
    # A start that came to no end leaves the result of the one before.
    return state if status == "calibrated" else str(status)


def _response(data: Any) -> ResponseResult:
    if not isinstance(data, Mapping):
        raise TypeError(f"{data!r} is no response")
    if not isinstance(data["within_tolerance"], bool):
        raise TypeError(f"{data['within_tolerance']!r} is neither true nor false")

    def perhaps(name: str) -> float | None:
        return None if data[name] is None else _number(data[name])

    return ResponseResult(
        target=_number(data["target"]),
        tolerance=_number(data["tolerance"]),
        unit=str(data["unit"]),
        predicted=_number(data["predicted"]),
        std_error=_number(data["std_error"]),
        verified_mean=perhaps("verified_mean"),
        verified_std_error=perhaps("verified_std_error"),
        verified_interval=perhaps("verified_interval"),
        deviation_percent=_number(data["deviation_percent"]),
        within_tolerance=data["within_tolerance"],
    )


def _number(value: Any) -> float:
    is_number = isinstance(value, (int, float)) and not isinstance(value, bool)
    if is_number and abs(value) <= sys.float_info.max:
        return float(value)
    raise TypeError(f"{value!r} is not a finite number")
