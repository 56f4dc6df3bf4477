"""The shear cell keeps the contract of bulk tests."""

from __future__ import annotations

from typing import ClassVar

import pytest

from grainfit.bulk_tests.shear_cell import ShearCell
from grainfit.testing.bulk_test_contract import BulkTestContract
from grainfit.testing.materials import ROUGH_SPHERES


class TestShearCell(BulkTestContract):
    others: ClassVar = {
        "normal_stress": "400 Pa",
        "inertial_number": 0.03,
        "length": "75 mm",
        "depth": "45 mm",
        "gap": "75 mm",
        "transient_strain": 0.8,
        "lowest_stress": "100 Pa",
        "highest_stress": "300 Pa",
        "points": 3,
        "cycles": 3,
        "preshear_strain": 0.35,
        "failure_strain": 0.3,
        "gravity": "10 m/s^2",
        "time_step_fraction": 0.06,
    }

    #: Cohesive, or the run would be without the flow function coefficient.
    material: ClassVar = {
        **ROUGH_SPHERES,
        "particle_particle.surface_energy": 0.5,
        "particle_particle.rolling_damping": 0.0,
        "particle_wall.rolling_damping": 0.0,
    }

    @pytest.fixture
    def bulk_test(self) -> ShearCell:
        return ShearCell(
            diameter="10 mm",
            length="7 cm",
            depth="4 cm",
            gap="7 cm",
            transient_strain=0.5,
            points=2,
            cycles=2,
            preshear_strain=0.3,
            failure_strain=0.2,
        )
