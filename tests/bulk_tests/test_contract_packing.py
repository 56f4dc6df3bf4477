"""The packing test keeps the contract of bulk tests; its bulk density is the heap's."""

from __future__ import annotations

from pathlib import Path
from typing import ClassVar

import pytest

from grainfit.bulk_tests.heap import Heap
from grainfit.bulk_tests.packing import Packing
from grainfit.errors import InputError
from grainfit.solvers.base import Workspace
from grainfit.solvers.dem.lammps.program import Lammps
from grainfit.testing.bulk_test_contract import BulkTestContract
from grainfit.testing.materials import GLASS_BEADS, ROUGH_PLATE


class TestPacking(BulkTestContract):
    others: ClassVar = {
        "cylinder_radius": "36 mm",
        "fill_height": "95 mm",
        "bulk_density_bottom": "15 mm",
        "bulk_density_top": "65 mm",
        "gravity": "10 m/s^2",
        "time_step_fraction": 0.1,
        "settling_time_limit": "3 s",
    }

    @pytest.fixture
    def bulk_test(self) -> Packing:
        return Packing(
            diameter="10 mm",
            cylinder_radius="35 mm",
            fill_height="90 mm",
            bulk_density_top="70 mm",
        )


@pytest.mark.parametrize(
    ("options", "key"),
    [
        ({"cylinder_radius": "15 mm"}, "cylinder_radius"),
        ({"bulk_density_top": "15 mm"}, "bulk_density_top"),
        ({"fill_height": "95 mm", "bulk_density_top": "85 mm"}, "bulk_density_top"),
        ({"fill_height": "20 mm"}, "fill_height"),
        ({"cylinder_radius": "5 m"}, "cylinder_radius"),
        ({"fill_height": "200 m"}, "fill_height"),
    ],
)
def test_impossible_packings_are_refused(options: dict[str, str], key: str) -> None:
    with pytest.raises(InputError) as caught:
        Packing(diameter="10 mm", **options)
    assert [fault.key for fault in caught.value.faults] == [key]


def test_a_default_bed_is_as_high_as_it_is_measured() -> None:
    high = Packing(diameter="10 mm", bulk_density_top="11 cm").setup
    low = Packing(diameter="10 mm", fill_height="6 cm").setup

    assert high.fill_height == pytest.approx(0.11 / 0.85)
    assert low.bulk_density_top == pytest.approx(0.85 * 0.06)


@pytest.mark.slow
def test_a_packing_is_as_dense_as_the_bed_of_a_heap(tmp_path: Path) -> None:
    densities = {}
    for test in (Packing(diameter="10 mm"), Heap(diameter="10 mm", **ROUGH_PLATE)):
        folder = tmp_path / test.type
        folder.mkdir()
        responses = Lammps(test, GLASS_BEADS).run({}, 3, Workspace(folder, 600.0))
        densities[test.type] = responses["bulk_density"].value

    # Seeds of both scatter by 0.4 %.
    assert densities["packing"] == pytest.approx(densities["heap"], rel=0.017)
