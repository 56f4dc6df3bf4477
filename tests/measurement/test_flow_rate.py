"""Mass flow from the mass in a container over time."""

from __future__ import annotations

import math

import numpy as np
import pytest

from grainfit.errors import NotMeasurableError
from grainfit.measurement import messages
from grainfit.measurement.flow_rate import discharge_time, flow_rate, stopped_flow
from grainfit.messages import Message


def emptied(rate: float, full: float = 2.0, residue: float = 0.2) -> tuple[np.ndarray, np.ndarray]:
    """A bed that flows at a constant rate until a residue is left, and then rests."""
    time = np.arange(0.0, 3.0, 0.004)
    return time + 7.0, np.maximum(full - rate * time, residue)


def test_constant_flow_is_its_slope_without_error() -> None:
    measured = flow_rate(*emptied(1.3))

    assert measured.value == pytest.approx(1.3, rel=1e-9)
    assert measured.standard_error < 1e-9
    # 10 and 50 % of the 1.8 kg that leave.
    assert measured.start == pytest.approx((7 + 0.18 / 1.3, 0.18))
    assert measured.end == pytest.approx((7 + 0.9 / 1.3, 0.9))


def test_a_discharge_has_ended_when_99_percent_of_what_leaves_has_left() -> None:
    time, mass = emptied(1.3)
    measured = discharge_time(time, mass, flow_rate(time, mass), 0.0)

    assert measured.value == pytest.approx(0.99 * 1.8 / 1.3, rel=1e-6)
    assert measured.standard_error < 1e-9
    # 13 g more or less that stay, at 1.3 kg/s.
    uncertain = discharge_time(time, mass, flow_rate(time, mass), 0.013)
    assert uncertain.standard_error == pytest.approx(0.01, rel=0.05)


def test_slow_start_and_end_do_not_count() -> None:
    time = np.arange(0.0, 6.0, 0.002)
    flow = np.where(time < 0.3, time / 0.3, 1.0) * np.where(time > 2.5, np.exp(2.5 - time), 1.0)
    mass = 5.0 - np.concatenate([[0.0], np.cumsum(flow[:-1] * np.diff(time))])

    assert flow_rate(time, mass).value == pytest.approx(1.0, rel=1e-3)


def test_flow_that_slowly_gets_less_is_no_error() -> None:
    time = np.arange(0.0, 4.0, 0.002)
    mass = 3.0 * np.exp(-time / 3)
    measured = flow_rate(time, mass)

    assert measured.standard_error < 0.03 * measured.value


def test_standard_error_is_the_scatter_between_beds() -> None:
    random = np.random.default_rng(3)
    found = []
    for _ in range(200):
        # Particles pass one by one, at random times.
        times = np.cumsum(random.exponential(0.001, 2000))
        time = np.arange(0.0, 2.5, 0.003)
        found.append(flow_rate(time, 2000.0 - np.searchsorted(times, time)))
    scatter = np.std([flow.value for flow in found])
    stated = math.sqrt(np.mean([flow.standard_error**2 for flow in found]))

    assert np.mean([flow.value for flow in found]) == pytest.approx(1000, rel=0.01)
    assert stated == pytest.approx(scatter, rel=0.2)


@pytest.mark.parametrize(
    ("time", "mass", "message"),
    [
        (np.array([0.0]), np.array([1.0]), messages.FEW_RECORDS),
        (np.array([]), np.array([]), messages.FEW_RECORDS),
        (np.arange(50.0), np.full(50, 2.0), messages.NO_FLOW),
        (np.arange(10.0), np.linspace(1, 0, 10), messages.SHORT_FLOW),
    ],
)
def test_series_without_a_flow_is_not_measurable(
    time: np.ndarray, mass: np.ndarray, message: Message
) -> None:
    with pytest.raises(NotMeasurableError, match=message.pattern):
        flow_rate(time, mass)


def test_an_arch_has_no_flow_and_the_mean_flow_as_its_error() -> None:
    time = np.linspace(3.0, 5.0, 50)
    half = stopped_flow(time, np.maximum(2.0 - 10 * (time - 3.0), 1.5), 0.001)
    assert (half.value, half.standard_error) == (0.0, pytest.approx(0.5 / 2))
    assert (half.start[1], half.end[1]) == (0.5, 0.5)

    # Nothing has left: one particle in that time would not have been noticed.
    none = stopped_flow(time, np.full(50, 2.0), 0.001)
    assert (none.value, none.standard_error) == (0.0, pytest.approx(0.001 / 2))
    with pytest.raises(NotMeasurableError, match=messages.FEW_RECORDS.pattern):
        stopped_flow(np.array([0.0]), np.array([1.0]), 0.001)
