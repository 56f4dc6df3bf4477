"""The drum keeps the contract of bulk tests."""

from __future__ import annotations

from typing import ClassVar

import pytest

from grainfit.bulk_tests.drum import Drum
from grainfit.testing.bulk_test_contract import BulkTestContract
from grainfit.testing.materials import ROUGH_SPHERES


class TestDrum(BulkTestContract):
    others: ClassVar = {
        "drum_radius": "75 mm",
        "drum_length": "45 mm",
        "fill_level": 0.35,
        "rotational_speed": 2.5,
        "froude_number": 0.06,
        "end_caps": True,
        "lining": False,
        "discarded_turns": 0.3,
        "averaged_turns": 1.1,
        "gravity": "10 m/s^2",
        "time_step_fraction": 0.1,
    }

    material: ClassVar = ROUGH_SPHERES

    @pytest.fixture
    def bulk_test(self) -> Drum:
        return Drum(
            diameter="10 mm",
            drum_radius="60 mm",
            drum_length="40 mm",
            discarded_turns=0.2,
            averaged_turns=0.8,
        )
