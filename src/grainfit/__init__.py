"""Calibrates the material parameters of discrete element (DEM) models of bulk solids."""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    __version__: str
    from grainfit import plots as plots
    from grainfit import solvers as solvers
    from grainfit import tests as tests
    from grainfit.analysis import Analysis, analyse
    from grainfit.analysis.modulus_study import ModulusStudy
    from grainfit.analysis.scatter import RepeatedRuns
    from grainfit.calibration.calibrate import calibrate
    from grainfit.calibration.progress import Progress
    from grainfit.calibration_file.build import CalibrationSetup
    from grainfit.calibration_file.build import load_calibration as load
    from grainfit.errors import (
        GrainfitError,
        InputError,
        NotMeasurableError,
        RunFailedError,
        SolverNotFoundError,
        StoreError,
    )
    from grainfit.evaluation import Curve, Evaluation, Proposal, Response
    from grainfit.materials.sieve_file import sieve_curve
    from grainfit.materials.size_classes import divide_into_classes
    from grainfit.materials.size_distributions import LogNormal, RosinRammler, SieveCurve
    from grainfit.materials.sizes import ParticleSizes
    from grainfit.materials.time_step import RayleighTimeStep, rayleigh_time_step
    from grainfit.materials.wall_friction import friction_of_angle
    from grainfit.opened import OpenedCalibration
    from grainfit.opened import open_calibration as open  # noqa: A004
    from grainfit.problem import CurveTarget, Parameter, Problem, Target, TestScope
    from grainfit.report.page import write_report
    from grainfit.result import Result
    from grainfit.solvers.base import Solver, Workspace
    from grainfit.strategies.answer import Answer
    from grainfit.strategies.base import Search, Strategy
    from grainfit.strategies.sequential.strategy import Sequential
    from grainfit.strategies.staged.strategy import Staged
    from grainfit.which_test.measurement_plan import MeasurementPlan
    from grainfit.which_test.narrowing import ExpectedNarrowing, expected_narrowing
    from grainfit.which_test.next_test import Advice
    from grainfit.work_folder.analyse_runs import RunsAnalysis, analyse_runs
    from grainfit.work_folder.design import design
    from grainfit.work_folder.repeat_runs import repeat_runs
    from grainfit.work_folder.stiffness_study import stiffness_study

__all__ = [
    "Advice",
    "Analysis",
    "Answer",
    "CalibrationSetup",
    "Curve",
    "CurveTarget",
    "Evaluation",
    "ExpectedNarrowing",
    "GrainfitError",
    "InputError",
    "LogNormal",
    "MeasurementPlan",
    "ModulusStudy",
    "NotMeasurableError",
    "OpenedCalibration",
    "Parameter",
    "ParticleSizes",
    "Problem",
    "Progress",
    "Proposal",
    "RayleighTimeStep",
    "RepeatedRuns",
    "Response",
    "Result",
    "RosinRammler",
    "RunFailedError",
    "RunsAnalysis",
    "Search",
    "Sequential",
    "SieveCurve",
    "Solver",
    "SolverNotFoundError",
    "Staged",
    "StoreError",
    "Strategy",
    "Target",
    "TestScope",
    "Workspace",
    "analyse",
    "analyse_runs",
    "calibrate",
    "design",
    "divide_into_classes",
    "expected_narrowing",
    "friction_of_angle",
    "load",
    "open",
    "plots",
    "rayleigh_time_step",
    "repeat_runs",
    "sieve_curve",
    "stiffness_study",
    "write_report",
]

# Imported when first used: the command line does without most of it, and SciPy takes a second.
_HOMES = {
    **dict.fromkeys(("Analysis", "analyse"), "analysis.analysis"),
    **dict.fromkeys(("ExpectedNarrowing", "expected_narrowing"), "which_test.narrowing"),
    "calibrate": "calibration.calibrate",
    **dict.fromkeys(("CalibrationSetup", "load"), "calibration_file.build"),
    "ParticleSizes": "materials.sizes",
    **dict.fromkeys(("LogNormal", "RosinRammler", "SieveCurve"), "materials.size_distributions"),
    "divide_into_classes": "materials.size_classes",
    "sieve_curve": "materials.sieve_file",
    "OpenedCalibration": "opened",
    "Progress": "calibration.progress",
    "Result": "result",
    "open": "opened",
    "ModulusStudy": "analysis.modulus_study",
    "Advice": "which_test.next_test",
    "MeasurementPlan": "which_test.measurement_plan",
    "design": "work_folder.design",
    **dict.fromkeys(("RunsAnalysis", "analyse_runs"), "work_folder.analyse_runs"),
    "RepeatedRuns": "analysis.scatter",
    "repeat_runs": "work_folder.repeat_runs",
    "stiffness_study": "work_folder.stiffness_study",
    "write_report": "report.page",
    **dict.fromkeys(("CurveTarget", "Parameter", "Problem", "Target", "TestScope"), "problem"),
    **dict.fromkeys(("Curve", "Evaluation", "Proposal", "Response"), "evaluation"),
    "Answer": "strategies.answer",
    **dict.fromkeys(("Search", "Strategy"), "strategies.base"),
    "Sequential": "strategies.sequential.strategy",
    "Staged": "strategies.staged.strategy",
    **dict.fromkeys(("Solver", "Workspace"), "solvers.base"),
    **dict.fromkeys(("RayleighTimeStep", "rayleigh_time_step"), "materials.time_step"),
    "friction_of_angle": "materials.wall_friction",
    **{name: "errors" for name in __all__ if name.endswith("Error")},
}


#: Rooms that are used by their name.
_ROOMS = ("plots", "scenes", "solvers", "tests")
#: Functions that have a longer name at home.
_OTHER_NAMES = {"load": "load_calibration", "open": "open_calibration"}


def __getattr__(name: str) -> Any:
    if name == "__version__":
        return import_module("importlib.metadata").version("grainfit")
    if name in _ROOMS:
        return import_module(f"{__name__}.{name}")
    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    home = import_module(f"{__name__}.{_HOMES[name]}")
    return getattr(home, _OTHER_NAMES.get(name, name))


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
