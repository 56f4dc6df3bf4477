"""A parameter with a measurement of its own: its value, and the uncertainty that it passes on."""

from pathlib import Path

import numpy as np
import pytest

import grainfit as gf
from grainfit.analysis import messages as of_analysis
from grainfit.result import Result

WALL = "particle_wall.sliding_friction"
MEASURED = gf.Parameter.from_angle(WALL, "21.8 deg", "0.5 deg")
OTHER = gf.Parameter("x", 0.0, 10.0)


def off(result: Result) -> float:
    """Deviation of the answer from the measurement, in standard uncertainties."""
    return (result.parameters[WALL] - MEASURED.measured) / MEASURED.uncertainty


@pytest.fixture(scope="module")
def uncontradicted(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Work folder of a calibration whose response does not depend on the measured parameter."""
    folder = tmp_path_factory.mktemp("measured") / "w"
    problem = gf.Problem([OTHER, MEASURED], [gf.Target("y", 5.0, tolerance=0.05)])

    def simulate(values, seed):
        return {"y": values["x"] + np.random.default_rng(seed).normal(0, 0.003)}

    gf.calibrate(problem, simulate, workdir=folder, seed=3)
    return folder


def test_the_answer_keeps_the_measured_value_that_nothing_contradicts(uncontradicted: Path) -> None:
    result = gf.open(uncontradicted).result

    assert result.status == "calibrated"
    assert abs(off(result)) < 0.05


def test_the_stated_interval_is_that_of_the_measurement(uncontradicted: Path) -> None:
    analysis = gf.open(uncontradicted).analyse()
    found = analysis.intervals[WALL]

    assert found.low == pytest.approx(0.4 - 1.96 * MEASURED.uncertainty, abs=0.002)
    assert found.high == pytest.approx(0.4 + 1.96 * MEASURED.uncertainty, abs=0.002)
    assert found.determination == "determined"
    words = " ".join(analysis.identifiability.verdicts)
    assert of_analysis.KNOWN_BY_ITSELF.is_in(words, name=WALL)
    assert "measurement: 0.38" in words
    assert WALL not in " ".join(analysis.identifiability.further_tests)


def test_card_and_report_say_that_it_was_measured(uncontradicted: Path, tmp_path: Path) -> None:
    saved = gf.open(uncontradicted)
    (parameter,) = (p for p in saved.card().parameters if p.name == WALL)
    page = saved.report(tmp_path / "report.html").read_text(encoding="utf-8")

    assert parameter.origin == "measured"
    assert parameter.interval == pytest.approx((0.38, 0.42), abs=0.002)
    assert "measured 0.4 ± 0.0101" in page


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
