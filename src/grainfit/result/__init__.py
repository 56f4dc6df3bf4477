"""Result of a calibration, and its parts."""

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
    "MetamodelQuality",
    "ParameterInterval",
    "ResponseResult",
    "Result",
    "RunCounts",
    "RunSummary",
    "YieldLocus",
    "YieldLocusResult",
    "damaged_result",
]
