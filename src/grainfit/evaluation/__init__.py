"""Proposals and evaluations: the messages between a strategy and a campaign."""

from grainfit.evaluation.evaluation import Evaluation, Outcome, Proposal, Stage
from grainfit.evaluation.names import (
    ALL_RUNS,
    ERROR_SUFFIX,
    name_of_test,
    names_of_tests,
    response_name,
    run_name,
    tests_asked,
)
from grainfit.evaluation.response import Curve, Measured, Response, curves, scalars

__all__ = [
    "ALL_RUNS",
    "ERROR_SUFFIX",
    "Curve",
    "Evaluation",
    "Measured",
    "Outcome",
    "Proposal",
    "Response",
    "Stage",
    "curves",
    "name_of_test",
    "names_of_tests",
    "response_name",
    "run_name",
    "scalars",
    "tests_asked",
]
