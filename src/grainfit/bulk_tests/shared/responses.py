"""Responses that several bulk tests share."""

from __future__ import annotations

from grainfit.bulk_tests.response_info import ResponseInfo
from grainfit.bulk_tests.sensitivities import DENSITY, MODULUS, ROLLING, SLIDING, Sensitivities

#: Of a bed that is poured into an upright cylinder.
BULK_DENSITY = ResponseInfo(
    "kg/m^3",
    "ρ_b",
    "bulk density: mass of the bed over its volume, voids included",
    '{ value = "1500 kg/m^3", uncertainty = "1 %" }',
    Sensitivities(
        {DENSITY: 1.07, MODULUS: -0.066, SLIDING: -0.059, ROLLING: -0.023},
        {SLIDING: -0.068, ROLLING: -0.006},
        scatter=0.006,
        larger=(0.048, 0.078),
    ),
)
