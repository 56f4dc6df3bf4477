"""LAMMPS keeps the contract of clumps; the others refuse them."""

from __future__ import annotations

import pytest

from grainfit.bulk_tests.heap import Heap
from grainfit.solvers.dem.lammps.program import Lammps
from grainfit.testing.clump_contract import ClumpContract


class TestLammpsClumps(ClumpContract):
    @pytest.fixture
    def solver(self):
        return Lammps(Heap(diameter="10 mm"), {})
