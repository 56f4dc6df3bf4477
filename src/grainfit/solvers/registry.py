"""Registry of solvers: DEM programs, custom models, and their types of test."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from functools import cache

from grainfit.bulk_tests.registry import BUILT_IN, OWN_SCENE, bulk_tests
from grainfit.contact_models.registry import CONTACT_MODELS, needed_models
from grainfit.registration import gaps, require_complete, require_unique
from grainfit.solvers.dem.lammps.program import Lammps
from grainfit.solvers.dem.liggghts.program import Liggghts
from grainfit.solvers.dem.program import DeckSolver
from grainfit.solvers.dem.types_of_test import simulated
from grainfit.solvers.dem.yade.program import Yade
from grainfit.solvers.file_entry import TestType
from grainfit.solvers.own_model.types_of_test import COMMAND, PYTHON, TABLE

#: A new DEM program is a class here.
_PROGRAMS: tuple[type[DeckSolver], ...] = (Lammps, Liggghts, Yade)


def _missing(program: type[DeckSolver]) -> Iterator[str]:
    """Iterate over what a program lacks to be used."""
    yield from gaps(program, ("name", "title", "usual_name", "install", "version_pattern", "deck"))
    name = getattr(program, "name", "")
    for kind, models in needed_models().items():
        if not any(name in model.solvers for model in models):
            yield f"no contact model of the kind {kind} has keywords for it"


for _program in _PROGRAMS:
    require_complete("solver", _program.__name__, _missing(_program))
require_unique("solver", (program.name for program in _PROGRAMS))

#: Programs that run the decks of bulk tests, by name.
DEM_PROGRAMS: Mapping[str, type[DeckSolver]] = {program.name: program for program in _PROGRAMS}
for _model in CONTACT_MODELS:
    _strangers = [name for name in _model.solvers if name not in DEM_PROGRAMS]
    require_complete("contact model", _model.name, (f"no solver is {n}" for n in _strangers))

#: Types of test that run a custom model.
OWN_MODELS: tuple[TestType, ...] = (COMMAND, PYTHON, TABLE)


@cache
def types_of_test(*, built_in: bool = False) -> Mapping[str, TestType]:
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
