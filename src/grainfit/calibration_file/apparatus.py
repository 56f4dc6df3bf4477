"""The apparatus of the tests of a calibration file."""

from __future__ import annotations

from collections.abc import Iterator

from grainfit.bulk_tests import messages
from grainfit.bulk_tests.apparatus import ApparatusValue, apparatus_lines, apparatus_of
from grainfit.calibration_file.build import CalibrationSetup


def simulated_apparatus(setup: CalibrationSetup) -> dict[str, tuple[ApparatusValue, ...]]:
    """Return the apparatus of each built-in test, with free parameters in their middle.

    Parameters
    ----------
    setup : CalibrationSetup
        The calibration.
    """
    material = {**setup.file.fixed, **setup.problem.middle}
    tests = {test.name: test for test in setup.file.tests}
    found = {
        name: apparatus_of(
            test,
            tests[name].options if tests[name].given is None else tests[name].given,
            material,
            setup.solvers[name].walls,
            tests[name].instrument,
        )
        for name, test in setup.bulk_tests.items()
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
