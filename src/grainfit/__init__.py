"""Calibrates the material parameters of discrete element (DEM) models of bulk solids."""

from grainfit.calibrate import calibrate
from grainfit.errors import (
    GrainfitError,
    InputError,
    NotMeasurableError,
    RunFailedError,
    SolverNotFoundError,
    StoreError,
)
from grainfit.material import ParticleSizes
from grainfit.problem import Parameter, Problem, Target
from grainfit.progress import Progress
from grainfit.result import Result
from grainfit.solvers.base import Response, Solver, Workspace
from grainfit.timestep import RayleighTimeStep, rayleigh_time_step

__all__ = [
    "GrainfitError",
    "InputError",
    "NotMeasurableError",
    "Parameter",
    "ParticleSizes",
    "Problem",
    "Progress",
    "RayleighTimeStep",
    "Response",
    "Result",
    "RunFailedError",
    "Solver",
    "SolverNotFoundError",
    "StoreError",
    "Target",
    "Workspace",
    "calibrate",
    "rayleigh_time_step",
]
