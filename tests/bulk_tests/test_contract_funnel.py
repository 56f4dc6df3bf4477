"""The funnel test keeps the contract of bulk tests."""

from __future__ import annotations

from typing import ClassVar

import pytest

from grainfit.bulk_tests.funnel import Funnel
from grainfit.errors import InputError
from grainfit.testing.bulk_test_contract import BulkTestContract
from grainfit.testing.materials import ROUGH_PLATE


class TestFunnel(BulkTestContract):
    others: ClassVar = {
        "poured_volume": "700 cm^3",
        "outlet_diameter": "55 mm",
        "funnel_height": "80 mm",
        "raise_speed": "15 mm/s",
        "half_angle": "35 deg",
        "funnel_radius": "70 mm",
        "stem_length": "10 mm",
        "base": "disc",
        "plate_radius": "140 mm",
        "rim_height": "5 mm",
        "plate_sliding_friction": 0.6,
        "plate_rolling_friction": 0.3,
        "gravity": "10 m/s^2",
        "time_step_fraction": 0.1,
        "settling_time_limit": "9 s",
        "views": 6,
    }

    @pytest.fixture
    def bulk_test(self) -> Funnel:
        return Funnel(diameter="10 mm", poured_volume="800 cm^3", **ROUGH_PLATE)


def test_too_large_a_volume_is_named_in_its_own_unit() -> None:
    with pytest.raises(InputError, match=r"poured_volume 0\.00015 m³"):
        Funnel(diameter="0.3 mm", poured_volume="150 ml", **ROUGH_PLATE)
