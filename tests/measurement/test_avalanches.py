"""Standard errors of series that avalanches interrupt."""

from __future__ import annotations

import numpy as np
import pytest

from grainfit.errors import NotMeasurableError
from grainfit.measurement import messages
from grainfit.measurement.avalanches import whole_avalanches


def sawtooth(random: np.random.Generator, length: int = 108) -> np.ndarray:
    """Return a series that rises slowly and falls at once, by a random amount about 36."""
    values, level = [], 36.0
    target = level + random.uniform(1, 5)
    while len(values) < length + 40:
        level += 0.4
        if level > target:
            level = 36.0 - random.uniform(1, 5)
            target = 36.0 + random.uniform(1, 5)
        values.append(level)
    start = int(random.integers(0, 40))
    return np.array(values[start : start + length]) + random.normal(0, 0.05, length)


def test_avalanches_begin_where_the_series_rises_through_its_mean() -> None:
    series = 36 + 3 * np.sin(np.arange(100) * 2 * np.pi / 20 + 0.1)
    found = whole_avalanches(series)

    assert found.bounds == (20, 40, 60, 80)
    assert len(found) == 3
    assert found.means(series) == pytest.approx([36.0] * 3, abs=1e-9)


def test_noise_about_the_mean_is_no_avalanche() -> None:
    random = np.random.default_rng(4)
    series = 36 + 3 * np.sin(np.arange(100) * 2 * np.pi / 20) + random.normal(0, 0.2, 100)

    assert len(whole_avalanches(series)) in (3, 4)


def test_the_standard_error_is_the_scatter_of_the_mean() -> None:
    random = np.random.default_rng(1)
    means, errors = [], []
    for _ in range(400):
        series = sawtooth(random)
        found = whole_avalanches(series)
        means.append(series.mean())
        errors.append(found.standard_error(found.means(series)))
    stated = np.sqrt(np.mean(np.square(errors)))

    assert np.std(means) == pytest.approx(stated, rel=0.2)


def test_a_drift_is_told_from_avalanches() -> None:
    random = np.random.default_rng(2)
    steady = sawtooth(random, 216)
    drifting = steady + np.linspace(-4, 4, 216)
    found = [whole_avalanches(series).drift(series) for series in (steady, drifting)]

    assert abs(found[0].value) < 3 * found[0].standard_error
    assert found[1].value == pytest.approx(4, abs=1)
    assert found[1].value > 3 * found[1].standard_error


@pytest.mark.parametrize("series", [np.linspace(30, 40, 100), np.full(50, 36.0)])
def test_a_series_without_avalanches_is_refused(series: np.ndarray) -> None:
    with pytest.raises(NotMeasurableError, match=messages.FEW_AVALANCHES(found=0, needed=3)):
        whole_avalanches(series)
