"""Registry of solvers: DEM programs, custom models, and their types of test."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache

from grainfit.bulk_tests.registry import BUILT_IN, OWN_SCENE, bulk_tests
from grainfit.solvers.dem.lammps.program import Lammps
from grainfit.solvers.dem.liggghts.program import Liggghts
from grainfit.solvers.dem.program import DeckSolver
from grainfit.solvers.dem.types_of_test import simulated
from grainfit.solvers.own_model.types_of_test import COMMAND, PYTHON, TABLE
from grainfit.solvers.type_of_test import TypeOfTest

#: Programs that run the decks of bulk tests, by name.
DEM_PROGRAMS: Mapping[str, type[DeckSolver]] = {
    program.name: program for program in (Lammps, Liggghts)
}
#: Types of test that run a custom model.
OWN_MODELS: tuple[TypeOfTest, ...] = (COMMAND, PYTHON, TABLE)


@cache
def types_of_test(*, built_in: bool = False) -> Mapping[str, TypeOfTest]:
    """Return the types of test of a calibration file by name.

    Parameters
    ----------
    built_in : bool
        Leave out the bulk tests of other packages.

    Raises
    ------
    InputError
        A bulk test of another package cannot be loaded.
    """
    tests = (*(BUILT_IN if built_in else bulk_tests()).values(), OWN_SCENE)
    types = (*(simulated(test, DEM_PROGRAMS) for test in tests), *OWN_MODELS)
    return {one.name: one for one in types}
