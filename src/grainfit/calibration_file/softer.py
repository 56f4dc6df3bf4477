"""Cheaper relatives of the tests of a calibration file: the same tests with softer particles."""

from __future__ import annotations

from grainfit.bulk_tests.sensitivities import MODULUS
from grainfit.bulk_tests.time_steps import STEPS_BY_MODULUS
from grainfit.calibration_file.content import CalibrationFile
from grainfit.errors import Fault, InputError
from grainfit.formatting import number
from grainfit.problem import Relative
from grainfit.solvers.registry import types_of_test

_KEY = "strategy.softer"


def softer_relatives(file: CalibrationFile) -> list[Relative]:
    """Return the relatives of the simulated tests; none unless the file asks for them.

    The number of time steps, and so the computing time of a run, follows Young's modulus by the
    power `STEPS_BY_MODULUS`.

    Raises
    ------
    InputError
        Young's modulus is free or not higher, or no test is simulated.
    """
    softer, stiff = file.strategy.softer, file.fixed.get(MODULUS)
    if softer is None:
        return []
    tests = [test.name for test in file.tests if types_of_test()[test.type].bulk_test is not None]
    if not tests:
        raise InputError(Fault(_KEY, "needs a bulk test.", "An own model has no softer particles."))
    if stiff is None:
        fixed = f"needs a fixed {MODULUS}."
        raise InputError(Fault(_KEY, fixed, "A free one is part of the search: leave this out."))
    if softer >= stiff:
        modulus = f"is not below {MODULUS}, {number(stiff / 1e6, 3)} MPa."
        raise InputError(Fault(_KEY, modulus, "Give about a twentieth of it, or leave it out."))
    return [Relative(test, (softer / stiff) ** STEPS_BY_MODULUS) for test in tests]


def with_softer_particles(file: CalibrationFile) -> dict[str, float]:
    """Return the fixed parameters of the file with the softer modulus."""
    assert file.strategy.softer is not None, "only a file that asks for relatives has them"
    return {**file.fixed, MODULUS: file.strategy.softer}
