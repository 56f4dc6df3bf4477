"""A parameter with a measurement of its own: its value, and the uncertainty that it passes on."""

from pathlib import Path

import numpy as np
import pytest

import grainfit as gf
from grainfit.result import Result

WALL = "particle_wall.sliding_friction"
MEASURED = gf.Parameter.from_angle(WALL, "21.8 deg", "0.5 deg")
OTHER = gf.Parameter("x", 0.0, 10.0)


def calibrated(
    folder: Path, wall_effect: float, target: float, tolerance: float, strategy="sequential"
) -> tuple[Result, gf.Analysis]:
    """Responses x + effect * friction, and, with an effect, a second one of friction alone."""
    targets = [gf.Target("sum", target, tolerance=tolerance)]
    problem = gf.Problem([OTHER, MEASURED], targets)

    def simulate(values, seed):
        noise = np.random.default_rng(seed).normal(0, 0.003)
        return {"sum": values["x"] + wall_effect * values[WALL] + noise}

    result = gf.calibrate(problem, simulate, workdir=folder, seed=3, strategy=strategy)
    return result, gf.open(folder).analyse()


def off(result: Result) -> float:
    """Deviation of the answer from the measurement, in standard uncertainties."""
    return (result.parameters[WALL] - MEASURED.measured) / MEASURED.uncertainty


@pytest.fixture(scope="module")
def uncontradicted(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Work folder of a calibration whose response does not depend on the measured parameter."""
    folder = tmp_path_factory.mktemp("measured") / "w"
    calibrated(folder, 0.0, 5.0, 0.05)
    return folder


def test_the_answer_keeps_the_measured_value_that_nothing_contradicts(uncontradicted: Path) -> None:
    result = gf.open(uncontradicted).result

    assert result.status == "calibrated"
    assert abs(off(result)) < 0.05


def test_so_does_that_of_the_staged_strategy(tmp_path: Path) -> None:
    result, _ = calibrated(tmp_path / "w", 0.0, 5.0, 0.05, "staged")

    assert result.status == "calibrated"
    assert abs(off(result)) < 0.05


def test_the_stated_interval_is_that_of_the_measurement(uncontradicted: Path) -> None:
    analysis = gf.open(uncontradicted).analyse()
    found = analysis.intervals[WALL]

    assert found.low == pytest.approx(0.4 - 1.96 * MEASURED.uncertainty, abs=0.002)
    assert found.high == pytest.approx(0.4 + 1.96 * MEASURED.uncertainty, abs=0.002)
    assert found.determination == "determined"
    words = " ".join(analysis.identifiability.verdicts)
    assert f"{WALL} is known from its own measurement: 0.38" in words
    assert WALL not in " ".join(analysis.identifiability.further_tests)


def test_card_and_report_say_that_it_was_measured(uncontradicted: Path, tmp_path: Path) -> None:
    saved = gf.open(uncontradicted)
    (parameter,) = (p for p in saved.card().parameters if p.name == WALL)
    page = saved.report(tmp_path / "report.html").read_text(encoding="utf-8")

    assert parameter.origin == "measured"
    assert parameter.interval == pytest.approx((0.38, 0.42), abs=0.002)
    assert "measured 0.4 ± 0.0101" in page


def test_its_uncertainty_is_part_of_the_interval_of_another_parameter(tmp_path: Path) -> None:
    _, analysis = calibrated(tmp_path / "w", 20.0, 13.0, 0.05)
    found = analysis.intervals["x"]

    # x = 13 - 20 friction: 0.2 from friction, 0.0255 from the target.
    half = 1.96 * np.hypot(20 * MEASURED.uncertainty, 0.05 / 1.96)
    assert (found.high - found.low) / 2 == pytest.approx(half, rel=0.12)


def test_a_test_that_knows_better_moves_it(tmp_path: Path) -> None:
    # A test with a tenth of the uncertainty says 0.42, two standard uncertainties off.
    targets = [gf.Target("y", 0.42 * 100, uncertainty=0.1)]
    problem = gf.Problem([MEASURED], targets)

    def simulate(values, seed):
        return {"y": 100 * values[WALL] + np.random.default_rng(seed).normal(0, 0.02)}

    result = gf.calibrate(problem, simulate, workdir=tmp_path / "w", seed=3)

    # The mean of both measurements, weighted by their precisions.
    weights = np.array([1 / MEASURED.uncertainty**2, 1 / 0.001**2])
    mean = weights @ [MEASURED.measured, 0.42] / weights.sum()
    assert result.parameters[WALL] == pytest.approx(mean, abs=3e-4)
