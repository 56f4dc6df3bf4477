"""Result of a calibration, and its parts."""

from grainfit.result.holdout import HoldoutCurve, HoldoutResponse, HoldoutResult, Registration
from grainfit.result.parts import (
    CurveResult,
    MetamodelQuality,
    ParameterInterval,
    ResponseResult,
    RunCounts,
    RunSummary,
    YieldLocus,
    YieldLocusResult,
)
from grainfit.result.result import Result, damaged_result

__all__ = [
    "CurveResult",
    "HoldoutCurve",
    "HoldoutResponse",
    "HoldoutResult",
    "MetamodelQuality",
    "ParameterInterval",
    "Registration",
    "ResponseResult",
    "Result",
    "RunCounts",
    "RunSummary",
    "YieldLocus",
    "YieldLocusResult",
    "damaged_result",
]
