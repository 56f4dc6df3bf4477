"""LAMMPS and LIGGGHTS keep the contract of all solvers; with small heaps."""

from __future__ import annotations

import pytest

import needs
from grainfit.bulk_tests.heap import Heap
from grainfit.materials.sizes import ParticleSizes
from grainfit.solvers.dem.lammps.program import Lammps
from grainfit.solvers.dem.liggghts.program import Liggghts
from grainfit.testing.materials import GLASS_BEADS, ROUGH_PLATE
from grainfit.testing.solver_contract import ProcessSolverContract

FREE = ("particle.density", "particle_particle.rolling_friction")
FIXED = {name: value for name, value in GLASS_BEADS.items() if name not in FREE}
BEADS = ParticleSizes((0.010,))
SMALL = Heap(
    BEADS,
    cylinder_radius=0.03,
    strike_off_height=0.08,
    bulk_density_top=0.07,
    plate_radius=0.10,
    **ROUGH_PLATE,
)


class HeapContract(ProcessSolverContract):
    program: type[Lammps | Liggghts]

    @pytest.fixture
    def solver(self):
        return self.program(SMALL, FIXED)

    @pytest.fixture
    def parameters(self):
        return {"particle.density": 2100.0, "particle_particle.rolling_friction": 0.67}

    @pytest.fixture
    def endless(self):
        return self.program(Heap(BEADS, particle_count=6000, cylinder_radius=0.1), FIXED)


@pytest.mark.slow
class TestLammps(HeapContract):
    program = Lammps


@pytest.mark.slow
@needs.LIGGGHTS
class TestLiggghts(HeapContract):
    program = Liggghts
