"""LAMMPS and LIGGGHTS keep the contract of scenes."""

from __future__ import annotations

from dataclasses import replace

import pytest
from typing_extensions import override

import needs
from grainfit.bulk_tests.heap import Heap
from grainfit.errors import RunFailedError
from grainfit.scenes.conditions import Elapsed
from grainfit.scenes.scene import Load, Stage, Wall
from grainfit.scenes.shapes import Block
from grainfit.solvers.dem import messages
from grainfit.solvers.dem.lammps.program import Lammps
from grainfit.solvers.dem.liggghts.program import Liggghts
from grainfit.testing.clump_contract import ClumpContract
from grainfit.testing.glued_contract import GluedContract
from grainfit.testing.impact_contract import ImpactContract
from grainfit.testing.scene_contract import SceneContract
from grainfit.testing.simulated_scenes import (
    BOX,
    DAMPED,
    RADIUS,
    Run,
    resting_overlap,
    scene_of,
    spheres,
)


class TestLammps(SceneContract, GluedContract, ImpactContract, ClumpContract):
    @pytest.fixture
    def solver(self):
        return Lammps(Heap(diameter="10 mm"), {})

    def rests_on_annulus(self, values, distance):
        # A region "cone" has the curvature of a tube of twice the radius: R* = 2 r R / (2 r - R).
        return RADIUS - resting_overlap(values, curve=2 * distance / (2 * distance - RADIUS))


@needs.LIGGGHTS
class TestLiggghts(SceneContract, GluedContract, ImpactContract, ClumpContract):
    slide_kick = 0.004

    @pytest.fixture
    def solver(self):
        return Liggghts(Heap(diameter="10 mm"), {})

    @pytest.mark.slow
    @pytest.mark.thorough
    @override
    def test_a_lowered_bed_hangs_on_a_wide_tube_as_janssen_says(self, run: Run) -> None:
        super().test_a_lowered_bed_hangs_on_a_wide_tube_as_janssen_says(run)

    def test_a_stage_that_presses_on_nothing_is_named(self, run: Run) -> None:
        press = Load("z", -0.001, largest_speed=0.01, gain=1.0)
        stages = [
            Stage("fall", Elapsed(0.3)),
            Stage("press", Elapsed(0.1), motions={"floor": press}),
        ]
        walls = {"floor": Wall(Block((0.05, -0.02, -0.01), (0.08, 0.02, 0.0)))}
        box = replace(BOX, low=(-0.1, -0.1, -0.05))
        scene = scene_of(spheres([(0, 0, 0.05)]), walls, stages, DAMPED, box=box)

        with pytest.raises(
            RunFailedError, match=messages.EMPTY_BOX_PRESSED.matching(stage="press")
        ):
            run(scene)
