"""The calibration file: TOML with units in, plain validated data in SI units out."""

from grainfit.calibration_file.model import CalibrationFile, StrategyOptions, TestSpecification
from grainfit.calibration_file.places import FileFault
from grainfit.calibration_file.reading import load_calibration_file
from grainfit.calibration_file.schema import calibration_file_schema, schema_path

__all__ = [
    "CalibrationFile",
    "FileFault",
    "StrategyOptions",
    "TestSpecification",
    "calibration_file_schema",
    "load_calibration_file",
    "schema_path",
]
