"""Correlated targets of one test: misfit, verdict, posterior, file and faults."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import grainfit as gf
from grainfit.analysis.posterior import sample_posterior
from grainfit.calibration_file.build import load_calibration
from grainfit.calibration_file.plan import describe_plan
from grainfit.metamodels.metamodels import Metamodels
from grainfit.metamodels.unit_cube import gauss_newton
from grainfit.problem import messages as of_problem
from grainfit.problem.correlations import correlated_groups, correlation_matrix
from grainfit.strategies.sequential.knowledge_gradient import KnowledgeGradient, _normal_outcomes
from grainfit.strategies.staged.least_squares import _jacobian
from grainfit.strategies.staged.residuals import residuals, residuals_at
from grainfit.verdict.reasons import NotTogether

MODEL = """\
import random

def shear(parameters, seed):
    x = parameters["x"]
    scatter = random.Random(seed)
    return {
        "peak": 1 + x + scatter.gauss(0, 0.001),
        "residual": 1 + x + scatter.gauss(0, 0.001),
        "density": 3 - x + scatter.gauss(0, 0.001),
    }
"""
FILE = """\
name = "shear"
[parameters]
x = { min = 0, max = 1 }
[[test]]
type = "python"
function = "model.py:shear"
targets.peak = { value = 1.5, uncertainty = 0.01 }
targets.residual = { value = 1.515, uncertainty = 0.01 }
correlations = [["peak", "residual", 0.9]]
[strategy]
workers = 1
max_runs = 20
"""


@pytest.fixture
def file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    (tmp_path / "model.py").write_text(MODEL)
    path = tmp_path / "shear.toml"
    path.write_text(FILE)
    monkeypatch.chdir(tmp_path)
    return path


def problem(
    coefficient: float = 0.9,
    values: tuple[float, float] = (1.5, 1.5),
    x: gf.Parameter = gf.Parameter("x", 0.0, 1.0),  # noqa: B008
) -> gf.Problem:
    return gf.Problem(
        [x],
        [gf.Target("a", values[0], 0.02), gf.Target("b", values[1], 0.02)],
        correlations=[("a", "b", coefficient)] if coefficient else (),
    )


def metamodels_of(wanted: gf.Problem, noise: float = 1e-4) -> Metamodels:
    """Metamodels of two responses that are both 1 + x."""
    random = np.random.default_rng(5)
    evaluations = [
        gf.Evaluation.of(
            gf.Proposal({"x": float(x)}, seed, "design"),
            {name: 1.0 + x + random.normal(0, noise) for name in "ab"},
        )
        for seed, x in enumerate(np.linspace(0.0, 1.0, 12), start=1)
    ]
    return Metamodels.fit(wanted, evaluations)


@pytest.mark.parametrize("coefficient", [0.0, 0.9, -0.6])
def test_the_posterior_has_the_width_of_generalised_least_squares(coefficient: float) -> None:
    posterior = sample_posterior(metamodels_of(problem(coefficient)), seed=2)
    # The variance of the mean of two values with equal uncertainty u is u² (1 + ρ) / 2.
    wanted = 0.02 * np.sqrt((1 + coefficient) / 2)
    assert np.std(posterior.values[:, 0]) == pytest.approx(wanted, rel=0.08)
    assert posterior.median("x") == pytest.approx(0.5, abs=0.2 * wanted)


def test_the_misfit_is_that_of_mahalanobis_with_the_variances() -> None:
    metamodels = metamodels_of(problem(0.9, (1.4, 1.5)))
    points = np.linspace(0.0, 1.0, 5)[:, None]
    means, variances = metamodels.deviations(points)
    precision = np.linalg.inv([[1.0, 0.9], [0.9, 1.0]])
    for point, mean, variance in zip(points, means, variances, strict=True):
        wanted = mean @ precision @ mean + np.trace(precision @ np.diag(variance))
        assert metamodels.misfit(point[None])[0] == pytest.approx(wanted)
        # A run there tells the knowledge gradient as much.
        at_one = KnowledgeGradient(metamodels, point[None], np.zeros(1))
        slope = metamodels.slopes(point[None])[0]
        stiffness = np.linalg.inv(precision) + 0.05**2 * slope @ slope.T
        followed = mean @ np.linalg.inv(stiffness) @ mean + np.trace(precision @ np.diag(variance))
        assert at_one.smallest_misfit == pytest.approx(followed)


def test_a_run_of_one_test_tells_the_knowledge_gradient_of_its_targets_only() -> None:
    metamodels = metamodels_of(problem(-0.6, (1.4, 1.5)), noise=0.01)
    point = np.array([[0.45]])
    covariance, variance = metamodels.covariance_with(point)(point)
    learnt = covariance[:, 0, 0] / np.sqrt(variance[:, 0] + metamodels.scatter_at(point)[0])
    slope = metamodels.slopes(point)[0]
    followed = np.linalg.inv([[1.0, -0.6], [-0.6, 1.0]] + 0.05**2 * slope @ slope.T)
    precision = 1 / (1 - 0.6**2)
    gain = KnowledgeGradient(metamodels, point, np.zeros(1))
    squares = (_normal_outcomes(2) ** 2).mean(axis=0)
    for number, yields in enumerate([[True, False], [False, True]]):
        wanted = learnt[number] ** 2 * (precision - followed[number, number] * squares[number])
        assert wanted > 0
        assert gain(point, np.array(yields))[0] == pytest.approx(wanted)
    assert gain(point, np.array([True, True]))[0] == gain(point)[0]


def test_the_closest_point_is_that_of_generalised_least_squares() -> None:
    wanted = gf.Problem(
        [gf.Parameter("x", 0.0, 1.0)],
        [gf.Target("a", 1.4, 0.02), gf.Target("b", 1.5, 0.01)],
        correlations=[("a", "b", 0.9)],
    )
    covariance = np.array([[4.0, 1.8], [1.8, 1.0]])
    weights = np.linalg.solve(covariance, np.ones(2))
    # Outside both values: the common error moves the less certain one farther.
    best = weights @ [0.4, 0.5] / weights.sum()
    assert best > 0.55
    found = gauss_newton(metamodels_of(wanted), np.array([[0.1], [0.9]]))
    assert found[:, 0] == pytest.approx([best, best], abs=0.005)


def test_a_measurement_of_the_parameter_itself_counts_beside_correlated_targets() -> None:
    measured = gf.Parameter("x", 0.0, 1.0, measured=0.53, uncertainty=0.02)
    metamodels = metamodels_of(problem(0.9, x=measured))
    precisions = np.array([1 / (0.02**2 * (1 + 0.9) / 2), 1 / 0.02**2])
    best = precisions @ [0.5, 0.53] / precisions.sum()
    posterior = sample_posterior(metamodels, seed=2)
    assert posterior.values.mean() == pytest.approx(best, abs=0.002)
    assert np.std(posterior.values) == pytest.approx(precisions.sum() ** -0.5, rel=0.08)
    points = np.array([[0.1], [0.9]])
    assert gauss_newton(metamodels, points)[:, 0] == pytest.approx([best, best], abs=0.002)
    alone = metamodels_of(problem(0.9)).misfit(points)
    assert metamodels.misfit(points) - alone == pytest.approx([21.5**2, 18.5**2])


def test_the_staged_residuals_of_a_measured_parameter_are_not_mixed_with_the_targets() -> None:
    measured = gf.Parameter("x", 0.0, 1.0, measured=0.53, uncertainty=0.02)
    both, alone = (
        residuals(known, {"x": 0.5}, np.array([1.6, 1.5]))
        for known in (problem(0.9, x=measured), problem(0.9))
    )
    assert both.tolist() == [*alone, pytest.approx(-1.5 * 0.02 / 0.53)]
    # The parameter is held to its own value in the slopes as well.
    metamodels = metamodels_of(problem(0.9, x=measured))
    h = 1e-6
    low, high = (residuals_at(metamodels, np.array([u])) for u in (0.4 - h, 0.4 + h))
    slopes = _jacobian(metamodels, np.array([0.4]))[:, 0]
    assert slopes == pytest.approx((high - low) / (2 * h), rel=1e-4)


def test_the_staged_residuals_have_the_same_misfit() -> None:
    wanted = problem(0.9, (1.4, 1.5))
    found = residuals(wanted, {"x": 0.5}, np.array([1.5, 1.5]))[:2]
    off = np.array([(1.5 - 1.4) / 1.4, 0.0])
    assert found @ found == pytest.approx(off @ np.linalg.inv([[1, 0.9], [0.9, 1]]) @ off)


def test_correlated_targets_are_met_together_with_the_share_of_random_outcomes() -> None:
    metamodels = metamodels_of(problem(0.9))
    means, variances = np.array([[1.505, 1.49]]), np.array([[8e-5, 5e-5]])
    found = metamodels._probability(means, variances)[0]
    random = np.random.default_rng(1)
    off = (random.normal(means, np.sqrt(variances), (200_000, 2)) - 1.5) / 0.02
    precision = np.linalg.inv([[1.0, 0.9], [0.9, 1.0]])
    met = (np.abs(off) <= 1).all(axis=1)
    together = met & (np.einsum("si,ij,sj->s", off, precision, off) <= 2)
    assert found == pytest.approx(together.mean(), abs=0.01)
    assert found < 0.7 * met.mean(), "each alone is met far more often"
    without = metamodels_of(problem(0.0))._probability(means, variances)[0]
    assert without == pytest.approx(met.mean(), abs=0.01)


def test_both_errors_in_the_same_direction_meet_correlated_targets_and_opposite_ones_do_not() -> (
    None
):
    wanted = problem(0.9)
    assert wanted.is_met_by([1.515, 1.515])
    assert not wanted.is_met_by([1.515, 1.485])
    assert not wanted.is_met_by([1.525, 1.525])
    assert problem(0.0).is_met_by([1.515, 1.485])


def test_targets_that_contradict_their_common_error_are_not_met(file: Path) -> None:
    together = gf.load(file).calibrate()
    assert together.status in ("out_of_tolerance", "undecided")
    assert {found.verdict for found in together.responses.values()} == {"met"}
    assert NotTogether(("peak", "residual")) in together.reasons
    saved = gf.open("shear.grainfit")
    assert saved.problem.correlations == (("peak", "residual", 0.9),)


def test_without_the_correlation_the_same_targets_are_met(file: Path) -> None:
    file.write_text(FILE.replace('correlations = [["peak", "residual", 0.9]]\n', ""))
    alone = gf.load(file).calibrate()
    assert alone.status == "calibrated"
    assert alone.parameters["x"] == pytest.approx(0.5075, abs=0.003)


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ('[["peak", "residul", 0.9]]', "correlations[0]: 'residul' has no target here."),
        ('[["peak", "peak", 0.9]]', "correlations[0]: names 'peak' twice."),
        ('[["peak", "residual", 1.5]]', "coefficient 1.5. It must be above -1"),
        ('[["peak", "residual", 1]]', "coefficient 1.0. It must be above -1 and below 1."),
        ('[["peak", "residual"]]', 'Write ["first", "second", 0.8].'),
        ('[["peak", "residual", 0.9], ["residual", "peak", 0.8]]', "second coefficient"),
        (
            '[["peak", "residual", 0.9], ["peak", "density", 0.9], ["residual", "density", -0.9]]',
            "contradict each other: their matrix has the eigenvalue -0.8",
        ),
    ],
)
def test_faults_name_the_pair_and_the_remedy(file: Path, given: str, words: str) -> None:
    text = FILE.replace('[["peak", "residual", 0.9]]', given)
    more = "targets.density = { value = 2.5, uncertainty = 0.01 }\ncorrelations"
    file.write_text(text.replace("correlations", more, 1))
    with pytest.raises(gf.InputError) as caught:
        gf.load(file)
    assert words in str(caught.value)
    assert "line 10" in str(caught.value)


def test_plan_shows_correlations(file: Path) -> None:
    lines = describe_plan(load_calibration(file)).lines
    assert lines[0] == "Correlations of the errors of the measured values: peak and residual 0.9."
    file.write_text(FILE.replace('correlations = [["peak", "residual", 0.9]]\n', ""))
    assert not any("Correlations" in line for line in describe_plan(load_calibration(file)).lines)


def test_faults_in_python() -> None:
    with pytest.raises(
        gf.InputError, match=rf"correlations\[0\]: {of_problem.NO_TARGET_HERE.matching(name='c')}"
    ):
        gf.Problem(problem().parameters, problem().targets, correlations=[("a", "c", 0.5)])
    with pytest.raises(gf.InputError, match="Give triples"):
        gf.Problem(problem().parameters, problem().targets, correlations=[("a", "b")])  # type: ignore[list-item]
    for covariance, words in (
        ([[1.0, 0.5]], "shape"),
        ([[1.0, 0.5], [0.4, 1.0]], "not symmetric"),
        ([[1.0, 2.0], [2.0, 1.0]], "coefficient"),
        ([[0.0, 0.0], [0.0, 1.0]], "above 0"),
    ):
        with pytest.raises(gf.InputError, match=words):
            problem().with_covariance(covariance)


def test_a_covariance_sets_uncertainties_and_correlations() -> None:
    found = problem(0.0).with_covariance([[0.0004, -0.0001], [-0.0001, 0.0001]])
    assert [target.uncertainty for target in found.targets] == pytest.approx([0.02, 0.01])
    assert [target.tolerance for target in found.targets] == pytest.approx([0.02, 0.01])
    assert found.correlations == (("a", "b", pytest.approx(-0.5)),)
    assert found.with_targets(found.targets[:1]).correlations == ()


def test_groups_hold_what_is_correlated_through_others() -> None:
    matrix = correlation_matrix("abcde", [("a", "c", 0.5), ("c", "d", 0.5)])
    assert [group.tolist() for group in correlated_groups(matrix)] == [[0, 2, 3]]
    assert correlated_groups(np.eye(3)) == []
