"""Runs that scatter about two values rather than one."""

import numpy as np

from grainfit.metamodels.two_states import has_two_states


def residuals(seed: int, apart: float, n: int = 40) -> np.ndarray:
    random = np.random.default_rng(seed)
    return apart * random.choice([-0.5, 0.5], n) + random.standard_normal(n)


def test_two_states_six_standard_deviations_apart_are_found() -> None:
    assert sum(has_two_states(residuals(seed, 6.0)) for seed in range(40)) >= 38


def test_one_state_hardly_ever_looks_like_two() -> None:
    # 0.5 %: 6 or more of 300 have a chance below 1 %.
    assert sum(has_two_states(residuals(seed, 0.0)) for seed in range(300)) <= 5


def test_few_or_equal_runs_say_nothing() -> None:
    assert not has_two_states(residuals(1, 6.0, n=19))
    assert not has_two_states(np.zeros(30))
