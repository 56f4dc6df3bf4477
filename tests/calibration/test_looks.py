"""Looking again and again at an answer just beyond its tolerance does not let it pass."""

import numpy as np
import pytest
from scipy.special import stdtr

from grainfit.verdict.looks import LOOKS, confidence_after

CASES = 20_000


def share_that_passes(looks: int, scatter: float, *, is_corrected: bool) -> float:
    """Share of answers up to a quarter beyond the edge that seem certain at one of the looks."""
    random = np.random.default_rng(39)
    runs, freedom = 2, 3
    truth = 1 + 0.25 * random.random(CASES)
    mean = truth + scatter * random.standard_normal(CASES) / np.sqrt(runs)
    squares = scatter**2 * random.chisquare(freedom, CASES)
    passed = np.zeros(CASES, dtype=bool)
    for _ in range(looks + 1):
        error = np.sqrt(squares / freedom / runs)
        inside = stdtr(freedom, (1 - mean) / error) - stdtr(freedom, (-1 - mean) / error)
        # Every look has the threshold of the last one.
        passed |= inside >= (confidence_after(looks, 0.95) if is_corrected else 0.95)
        value = truth + scatter * random.standard_normal(CASES)
        squares += (value - mean) ** 2 * runs / (runs + 1)
        mean = (runs * mean + value) / (runs + 1)
        runs, freedom = runs + 1, freedom + 1
    return float(passed.mean())


@pytest.mark.parametrize("looks", [0, 3, 12, 30])
@pytest.mark.parametrize("scatter", [0.3, 0.7])
def test_five_percent_of_answers_just_beyond_pass_however_often_one_looks(
    looks: int, scatter: float
) -> None:
    # 0.05 with four standard errors of the count.
    assert share_that_passes(looks, scatter, is_corrected=True) < 0.0562


def test_without_it_more_pass() -> None:
    assert share_that_passes(30, 0.7, is_corrected=False) > 0.08


def test_more_looks_leave_less_doubt() -> None:
    found = [confidence_after(looks, 0.95) for looks in (*LOOKS, 200)]
    assert found[0] == 0.95
    assert found == sorted(found)
    assert confidence_after(4, 0.99) > 0.99
