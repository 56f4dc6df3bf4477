"""Likelihood of measured values, given what metamodels predict."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.stats import multivariate_normal

import grainfit as gf
from grainfit.metamodels.likelihood import Likelihood

PROBLEM = gf.Problem(
    [gf.Parameter("a", 0.0, 1.0)],
    [gf.Target("s", 1.0, uncertainty=0.2), gf.Target("t", 2.0, uncertainty=0.4)],
)
MEANS = np.array([[1.1, 1.7], [0.8, 2.4], [1.3, 2.3]])
ERRORS = np.array([[0.01, 0.09], [0.04, 0.04], [0.16, 0.01]])


def test_independent_errors_are_those_without_correlation() -> None:
    likelihood = Likelihood(PROBLEM)
    found = likelihood.logarithms(MEANS, ERRORS, np.eye(2))
    assert found == pytest.approx(likelihood.logarithms(MEANS, ERRORS))


def test_errors_of_metamodels_may_be_correlated() -> None:
    between = np.array([[1.0, 0.8], [0.8, 1.0]])
    measured = np.diag([one.standard_uncertainty**2 for one in PROBLEM.targets])
    expected = [
        multivariate_normal.logpdf(
            [1.0, 2.0], mean, measured + between * np.sqrt(np.outer(error, error))
        )
        for mean, error in zip(MEANS, ERRORS, strict=True)
    ]
    found = Likelihood(PROBLEM).logarithms(MEANS, ERRORS, between)
    # But for a constant.
    assert np.diff(found) == pytest.approx(np.diff(expected))
