"""The heap test keeps the contract of bulk tests, and its decks are those of its revision."""

from __future__ import annotations

import hashlib
from pathlib import Path
from typing import ClassVar

import pytest

from grainfit.bulk_tests.heap import Heap
from grainfit.bulk_tests.heap.bulk_test import DECK_REVISION
from grainfit.materials.sizes import ParticleSizes
from grainfit.testing.bulk_test_contract import BulkTestContract
from grainfit.testing.materials import GLASS_BEADS


class TestHeap(BulkTestContract):
    others: ClassVar = {
        "particle_count": 480,
        "cylinder_radius": "36 mm",
        "plate_radius": "85 mm",
        "rim_height": "5 mm",
        "strike_off_height": "82 mm",
        "bulk_density_bottom": "15 mm",
        "bulk_density_top": "65 mm",
        "lift_speed": "0.2 m/s",
        "lift_height": "60 mm",
        "plate_sliding_friction": 0.4,
        "plate_rolling_friction": 0.1,
        "gravity": "10 m/s^2",
        "time_step_fraction": 0.1,
        "settling_time_limit": "3 s",
        "views": 6,
    }

    @pytest.fixture
    def bulk_test(self) -> Heap:
        return Heap(
            diameter="10 mm",
            cylinder_radius="35 mm",
            plate_radius="80 mm",
            strike_off_height="85 mm",
            bulk_density_top="70 mm",
            lift_speed="0.3 m/s",
        )


#: Rendered decks of revision e11f78288590e984, of beads and of a mixture with a rim.
RENDERED = {
    "lammps": "51f857f5f5d1ef00",
    "liggghts": "2ead2043ceb98b67",
}


@pytest.mark.parametrize("solver", RENDERED)
def test_rendered_decks_are_those_of_their_revision(tmp_path: Path, solver: str) -> None:
    stiff = {**GLASS_BEADS, "particle.youngs_modulus": 5e6, "particle_wall.sliding_friction": 0.6}
    mixture = ParticleSizes((0.012, 0.008), (0.5, 0.5))
    digest = hashlib.sha256()
    for test, material in (
        (Heap(diameter="10 mm"), GLASS_BEADS),
        (Heap(mixture, rim_height="10 mm", plate_rolling_friction=0.1), stiff),
    ):
        digest.update(test.write_deck(tmp_path, solver, material, seed=1).read_bytes())

    assert (DECK_REVISION, digest.hexdigest()[:16]) == ("e11f78288590e984", RENDERED[solver]), (
        "the decks have changed, and with them the outcome of runs: bump the revision "
        "(DECK_REVISION in bulk_tests/heap/bulk_test.py), and give this test the new values"
    )
