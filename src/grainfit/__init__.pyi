"""Public names of the package, each imported from its home when it is first used."""

from grainfit import plots as plots
from grainfit import scenes as scenes
from grainfit import solvers as solvers
from grainfit import testing as testing
from grainfit import tests as tests
from grainfit.analysis.analysis import Analysis as Analysis
from grainfit.analysis.analysis import analyse as analyse
from grainfit.analysis.modulus_study import ModulusStudy as ModulusStudy
from grainfit.analysis.scatter import RepeatedRuns as RepeatedRuns
from grainfit.atlas.estimate import Estimate as Estimate
from grainfit.calibration.calibrate import calibrate as calibrate
from grainfit.calibration.holdout import Holdout as Holdout
from grainfit.calibration.progress import Progress as Progress
from grainfit.calibration_file.build import CalibrationSetup as CalibrationSetup
from grainfit.calibration_file.build import load_calibration
from grainfit.errors import GrainfitError as GrainfitError
from grainfit.errors import InputError as InputError
from grainfit.errors import NotMeasurableError as NotMeasurableError
from grainfit.errors import RunFailedError as RunFailedError
from grainfit.errors import SolverNotFoundError as SolverNotFoundError
from grainfit.errors import StoreError as StoreError
from grainfit.evaluation import Curve as Curve
from grainfit.evaluation import Evaluation as Evaluation
from grainfit.evaluation import Proposal as Proposal
from grainfit.evaluation import Response as Response
from grainfit.interview.interview import Interview as Interview
from grainfit.materials.diameters import sieve_curve as sieve_curve
from grainfit.materials.size_classes import divide_into_classes as divide_into_classes
from grainfit.materials.size_distributions import LogNormal as LogNormal
from grainfit.materials.size_distributions import RosinRammler as RosinRammler
from grainfit.materials.size_distributions import SieveCurve as SieveCurve
from grainfit.materials.sizes import ParticleSizes as ParticleSizes
from grainfit.materials.time_step import RayleighTimeStep as RayleighTimeStep
from grainfit.materials.time_step import rayleigh_time_step as rayleigh_time_step
from grainfit.materials.wall_friction import friction_of_angle as friction_of_angle
from grainfit.opened import OpenedCalibration as OpenedCalibration
from grainfit.opened import open_calibration
from grainfit.photographs.draw_down_photo import (
    PhotographedDrawDowns as PhotographedDrawDowns,
)
from grainfit.photographs.drum_photo import PhotographedDrum as PhotographedDrum
from grainfit.photographs.photo import PhotographedHeaps as PhotographedHeaps
from grainfit.photographs.photo import photo as photo
from grainfit.photographs.slope_photo import PhotographedSlopes as PhotographedSlopes
from grainfit.problem import CurveTarget as CurveTarget
from grainfit.problem import Parameter as Parameter
from grainfit.problem import Problem as Problem
from grainfit.problem import Relative as Relative
from grainfit.problem import Target as Target
from grainfit.problem import TestScope as TestScope
from grainfit.report.page import write_report as write_report
from grainfit.result import Result as Result
from grainfit.showing import show as show
from grainfit.solvers.base import Solver as Solver
from grainfit.solvers.base import Workspace as Workspace
from grainfit.strategies.answer import Answer as Answer
from grainfit.strategies.base import Search as Search
from grainfit.strategies.base import Strategy as Strategy
from grainfit.strategies.sequential.strategy import Sequential as Sequential
from grainfit.strategies.staged.strategy import Staged as Staged
from grainfit.which_test.measurement_plan import MeasurementPlan as MeasurementPlan
from grainfit.which_test.narrowing import ExpectedNarrowing as ExpectedNarrowing
from grainfit.which_test.narrowing import expected_narrowing as expected_narrowing
from grainfit.which_test.next_test import Advice as Advice
from grainfit.work_folder.analyse_runs import RunsAnalysis as RunsAnalysis
from grainfit.work_folder.analyse_runs import analyse_runs as analyse_runs
from grainfit.work_folder.design import design as design
from grainfit.work_folder.estimate import estimate as estimate
from grainfit.work_folder.predict import Predictions as Predictions
from grainfit.work_folder.predict import predict as predict
from grainfit.work_folder.repeat_runs import repeat_runs as repeat_runs
from grainfit.work_folder.size_study import size_study as size_study
from grainfit.work_folder.stiffness_study import stiffness_study as stiffness_study

__version__: str
load = load_calibration
open = open_calibration  # noqa: A001
