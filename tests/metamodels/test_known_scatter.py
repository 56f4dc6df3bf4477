"""Scatter that is known before the runs: worth five of them, unless they contradict it."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

import grainfit as gf
from grainfit.calibration.runs_to_come import with_recorded_scatters
from grainfit.metamodels.kriging import Kriging

SCATTER = 0.5


def runs(seed: int) -> tuple[np.ndarray, np.ndarray]:
    random = np.random.default_rng(seed)
    points = random.random((9, 1))
    points[:3] = 0.6
    return points, 4.0 * points[:, 0] + SCATTER * random.standard_normal(9)


def at_answer(known_scatter: float) -> tuple[np.ndarray, float]:
    """Standard errors at an answer, and the share of 95 % intervals that hold the truth."""
    found = [
        Kriging.fit(*runs(seed), known_scatter=known_scatter).predict([[0.6]])
        for seed in range(150)
    ]
    errors = np.array([one.standard_error[0] for one in found])
    off = np.array([one.mean[0] for one in found]) - 2.4
    return errors, float((np.abs(off) <= 1.96 * errors).mean())


def test_a_scatter_that_is_right_makes_intervals_narrower_that_hold_as_often() -> None:
    (without, _), (errors, held) = at_answer(0.0), at_answer(SCATTER)
    assert np.quantile(errors, 0.9) < 0.93 * np.quantile(without, 0.9)
    assert held > 0.91


@pytest.mark.parametrize("factor", [0.5, pytest.param(2.0, marks=pytest.mark.thorough)])
def test_a_scatter_that_is_wrong_by_a_factor_of_two_hardly_costs_coverage(factor: float) -> None:
    assert at_answer(factor * SCATTER)[1] > 0.9


def test_a_scatter_that_the_runs_contradict_changes_nothing() -> None:
    for factor in (0.1, 10.0):
        contradicted = Kriging.fit(*runs(1), known_scatter=factor * SCATTER)
        assert contradicted.to_plain() == Kriging.fit(*runs(1)).to_plain()


def test_the_recorded_scatter_of_a_bulk_test_is_known() -> None:
    angle = gf.Target("angle_of_repose", "22 deg", tolerance="1 deg")
    heap = gf.tests.Heap
    problem = gf.Problem([gf.Parameter("particle_particle.rolling_friction", 0.1, 0.4)], [angle])
    material = {"particle.density": 2500.0}
    solver = gf.solvers.Lammps(heap(diameter=0.01), material)
    known = with_recorded_scatters(problem, {"heap": solver}, {"heap": 4})
    recorded = heap.responses["angle_of_repose"].trials.scatter
    assert known.scatters == {"angle_of_repose": pytest.approx(22.0 * recorded / 2)}


def test_a_calibration_says_what_is_known_and_keeps_it(tmp_path: Path) -> None:
    problem = gf.Problem(
        [gf.Parameter("friction", 0.1, 0.9)],
        [gf.Target("angle", "30 deg", tolerance="1 deg")],
        scatters={"angle": 0.5},
    )

    def simulate(values: dict[str, float], seed: int) -> dict[str, float]:
        scatter = 0.5 * float(np.random.default_rng(seed).standard_normal())
        return {"angle": 10 + 40 * values["friction"] + scatter}

    result = gf.calibrate(problem, simulate, workdir=tmp_path / "known.grainfit")
    assert result.status == "calibrated"
    assert sum("that of 5 more" in notice and "angle 0.5°" in notice for notice in result.notices)
    assert gf.open(tmp_path / "known.grainfit").problem.scatters == {"angle": 0.5}


@pytest.mark.parametrize("given", [0.0, -1.0, math.inf, "much"])
def test_a_known_scatter_is_above_zero(given: object) -> None:
    with pytest.raises(gf.InputError, match=r"scatters\.angle"):
        gf.Problem(
            [gf.Parameter("friction", 0.1, 0.9)],
            [gf.Target("angle", 30.0)],
            scatters={"angle": given},  # type: ignore[dict-item]
        )
