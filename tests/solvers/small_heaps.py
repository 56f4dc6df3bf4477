"""LAMMPS and LIGGGHTS where they are installed, and a heap of a third of the usual beads."""

import pytest

import needs
from grainfit.solvers.dem.lammps.program import Lammps
from grainfit.solvers.dem.liggghts.program import Liggghts
from grainfit.testing.materials import ROUGH_PLATE

each_solver = pytest.mark.parametrize(
    "solver_type",
    [
        pytest.param(Lammps, id="lammps"),
        pytest.param(Liggghts, id="liggghts", marks=needs.LIGGGHTS),
    ],
)
#: What LIGGGHTS shares with LAMMPS but for its deck, which shorter tests look at.
lammps_and_thoroughly_liggghts = pytest.mark.parametrize(
    "solver_type",
    [
        pytest.param(Lammps, id="lammps"),
        pytest.param(Liggghts, id="liggghts", marks=[needs.LIGGGHTS, pytest.mark.thorough]),
    ],
)
SMALL_HEAP = {
    "cylinder_radius": 0.04,
    "strike_off_height": 0.08,
    "bulk_density_top": 0.07,
    "plate_radius": 0.12,
    **ROUGH_PLATE,
}
