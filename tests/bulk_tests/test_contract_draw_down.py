"""The draw-down keeps the contract of bulk tests."""

from __future__ import annotations

from typing import ClassVar

import pytest

from grainfit.bulk_tests.draw_down import DrawDown
from grainfit.testing.bulk_test_contract import BulkTestContract
from grainfit.testing.materials import ROUGH_SPHERES


class TestDrawDown(BulkTestContract):
    others: ClassVar = {
        "width": "150 mm",
        "depth": "45 mm",
        "fill_height": "82 mm",
        "slot_width": "43 mm",
        "shelf_thickness": "6 mm",
        "floor_distance": "130 mm",
        "floor_half_width": "310 mm",
        "floor_sliding_friction": 0.6,
        "floor_rolling_friction": 0.2,
        "settling_time_limit": "3 s",
        "gravity": "10 m/s^2",
        "time_step_fraction": 0.1,
    }

    material: ClassVar = ROUGH_SPHERES

    @pytest.fixture
    def bulk_test(self) -> DrawDown:
        return DrawDown(
            diameter="10 mm",
            width="17 cm",
            depth="4 cm",
            fill_height="8 cm",
            slot_width="4 cm",
            floor_rolling_friction=0.3,
        )
