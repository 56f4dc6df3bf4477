"""Solvers: DEM programs and custom models, all with the interface `grainfit.solvers.base.Solver`.

Classes such as ``grainfit.solvers.Lammps`` are imported when they are first used.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from grainfit.solvers.base import Solver, Workspace
    from grainfit.solvers.dem.lammps.program import Lammps
    from grainfit.solvers.dem.liggghts.program import Liggghts
    from grainfit.solvers.dem.yade.program import Yade
    from grainfit.solvers.own_model.command import Command
    from grainfit.solvers.own_model.python_callable import PythonCallable
    from grainfit.solvers.own_model.recorded_table import RecordedTable

__all__ = [
    "Command",
    "Lammps",
    "Liggghts",
    "PythonCallable",
    "RecordedTable",
    "Solver",
    "Workspace",
    "Yade",
]

_HOMES = {
    "Lammps": "dem.lammps.program",
    "Liggghts": "dem.liggghts.program",
    "Yade": "dem.yade.program",
    "Command": "own_model.command",
    "PythonCallable": "own_model.python_callable",
    "RecordedTable": "own_model.recorded_table",
    "Solver": "base",
    "Workspace": "base",
}


def __getattr__(name: str) -> Any:
    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(f"{__name__}.{_HOMES[name]}"), name)


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
