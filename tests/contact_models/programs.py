"""The installed DEM programs, ready to compute single contacts."""

import shlex
import shutil

import pytest

from grainfit.bulk_tests.heap import Heap
from grainfit.materials.sizes import ParticleSizes
from grainfit.solvers.dem.lammps.program import Lammps
from grainfit.solvers.dem.liggghts.program import Liggghts
from grainfit.testing.single_contacts import LammpsContacts, LiggghtsContacts, YadeContacts

_TEST = Heap(ParticleSizes((0.010,)))


def contacts(solver):
    """Return the program of a solver; skips the test where it is not installed."""
    if solver == "lammps":
        return LammpsContacts(shlex.split(Lammps(_TEST, {}).executes()[0]))
    if shutil.which(solver) is None:
        pytest.skip(f"{solver} is not installed")
    if solver == "liggghts":
        return LiggghtsContacts(shlex.split(Liggghts(_TEST, {}).executes()[0]))
    return YadeContacts(["yade", "-n", "-x", YadeContacts.input_name])
