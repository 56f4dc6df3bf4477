"""Calibration problems: free parameters, targets, measured curves, and the scopes of tests."""

from grainfit.problem.curve_target import CurveTarget
from grainfit.problem.parameter import Parameter
from grainfit.problem.problem import Problem
from grainfit.problem.target import Target
from grainfit.problem.test_scope import Relative, TestScope

__all__ = ["CurveTarget", "Parameter", "Problem", "Relative", "Target", "TestScope"]
