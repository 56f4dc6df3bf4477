"""Rebuild the solvers of a saved calibration from the definitions of its runs."""

from __future__ import annotations

from grainfit.bulk_tests.abilities import is_of_user
from grainfit.bulk_tests.registry import recreate_test
from grainfit.campaign.store.records import RunRecord
from grainfit.errors import InputError
from grainfit.solvers.base import Solver
from grainfit.solvers.parameters_for import of_material
from grainfit.solvers.registry import DEM_PROGRAMS
from grainfit.work_folder import messages
from grainfit.work_folder.saved_calibration import SavedCalibration


def solvers_of(saved: SavedCalibration, remedy: str) -> dict[str, Solver]:
    """Return the solvers of the tests of a calibration, by name of the test.

    Parameters
    ----------
    saved : SavedCalibration
        The calibration.
    remedy : str
        What to do about a model or a scene of the user.

    Raises
    ------
    InputError
        A test is a scene of the user or was simulated by his model, which its runs do not hold.
    """
    first: dict[str, RunRecord] = {}
    for record in saved.records.values():
        first.setdefault(record.test, record)
    free = {parameter.name for parameter in saved.problem.parameters}
    solvers = {test: solver_of_run(record, free, remedy) for test, record in first.items()}
    InputError.raise_for(
        messages.SCENE_NOT_IN_RUNS.fault(f"test {test}", remedy=remedy)
        for test, solver in solvers.items()
        if is_of_user(solver.bulk_test)
    )
    return solvers


def solver_of_run(record: RunRecord, free: set[str], remedy: str = "") -> Solver:
    """Rebuild the solver of a run from the definition of the run.

    Parameters
    ----------
    record : RunRecord
        The run.
    free : set of str
        Names of the free parameters; the others keep the values of the run.
    remedy : str
        What to do about a model of the user.

    Raises
    ------
    InputError
        The run was simulated by a model of the user.
    """
    definition = record.definition
    test = recreate_test(definition)
    program = DEM_PROGRAMS.get(str(definition.model.get("solver")))
    if test is None or program is None:
        fault = messages.OWN_MODEL_NOT_IN_RUNS.fault(f"test {record.test}", remedy=remedy)
        raise InputError(fault)
    fixed = {name: value for name, value in definition.parameters.items() if name not in free}
    model = definition.model
    solver = program(
        test,
        fixed,
        int(model.get("ranks", 1)),
        contact_models=model.get("contact_models", ()),
        walls=model.get("walls"),
    )
    return of_material(solver, free)
