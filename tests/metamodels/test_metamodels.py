"""Metamodels of several responses: deviations, and probabilities against closed forms."""

import numpy as np
import pytest
from scipy.stats import norm

from grainfit.errors import RunFailedError
from grainfit.evaluation import Evaluation, Proposal, Response
from grainfit.metamodels.kriging import Kriging
from grainfit.metamodels.metamodels import Metamodels, can_be_fitted
from grainfit.metamodels.prediction import Prediction
from grainfit.problem import Parameter, Problem, Target

PROBLEM = Problem(
    [Parameter("x", 0.0, 1.0)],
    [Target("first", 10.0, tolerance=0.5), Target("second", 20.0, tolerance=2.0, weight=0.5)],
)


class Known(Kriging):
    """A metamodel whose expected response is the same everywhere."""

    def __init__(self, mean: float, error: float, noise: float = 1.0) -> None:
        self._known = mean, error**2
        self._scatter = noise
        self.scatter = None

    def predict(self, points) -> Prediction:
        mean, variance = (np.full(len(points), value) for value in self._known)
        return Prediction(mean, variance, variance + self._scatter**2)

    @property
    def n(self) -> int:
        # So many that the tolerance alone is the unit of the deviations.
        return 10**12

    @property
    def variance_of_scatter(self) -> float:
        return self._scatter**2

    def share_below(self, deviations) -> np.ndarray:
        return norm.cdf(deviations)

    def gradients(self, points) -> np.ndarray:
        return np.full((len(points), 1), 3.0)


def inside(off: float, tolerance: float, error: float) -> float:
    """Probability that a normal variate is within a tolerance."""
    return float(norm.cdf(tolerance, off, error) - norm.cdf(-tolerance, off, error))


def evaluation(x: float, **responses: float) -> Evaluation:
    failures = {} if responses else {"heap": "it blew up"}
    values = {name: Response(value) for name, value in responses.items()}
    return Evaluation(Proposal({"x": x}, 1, "design"), values, failures)


@pytest.mark.parametrize(("off", "error"), [(0.0, 0.3), (0.4, 0.1), (0.6, 0.5), (-5.0, 1.0)])
def test_agreement_is_the_product_of_normal_probabilities(off: float, error: float) -> None:
    known = Metamodels(PROBLEM, [Known(10.0 + off, error), Known(21.0, 0.8)])
    wanted = inside(off, 0.5, error) * inside(1.0, 2.0, 0.8)
    assert known.probability_all_met([[0.2], [0.7]]) == pytest.approx(
        [wanted] * 2, rel=1e-9, abs=1e-12
    )


def test_agreement_of_what_is_known_exactly_is_yes_or_no() -> None:
    exact = [Metamodels(PROBLEM, [Known(mean, 0.0), Known(20.0, 0.0)]) for mean in (10.4, 10.6)]
    assert [m.probability_all_met([[0.5]])[0] for m in exact] == pytest.approx([1.0, 0.0])


def test_deviations_are_in_tolerances_times_weights() -> None:
    known = Metamodels(PROBLEM, [Known(11.0, 0.25), Known(16.0, 1.0, noise=4.0)])
    means, variances = known.deviations([[0.5]])
    assert means[0] == pytest.approx([2.0, -1.0])
    assert variances[0] == pytest.approx([0.25, 0.0625])
    assert known.misfit([[0.5]]) == pytest.approx([4.0 + 0.25 + 1.0 + 0.0625])
    assert known.scatter_at([[0.5]])[0] == pytest.approx([4.0, 1.0])
    assert known.slopes([[0.5]])[0, :, 0] == pytest.approx([6.0, 0.75])


@pytest.mark.parametrize(("error", "noise"), [(0.3, 1.0), (1.0, 1.0), (1.0, 5.0)])
def test_runs_needed_is_what_narrows_the_standard_error_enough(error: float, noise: float) -> None:
    # The mean meets the target; n runs leave 1 / (1 / error^2 + n / noise^2) of variance, and
    # 1.96 standard errors have to be within the tolerance.
    problem = Problem(PROBLEM.parameters, PROBLEM.targets[:1])
    wanted = (1.959964 / 0.5) ** 2 * noise**2 - noise**2 / error**2
    found = Metamodels(problem, [Known(10.0, error, noise)]).runs_needed(np.array([0.5]), 0.95)
    # The counts that are tried are 3.5 % apart.
    assert wanted <= found <= 1.05 * wanted + 1


def test_runs_needed_says_one_where_it_is_decided_and_a_million_where_it_is_hopeless() -> None:
    problem = Problem(PROBLEM.parameters, PROBLEM.targets[:1])
    at = np.array([0.5])
    assert Metamodels(problem, [Known(10.0, 0.01)]).runs_needed(at, 0.95) == 1
    assert Metamodels(problem, [Known(10.0, 1e4, 1e4)]).runs_needed(at, 0.95) == 1_000_000


def test_metamodels_are_fitted_to_the_runs_that_yielded_a_response() -> None:
    evaluations = [evaluation(x, first=10.0 + x, second=20.0 - x) for x in (0.0, 0.3, 0.6, 1.0)]
    evaluations += [evaluation(0.9), evaluation(0.5, first=10.5)]
    known = Metamodels.fit(PROBLEM, evaluations)
    assert [model.n for model in known.models] == [5, 4]
    means, _ = known.predict([[0.5]])
    assert means[0] == pytest.approx([10.5, 19.5], abs=0.05)


def test_a_run_of_one_test_leaves_the_metamodels_of_the_others_as_they_are() -> None:
    def runs(count: int, name: str, seed: int) -> list[Evaluation]:
        random = np.random.default_rng(seed)
        return [evaluation(x, **{name: 10.0 * x + random.normal()}) for x in random.random(count)]

    known = [*runs(6, "first", 1), *runs(8, "second", 2)]
    before = Metamodels.fit(PROBLEM, known)
    after = Metamodels.fit(PROBLEM, [*known, *runs(1, "first", 3)])
    assert after.models[1] is before.models[1]
    assert after.models[0].n == before.models[0].n + 1


@pytest.mark.parametrize(("successes", "enough"), [(2, False), (3, True)])
def test_two_runs_more_than_parameters_are_needed(successes: int, enough: bool) -> None:
    evaluations = [evaluation(x, first=10.0, second=20.0 + x) for x in (0.1, 0.5, 0.9)]
    evaluations = [*evaluations[:successes], evaluation(0.7)]
    assert can_be_fitted(PROBLEM, evaluations) == enough
    if enough:
        assert len(Metamodels.fit(PROBLEM, evaluations).models) == 2
    else:
        with pytest.raises(RunFailedError, match=r"only 2 of 3 runs .* 3 are needed.*it blew up"):
            Metamodels.fit(PROBLEM, evaluations)


def test_few_runs_give_probabilities_with_the_tails_of_student() -> None:
    random = np.random.default_rng(4)
    points = random.random((8, 1))
    model = Kriging.fit(points, 10.0 + 0.5 * random.standard_normal(8))
    found = model.predict([[0.5]])
    error = float(found.standard_error[0])
    far = Target("angle", float(found.mean[0]), tolerance=model.quantile(0.01) * error)
    known = Metamodels(Problem([Parameter("x", 0.0, 1.0)], [far]), [model])
    assert known.probability_all_met([[0.5]])[0] == pytest.approx(0.99)
    # A normal distribution of the same 95 % interval is too sure.
    assert inside(0.0, far.tolerance, error) > 0.996
