"""Problems of known truth: the stated truth, reach and statistical limit are right."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from dataclasses import replace
from itertools import product
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import pytest

import grainfit as gf
from grainfit.errors import RunFailedError

BENCHMARKS = Path(__file__).parents[2] / "benchmarks"
NAMES = (
    *("two frictions", "exact line", "three decades", "eight over decades", "six correlated"),
    *("narrow tolerance", "corner", "failures", "curve and scalar"),
    *("student", "skewed", "some outliers", "noisy stripe", "half exact", "quantised"),
    *("threshold", "exact threshold", "onset", "exact onset", "step", "oblique threshold"),
    *("jams in a corner", "jams in half", "conflict", "beyond a cliff"),
    *("scatter of four tolerances", "edge of the tolerance"),
)
SEEDS = (1, 2, 3)


@pytest.fixture(scope="module")
def kinds() -> Iterator[ModuleType]:
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(sys, "path", [str(BENCHMARKS), *sys.path])
        import verdict_kinds

        yield verdict_kinds


def values_of(problem: Any, responses: dict[str, Any]) -> list[float]:
    found = [responses[target.name] for target in problem.targets]
    for curve in problem.curves:
        found += list(responses[curve.name].values)
    return found


def grid(dimension: int) -> np.ndarray[Any, Any]:
    """Points of the cube that contain its corners."""
    along = np.linspace(0.0, 1.0, {1: 2001, 2: 151}[dimension])
    return np.array(list(product(along, repeat=dimension)))


def test_all_kinds_are_here(kinds: ModuleType) -> None:
    assert tuple(kinds.KINDS) == NAMES


@pytest.mark.parametrize("name", NAMES)
def test_the_truth_meets_its_targets_or_no_point_of_the_box_does(
    kinds: ModuleType, name: str
) -> None:
    for seed in SEEDS:
        known = kinds.KINDS[name](seed)
        if known.is_reachable:
            assert known.tolerances_off(known.truth) <= 1.0 + 1e-9
            continue
        cloud = grid(known.problem.dimension)
        assert min(known.tolerances_off(known.problem.from_unit(at)) for at in cloud) > 1.2


def test_the_best_on_the_edge_is_exactly_one_tolerance_off(kinds: ModuleType) -> None:
    for seed in SEEDS:
        known = kinds.KINDS["edge of the tolerance"](seed)
        best = min(known.tolerances_off(known.problem.from_unit(at)) for at in grid(2))
        assert best == pytest.approx(1.0, abs=1e-9)


@pytest.mark.parametrize("name", NAMES)
def test_the_stated_expectation_is_the_mean_over_seeds(kinds: ModuleType, name: str) -> None:
    known, runs = kinds.KINDS[name](1), 3000
    dimension = known.problem.dimension
    cloud = np.random.default_rng(1).random((3, dimension))
    # The last point is where runs jam.
    for point in [*cloud, np.full(dimension, 0.8)]:
        at = known.problem.from_unit(point)
        try:
            simulated = np.array(
                [values_of(known.problem, known.simulate(at, seed)) for seed in range(runs)]
            )
        except RunFailedError:
            assert name == "failures"
            continue
        error = simulated.std(axis=0) / np.sqrt(runs) + 1e-9
        assert (np.abs(simulated.mean(axis=0) - known.expected(at)) < 4.5 * error).all()


def test_jams_fall_in_their_region_alone(kinds: ModuleType) -> None:
    known = kinds.KINDS["jams in a corner"](1)

    def lowest(x1: float, x2: float) -> float:
        at = {"x1": x1, "x2": x2}
        first = [known.simulate(at, seed)["y1"] for seed in range(300)]
        return float(np.median(first) - min(first))

    # Jams take 10 tolerances of 2; the scatter is half a tolerance.
    assert lowest(0.5, 0.9) < 5.0
    assert lowest(0.9, 0.5) < 5.0
    at = {"x1": 0.9, "x2": 0.9}
    assert np.std([known.simulate(at, seed)["y1"] for seed in range(300)]) > 8.0


def test_runs_fail_in_a_part_of_the_box_and_not_at_the_answer(kinds: ModuleType) -> None:
    for seed in SEEDS:
        known = kinds.KINDS["failures"](seed)
        failed = 0
        for point in np.random.default_rng(seed).random((1000, 2)):
            try:
                known.simulate(known.problem.from_unit(point), 1)
            except RunFailedError:
                failed += 1
        assert 150 < failed < 350
        known.simulate(dict(known.truth), 1)


def test_parameters_over_three_decades_have_a_logarithmic_scale(kinds: ModuleType) -> None:
    modulus = kinds.KINDS["three decades"](1).problem.parameters[0]
    assert modulus.scale == "log"
    assert modulus.maximum / modulus.minimum == pytest.approx(1e3)


def test_correlated_targets_are_also_met_together(kinds: ModuleType) -> None:
    known = kinds.KINDS["six correlated"](1)
    signs = np.array([1, -1] * 3)
    off = np.array(
        [t.value + 0.9 * s * t.tolerance for t, s in zip(known.problem.targets, signs, strict=True)]
    )
    apart = replace(known, expected=lambda _: off)
    assert not known.problem.is_met_by(apart.expected(known.truth))
    assert apart.tolerances_off(known.truth) > 1.0


def test_the_statistical_limit_is_that_of_students_distribution(kinds: ModuleType) -> None:
    """t(5) has its 97.5 % quantile at 2.571 < sqrt(7) and t(4) at 2.776 > sqrt(6)."""
    known = kinds.KINDS["step"](1)

    def scattering(parameters: dict[str, float], seed: int) -> dict[str, float]:
        noise = np.random.default_rng(seed).standard_normal()
        return {"y1": float(known.expected(parameters)[0] + 2.0 * noise)}

    assert replace(known, simulate=scattering).statistical_limit() == 7
    # Without scatter, three runs beyond those of the trend.
    assert kinds.KINDS["exact line"](1).statistical_limit() == 5
    assert kinds.KINDS["scatter of four tolerances"](1).statistical_limit() > 69
    assert kinds.KINDS["conflict"](1).statistical_limit() is None


@pytest.mark.parametrize("seed", [4, 14])
def test_an_answer_that_its_only_possible_run_does_not_confirm_is_left_for_another(
    kinds: ModuleType, seed: int
) -> None:
    # Without noise, more seeds at the first answer tell nothing.
    known = kinds.KINDS["exact threshold"](seed)
    result = gf.calibrate(known.problem, known.simulate, seed=seed, workers=1)
    assert result.status == "calibrated"
    assert known.tolerances_off(result.parameters) <= 1.0
