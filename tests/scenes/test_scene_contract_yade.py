"""YADE keeps the contract of scenes.

Most scenes take a few tenths of a second, so that copies of one process run them.
tests/solvers/test_contract_yade.py starts it as users do.
"""

from __future__ import annotations

import math

import pytest

import needs
from grainfit.bulk_tests.heap import Heap
from grainfit.scenes.conditions import Clear
from grainfit.scenes.scene import Stage, Velocity, Wall
from grainfit.scenes.shapes import Cylinder
from grainfit.solvers.dem.yade.program import Yade
from grainfit.testing.clump_contract import ClumpContract
from grainfit.testing.glued_contract import GluedContract
from grainfit.testing.impact_contract import ImpactContract
from grainfit.testing.scene_contract import SceneContract
from grainfit.testing.simulated_scenes import FLOOR, RADIUS, frames, scene_of, spheres
from tests.started_yade import started_yade

pytestmark = needs.YADE


class StartedYade(Yade):
    """YADE in a copy of a process that has been started."""

    def _simulate(self, deck, workspace):
        self.run_script(workspace.folder / "in.yade.py")


@pytest.fixture(scope="module")
def run_script(tmp_path_factory):
    with started_yade(tmp_path_factory.mktemp("server")) as run:
        yield run


@pytest.mark.slow
class TestYade(SceneContract, GluedContract, ImpactContract, ClumpContract):
    # YADE adds increments of the tangential force, which stay while the contact unloads; the other
    # programs multiply a displacement by the stiffness of the moment. That matters for contacts
    # that stick: measured, 0.065 at an incidence of 5 degrees, 0.025 at 10, 0.007 from 20 on.
    oblique_tolerance = 0.07
    patch_tolerance = 1.8
    # Its tangential dashpot is switched off while the contact slides: measured, up to 0.17.
    sliding_tolerance = 0.18
    # Until the spring slides, that dashpot is not limited: measured, 0.003 m/s at 0.3 m/s.
    slide_kick = 0.004
    is_slow = True

    def tube_floor(self, radius):
        # A panel, flat, of a polygon with the area of the circle.
        part = math.pi / max(24, math.ceil(2 * math.pi * radius / 0.0095))
        return radius * math.sqrt(part / math.tan(part)), math.inf

    @pytest.fixture
    def solver(self, run_script):
        solver = StartedYade(Heap(diameter="10 mm"), {})
        solver.run_script = run_script
        return solver

    def test_a_lift_without_a_particle_ends(self, run):
        lift = Stage("lift", Clear("tube", 0.5), motions={"tube": Velocity("z", 0.1)})
        walls = {**FLOOR, "tube": Wall(Cylinder(0.03, 0.0, 0.1))}
        gone = spheres([(0.05, 0, RADIUS)], [(3, 0, 0)])
        out = run(scene_of(gone, walls, [*frames(0.05), lift]))

        assert [(end.end, end.particles) for end in out.stages] == [("done", 0), ("done", 0)]
