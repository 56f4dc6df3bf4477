"""The tapped test keeps the contract of bulk tests; its vessel comes back, and its bed sinks."""

from __future__ import annotations

import math
from pathlib import Path
from typing import ClassVar

import pytest

from grainfit.bulk_tests.packing import Packing
from grainfit.bulk_tests.tapped import Tapped
from grainfit.errors import InputError
from grainfit.scenes.conditions import Elapsed
from grainfit.solvers.base import Workspace
from grainfit.solvers.dem.lammps.program import Lammps
from grainfit.testing.bulk_test_contract import BulkTestContract
from grainfit.testing.materials import ROUGH_SPHERES

SMALL = {"cylinder_radius": "25 mm", "fill_height": "60 mm", "bulk_density_top": "45 mm"}


class TestTapped(BulkTestContract):
    others: ClassVar = {
        "cylinder_radius": "26 mm",
        "fill_height": "65 mm",
        "bulk_density_bottom": "12 mm",
        "bulk_density_top": "46 mm",
        "taps": 4,
        "drop_height": "8 mm",
        "gravity": "10 m/s^2",
        "time_step_fraction": 0.1,
        "settling_time_limit": "3 s",
    }
    material: ClassVar = ROUGH_SPHERES

    @pytest.fixture
    def bulk_test(self) -> Tapped:
        return Tapped(diameter="10 mm", taps=2, **SMALL)


def test_the_vessel_falls_by_the_drop_height_and_comes_back_to_its_place() -> None:
    scene = Tapped(diameter="10 mm", drop_height="7 mm", taps=3).scene(ROUGH_SPHERES, 1)
    moved = [stage for stage in scene.stages if stage.motions]
    travels = [
        {name: motion.speed * stage.until.time for name, motion in stage.motions.items()}
        for stage in moved
        if isinstance(stage.until, Elapsed)
    ]

    assert [stage.name for stage in moved] == [
        f"{word}_{tap}" for tap in (1, 2, 3) for word in ("lift", "drop")
    ]
    up, down = travels[0::2], travels[1::2]
    assert all(travel == {"container": 0.007, "floor": 0.007} for travel in up)
    assert all(travel == {"container": -0.007, "floor": -0.007} for travel in down)
    # Faster than the bed can follow, and lifted so slowly that it does.
    speeds = [abs(next(iter(stage.motions.values())).speed) for stage in moved[:2]]
    landing = math.sqrt(2 * 9.81 * 0.007)
    assert speeds[0] < landing / 4
    assert speeds[1] > 4 * landing
    # In whole time steps, so that programs move it that far.
    for stage in moved:
        steps = stage.until.time / scene.time_step
        assert steps == pytest.approx(round(steps), abs=1e-6)


def test_it_is_poured_as_a_packing() -> None:
    options = {"diameter": "10 mm", "cylinder_radius": "45 mm"}
    poured = Packing(**options).scene(ROUGH_SPHERES, 4)
    tapped = Tapped(**options).scene(ROUGH_SPHERES, 4)
    assert (tapped.particles.positions == poured.particles.positions).all()
    assert tapped.stages[0] == poured.stages[0]
    assert tapped.walls == poured.walls


def test_a_drop_of_more_than_half_the_bed_is_refused() -> None:
    with pytest.raises(InputError) as caught:
        Tapped(diameter="10 mm", drop_height="61 mm")
    assert [fault.key for fault in caught.value.faults] == ["drop_height"]


def test_taps_make_a_loose_bed_denser(tmp_path: Path) -> None:
    test = Tapped(diameter="10 mm", taps=4, **SMALL)
    found = Lammps(test, ROUGH_SPHERES).run({}, 2, Workspace(tmp_path, 300))
    poured, tapped = found["bulk_density"], found["tapped_density"]

    assert tapped.value > poured.value + 2 * poured.standard_error
    assert found["hausner_ratio"].value == pytest.approx(tapped.value / poured.value)
    curve = found["compaction"]
    assert list(curve.coordinates) == [0.0, 1.0, 2.0, 3.0, 4.0]
    assert (curve.values[0], curve.values[-1]) == (poured.value, tapped.value)
    # Looser than random close packing.
    assert tapped.value < 0.68 * ROUGH_SPHERES["particle.density"]
