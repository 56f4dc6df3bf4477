"""Accuracies of measurements as people write them."""

from __future__ import annotations

from collections.abc import Mapping

from grainfit.bulk_tests.accuracy import Accuracy, usual_accuracy
from grainfit.bulk_tests.registry import bulk_tests
from grainfit.calibration_file import messages
from grainfit.calibration_file.targets import Deviation
from grainfit.errors import InputError
from grainfit.options.kinds import suggest
from grainfit.options.places import Findings, Place

#: Accuracies by the name of a response, or by test and response: ``draw_down.mass_flow``.
Accuracies = Mapping[str, Accuracy]


def read_accuracies(given: Mapping[str, str | float]) -> Accuracies:
    """Read accuracies that replace the usual ones.

    Parameters
    ----------
    given : mapping of str to str or float
        By the name of a response, or by test and response: ``{"mass_flow": "3 %"}``.

    Raises
    ------
    InputError
        No bulk test has such a response, or a quantity cannot be read.

    Examples
    --------
    >>> read_accuracies({"heap.angle_of_repose": "0.5 deg"})
    {'heap.angle_of_repose': Accuracy(value=0.5, is_share=False)}
    """
    findings = Findings()
    units = _units()
    found = {}
    for name, text in given.items():
        place = Place(findings, ("accuracy", *name.split(".")))
        if name not in units:
            place.fault(messages.NO_RESPONSE_OF_TESTS, remedy=suggest(name, units, "There are"))
        elif (read := Deviation(units[name]).read(text, place)) is not None:
            found[name] = Accuracy(*read)
    InputError.raise_for(findings.faults)
    return found


def read_settings(settings: list[str]) -> dict[str, str]:
    """Split texts ``NAME=VALUE``.

    Raises
    ------
    InputError
        A text has another form.
    """
    pairs = [setting.partition("=") for setting in settings]
    wrong = [name for name, sign, value in pairs if not (sign and value.strip())]
    if wrong:
        fault = messages.NO_ACCURACY.fault("accuracy", given=wrong[0])
        raise InputError(fault)
    return {name.strip(): value.strip() for name, _, value in pairs}


def accuracy_of(test: str, response: str, unit: str, given: Accuracies) -> Accuracy:
    """Return the accuracy of a response: as it was given, or else the usual one.

    Parameters
    ----------
    test, response : str
        Names of the test and of its response.
    unit : str
        Unit of the response.
    given : mapping of str to Accuracy
        See `read_accuracies`.
    """
    found = given.get(f"{test}.{response}") or given.get(response)
    return found or usual_accuracy(response, unit)


def _units() -> dict[str, str]:
    units: dict[str, str] = {}
    for name, test in bulk_tests().items():
        for response, info in test.responses.items():
            units[f"{name}.{response}"] = units[response] = info.unit
    return units
