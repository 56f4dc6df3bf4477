"""The discharge keeps the contract of bulk tests."""

from __future__ import annotations

from typing import Any, ClassVar

import pytest
from typing_extensions import override

from grainfit.bulk_tests.base import BulkTest
from grainfit.bulk_tests.discharge import Discharge
from grainfit.testing.bulk_test_contract import BulkTestContract


class TestDischarge(BulkTestContract):
    others: ClassVar = {
        "orifice": "round",
        "slot_width": "52 mm",
        "depth": "45 mm",
        "orifice_diameter": "55 mm",
        "width": "110 mm",
        "fill_height": "105 mm",
        "settling_time_limit": "5 s",
        "flow_until": "rest",
        "gravity": "10 m/s^2",
        "time_step_fraction": 0.1,
    }

    open_options: ClassVar = {"orifice_diameter"}

    @pytest.fixture
    def bulk_test(self) -> Discharge:
        return Discharge(diameter="10 mm", depth="4 cm", width="10 cm", fill_height="10 cm")

    @override
    def with_option(self, bulk_test: BulkTest, name: str, value: Any) -> BulkTest:
        """A round orifice has no depth and no slot, and a slot has no diameter."""
        options = {key.name: getattr(bulk_test, key.name) for key in bulk_test.option_keys()}
        if name == "orifice_diameter" or value == "round":
            options |= {"orifice": "round", "depth": None, "slot_width": None}
        return type(bulk_test)(bulk_test.sizes, **{**options, name: value})
