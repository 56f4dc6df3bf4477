"""Public names of `grainfit.solvers`."""

from grainfit.solvers.base import Solver as Solver
from grainfit.solvers.base import SourceRecord as SourceRecord
from grainfit.solvers.base import Workspace as Workspace
from grainfit.solvers.dem.lammps.program import Lammps as Lammps
from grainfit.solvers.dem.liggghts.program import Liggghts as Liggghts
from grainfit.solvers.dem.yade.program import Yade as Yade
from grainfit.solvers.own_model.command import Command as Command
from grainfit.solvers.own_model.python_callable import PythonCallable as PythonCallable
from grainfit.solvers.own_model.recorded_table import RecordedTable as RecordedTable
