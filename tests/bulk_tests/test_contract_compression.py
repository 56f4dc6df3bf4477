"""The compression test keeps the contract of bulk tests."""

from __future__ import annotations

from typing import ClassVar

import pytest

from grainfit.bulk_tests.compression import Compression
from grainfit.testing.bulk_test_contract import BulkTestContract
from grainfit.testing.materials import GLASS_BEADS


class TestCompressionContract(BulkTestContract):
    material: ClassVar = {**GLASS_BEADS, "particle.youngs_modulus": 1e7}
    others: ClassVar = {
        "stress": "9 kPa",
        "seating_stress": "600 Pa",
        "cylinder_radius": "31 mm",
        "strike_off_height": "51 mm",
        "particle_count": 260,
        "piston_speed": "0.02 m/s",
        "settling_time_limit": "3 s",
        "gravity": "10 m/s^2",
        "time_step_fraction": 0.1,
    }

    open_options: ClassVar = {"piston_speed"}

    @pytest.fixture
    def bulk_test(self) -> Compression:
        return Compression(diameter="10 mm", cylinder_radius="30 mm", strike_off_height="50 mm")
