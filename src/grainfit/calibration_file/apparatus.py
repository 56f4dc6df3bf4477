"""The apparatus of the tests of a calibration file."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from grainfit.bulk_tests import messages
from grainfit.bulk_tests.apparatus import ApparatusValue, apparatus_lines, apparatus_of
from grainfit.calibration_file.build import CalibrationSetup
from grainfit.calibration_file.content import CalibrationFile
from grainfit.solvers.base import Solver


def simulated_apparatus(setup: CalibrationSetup) -> dict[str, tuple[ApparatusValue, ...]]:
    """Return the apparatus of each built-in test, with free parameters in their middle."""
    material = {**setup.file.fixed, **setup.problem.middle}
    return apparatus_of_tests(setup.file, setup.solvers, material)


def apparatus_of_tests(
    file: CalibrationFile, solvers: Mapping[str, Solver], material: Mapping[str, float]
) -> dict[str, tuple[ApparatusValue, ...]]:
    """Return the apparatus of each built-in test of a file, by name of the test.

    Parameters
    ----------
    file : CalibrationFile
        The calibration file.
    solvers : mapping of str to Solver
        Those of its tests, by name.
    material : mapping of str to float
        Material parameters by dotted name: those that are known.
    """
    tests = {test.name: test for test in file.tests}
    found = {
        name: apparatus_of(
            solver.bulk_test,
            tests[name].options if tests[name].given is None else tests[name].given,
            material,
            solver.walls,
            tests[name].instrument,
        )
        for name, solver in solvers.items()
        if solver.bulk_test is not None
    }
    return {name: values for name, values in found.items() if values}


def opening_lines(setup: CalibrationSetup) -> Iterator[str]:
    """Yield the apparatus before the first run, and that its geometry is not described."""
    for name, values in simulated_apparatus(setup).items():
        given = [value for value in values if value.origin == "given"]
        assumed = [value for value in values if value.origin == "assumed"]
        yield from apparatus_lines(name, [value for value in values if value.origin != "assumed"])
        if any(value.origin == "instrument" for value in values) or any(
            "friction" not in value.name for value in given
        ):
            yield from apparatus_lines(name, assumed)
        else:
            message = messages.REST_NOT_DESCRIBED if given else messages.NEVER_DESCRIBED
            yield message(test=name, values=", ".join(map(str, assumed)))
