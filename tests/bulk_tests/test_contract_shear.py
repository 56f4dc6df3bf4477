"""The shear test keeps the contract of bulk tests."""

from __future__ import annotations

from typing import ClassVar

import pytest

from grainfit.bulk_tests.shear import Shear
from grainfit.testing.bulk_test_contract import BulkTestContract
from grainfit.testing.materials import ROUGH_SPHERES


class TestShear(BulkTestContract):
    others: ClassVar = {
        "normal_stress": "400 Pa",
        "inertial_number": 0.03,
        "length": "75 mm",
        "depth": "45 mm",
        "gap": "75 mm",
        "transient_strain": 0.8,
        "averaged_strain": 1.2,
        "gravity": "10 m/s^2",
        "time_step_fraction": 0.1,
    }

    material: ClassVar = ROUGH_SPHERES

    @pytest.fixture
    def bulk_test(self) -> Shear:
        return Shear(
            diameter="10 mm",
            length="7 cm",
            depth="4 cm",
            gap="7 cm",
            transient_strain=0.5,
            averaged_strain=1.0,
        )
