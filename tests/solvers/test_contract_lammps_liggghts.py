"""LAMMPS and LIGGGHTS keep the contract of all solvers; with small heaps."""

from __future__ import annotations

import shutil

import pytest

from grainfit.bulk_tests.heap import HeapTest
from grainfit.material import ParticleSizes
from grainfit.solvers.lammps import Lammps
from grainfit.solvers.liggghts import Liggghts
from grainfit.testing.solver_contract import ProcessSolverContract

FIXED = {
    "particle.youngs_modulus": 3.6e5,
    "particle.poissons_ratio": 0.22,
    "wall.youngs_modulus": 2.11e11,
    "wall.poissons_ratio": 0.30,
    "wall.density": 7700.0,
    "particle_particle.sliding_friction": 0.18,
    "particle_particle.restitution": 0.79,
    "particle_particle.rolling_damping": 0.25,
    "particle_wall.sliding_friction": 0.27,
    "particle_wall.rolling_friction": 0.005,
    "particle_wall.restitution": 0.82,
    "particle_wall.rolling_damping": 0.25,
}
BEADS = ParticleSizes((0.010,))
SMALL = HeapTest(
    BEADS,
    cylinder_radius=0.03,
    strike_off_height=0.08,
    bulk_density_top=0.07,
    plate_radius=0.10,
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
        return self.program(HeapTest(BEADS, particle_count=6000, cylinder_radius=0.1), FIXED)


@pytest.mark.slow
class TestLammps(HeapContract):
    program = Lammps


@pytest.mark.slow
@pytest.mark.skipif(shutil.which("liggghts") is None, reason="LIGGGHTS is not installed")
class TestLiggghts(HeapContract):
    program = Liggghts
