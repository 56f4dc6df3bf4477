"""The heap test keeps the contract of bulk tests."""

from __future__ import annotations

from typing import ClassVar

import pytest

from grainfit.bulk_tests.heap import Heap
from grainfit.testing.bulk_test_contract import BulkTestContract
from grainfit.testing.materials import ROUGH_PLATE


class TestHeap(BulkTestContract):
    others: ClassVar = {
        "particle_count": 480,
        "cylinder_radius": "36 mm",
        "plate_radius": "105 mm",
        "base": "disc",
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
            plate_radius="110 mm",
            strike_off_height="85 mm",
            bulk_density_top="70 mm",
            lift_speed="0.3 m/s",
            **ROUGH_PLATE,
        )
