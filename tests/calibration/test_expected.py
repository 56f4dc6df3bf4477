"""A search that begins where the answer is expected."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np
import pytest

import grainfit as gf
from grainfit.strategies.sequential.strategy import Sequential

PARAMETERS = [gf.Parameter("friction", 0.1, 0.9), gf.Parameter("rolling", 0.0, 1.0)]
TARGETS = [gf.Target("angle", 26.0, uncertainty=0.5), gf.Target("flow", 1.4, uncertainty="2 %")]
RIGHT = {"friction": (0.3, 0.5), "rolling": (0.2, 0.45)}
WRONG = {"friction": (0.7, 0.9), "rolling": (0.8, 1.0)}


def _heap(parameters: Mapping[str, float], seed: int) -> dict[str, float]:
    noise = np.random.default_rng(seed).standard_normal(2)
    friction, rolling = parameters["friction"], parameters["rolling"]
    return {
        "angle": 14 + 22 * friction + 10 * rolling + 0.3 * noise[0],
        "flow": 2 - 1.5 * friction + 0.1 * noise[1] / 5,
    }


@pytest.mark.parametrize("expected", [RIGHT, WRONG])
def test_the_first_runs_lie_where_the_answer_is_expected(
    expected: Mapping[str, tuple[float, float]],
) -> None:
    problem = gf.Problem(PARAMETERS, TARGETS, expected=expected)
    search = Sequential().start(problem, 1)

    for _ in range(search.design_runs):
        proposal = search.ask()
        assert proposal is not None
        for name, (low, high) in expected.items():
            assert low <= proposal.parameters[name] <= high


def test_a_wrong_expectation_costs_few_runs_and_no_truth() -> None:
    runs = {}
    for name, expected in {"none": {}, "right": RIGHT, "wrong": WRONG}.items():
        problem = gf.Problem(PARAMETERS, TARGETS, expected=expected)
        results = [gf.calibrate(problem, _heap, seed=seed) for seed in (1, 2)]
        assert [result.status for result in results] == ["calibrated"] * 2
        for result in results:
            assert result.parameters["friction"] == pytest.approx(0.4, abs=0.05)
        runs[name] = np.mean([result.runs.total for result in results])

    assert runs["right"] <= runs["none"] + 1
    assert runs["wrong"] <= runs["none"] + 4


def test_a_calibration_with_another_expectation_is_another_one(tmp_path: Path) -> None:
    folder = tmp_path / "work"
    identities = {
        gf.calibrate(
            gf.Problem(PARAMETERS, TARGETS, expected=expected), _heap, workdir=folder, max_runs=12
        ).identity
        for expected in ({}, RIGHT, RIGHT)
    }

    assert len(identities) == 2
