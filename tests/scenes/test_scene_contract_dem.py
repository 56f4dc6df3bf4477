"""LAMMPS and LIGGGHTS keep the contract of scenes."""

from __future__ import annotations

import pytest

import needs
from grainfit.bulk_tests.heap import Heap
from grainfit.solvers.dem.lammps.program import Lammps
from grainfit.solvers.dem.liggghts.program import Liggghts
from grainfit.testing.clump_contract import ClumpContract
from grainfit.testing.glued_contract import GluedContract
from grainfit.testing.impact_contract import ImpactContract
from grainfit.testing.scene_contract import SceneContract


class TestLammps(SceneContract, GluedContract, ImpactContract, ClumpContract):
    @pytest.fixture
    def solver(self):
        return Lammps(Heap(diameter="10 mm"), {})


@needs.LIGGGHTS
class TestLiggghts(SceneContract, GluedContract, ImpactContract, ClumpContract):
    slide_kick = 0.004

    @pytest.fixture
    def solver(self):
        return Liggghts(Heap(diameter="10 mm"), {})
