"""The hopper keeps the contract of bulk tests."""

from __future__ import annotations

from typing import Any, ClassVar

import pytest
from typing_extensions import override

from grainfit.bulk_tests.base import BulkTest
from grainfit.bulk_tests.hopper import Hopper
from grainfit.testing.bulk_test_contract import BulkTestContract


class TestHopper(BulkTestContract):
    others: ClassVar = {
        "orifice": "slot",
        "slot_width": "52 mm",
        "depth": "45 mm",
        "orifice_diameter": "45 mm",
        "width": "95 mm",
        "fill_height": "105 mm",
        "settling_time_limit": "5 s",
        "half_angle": "40 deg",
        "stem_length": "10 mm",
        "fill_mass": "0.9 kg",
        "gravity": "10 m/s^2",
        "time_step_fraction": 0.1,
    }

    open_options: ClassVar = {"slot_width", "depth", "fill_mass"}

    @pytest.fixture
    def bulk_test(self) -> Hopper:
        return Hopper(diameter="10 mm", orifice_diameter="5 cm", width="9 cm")

    @override
    def with_option(self, bulk_test: BulkTest, name: str, value: Any) -> BulkTest:
        """A wedge has no diameter, a cone no depth and no slot; a mass says what a height does."""
        options = {key.name: getattr(bulk_test, key.name) for key in bulk_test.option_keys()}
        if name in ("slot_width", "depth") or value == "slot":
            options |= {"orifice": "slot", "orifice_diameter": None}
        return type(bulk_test)(bulk_test.sizes, **{**options, name: value})
