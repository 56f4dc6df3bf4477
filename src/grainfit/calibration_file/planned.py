"""A file from before the laboratory: tests that could be measured, and how well."""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from grainfit.bulk_tests.accuracy import Accuracy
from grainfit.bulk_tests.response_info import ResponseInfo
from grainfit.calibration_file.accuracies import Accuracies, accuracy_of
from grainfit.calibration_file.build import build_solvers
from grainfit.calibration_file.content import CalibrationFile, PlannedTarget
from grainfit.calibration_file.load import load_calibration_file
from grainfit.calibration_file.targets import TargetTable
from grainfit.errors import InputError
from grainfit.options.places import Findings, Place
from grainfit.solvers.base import Solver


@dataclass(frozen=True)
class PlannedFile:
    """A calibration file whose measurements need not be made yet.

    Parameters
    ----------
    file : CalibrationFile
        The file.
    solvers : mapping of str to Solver
        By name of the test.
    """

    file: CalibrationFile
    solvers: Mapping[str, Solver]

    @property
    def workers(self) -> int:
        """Runs at a time: as the file says, or as many as there are cores for."""
        return self.file.strategy.workers or self.file.runs_at_once

    def accuracy(
        self, given: Accuracies, test: str, name: str, info: ResponseInfo
    ) -> Accuracy | None:
        """Return the accuracy of a response; None if the file leaves it out.

        It is as given, as in the file, or the usual one. A test of the file that lists responses is
        measured in these only.
        """
        listed = self._planned(test)
        if listed and name not in listed:
            return None
        in_file = listed[name].accuracy if listed else None
        is_given = f"{test}.{name}" in given or name in given
        return in_file if in_file and not is_given else accuracy_of(test, name, info.unit, given)

    def value(self, test: str, name: str, info: ResponseInfo) -> float:
        """Return the expected value of a response: that of the file, or a typical one."""
        planned = self._planned(test).get(name)
        if planned is not None and planned.value is not None:
            return planned.value
        return typical_value(name, info)

    def _planned(self, test: str) -> Mapping[str, PlannedTarget]:
        return next((t.planned for t in self.file.tests if t.name == test), {})


def load_planned_file(path: str | Path, text: str | None = None) -> PlannedFile:
    """Read a calibration file in which measured values may be missing; nothing is executed.

    Parameters
    ----------
    path : path
        The file. A target may have an ``uncertainty`` alone, or no key at all; a test without
        targets could be measured in all its responses.
    text : str, optional
        Content to read in place of that of the file.

    Raises
    ------
    InputError
        With every fault of the file, its key and its line.
    """
    file = load_calibration_file(Path(path), planned=True, text=text)
    return PlannedFile(file, build_solvers(file))


def load_tests(path: str | Path) -> PlannedFile:
    """Read the tests of a calibration file, whether or not they are measured yet.

    Raises
    ------
    InputError
        With every fault of the file, its key and its line.
    """
    try:
        file = load_calibration_file(path)
    except InputError as measured:
        try:
            return load_planned_file(path)
        except InputError as planned:
            # The other reading has faults that are none, such as missing values or a curve.
            raise min(measured, planned, key=lambda error: len(error.faults)) from None
    return PlannedFile(file, build_solvers(file))


def typical_value(name: str, info: ResponseInfo) -> float:
    """Return the value in the example of a response, in its unit."""
    example = tomllib.loads(f"target = {info.example}")["target"]
    target = TargetTable(info.possible).read(example, Place(Findings(), (name,)))
    assert target is not None, "examples are valid, see the tests of bulk tests"
    return target.value
