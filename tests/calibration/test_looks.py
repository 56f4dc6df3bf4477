"""Looking again and again at an answer just beyond its tolerance does not let it pass."""

import sys
from pathlib import Path

import pytest

from grainfit.verdict.looks import LOOKS, confidence_after

BENCHMARKS = Path(__file__).parents[2] / "benchmarks"
CASES, BEYOND = 20_000, 0.25


def share_that_passes(looks: int, scatter: float, *, is_corrected: bool) -> float:
    """Share of answers up to a quarter beyond the edge that seem certain at one of the looks."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(sys, "path", [str(BENCHMARKS), *sys.path])
        from stopping import smallest_doubts
    doubts = smallest_doubts(scatter, (2, 3), looks, CASES, BEYOND)[-1]
    # Every look has the threshold of the last one.
    demanded = confidence_after(looks, 0.95) if is_corrected else 0.95
    return float((doubts <= 1 - demanded).mean())


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
