"""YADE keeps the contract of scenes."""

from __future__ import annotations

import shutil

import pytest

from grainfit.bulk_tests.heap import Heap
from grainfit.solvers.dem.yade.program import Yade
from grainfit.testing.impact_contract import ImpactContract
from grainfit.testing.scene_contract import SceneContract

pytestmark = pytest.mark.skipif(
    shutil.which("yade") is None, reason="YADE is not installed: apt-get install yade"
)


class TestYade(SceneContract, ImpactContract):
    @pytest.fixture
    def solver(self):
        return Yade(Heap(diameter="10 mm"), {})
