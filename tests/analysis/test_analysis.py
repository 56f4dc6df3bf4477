"""The whole analysis from runs: its messages, and too few runs for an analysis."""

import warnings
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from scipy.stats import qmc

import grainfit
from grainfit.analysis.analysis import Analysis, analyse, analyse_parameters
from grainfit.evaluation import Evaluation, Proposal, Response
from grainfit.materials.time_step import RayleighTimeStep
from grainfit.problem import Parameter, Problem, Target

DENSITY = Parameter("particle.density", 2000.0, 3000.0, unit="kg/m^3")
SLIDING = Parameter("particle_particle.sliding_friction", 0.1, 0.9)
ROLLING = Parameter("particle_particle.rolling_friction", 0.1, 0.9)
RAYLEIGH = RayleighTimeStep(
    0.005, {"particle.youngs_modulus": 1e7, "particle.poissons_ratio": 0.25}
)
PROBLEM = Problem(
    [DENSITY, SLIDING, ROLLING],
    [Target("bulk_density", 1500.0, tolerance=20.0), Target("angle", 30.0, uncertainty=0.5)],
    RAYLEIGH,
)
#: The same without the trade-off against the time step.
STATIC = replace(PROBLEM, rayleigh=None)
ANSWER = {DENSITY.name: 2500.0, SLIDING.name: 0.5, ROLLING.name: 0.5}


def simulated(values: dict[str, float], random: np.random.Generator) -> dict[str, float]:
    """Bulk density by that of the solid; the angle by the sum of the frictions."""
    friction = values[SLIDING.name] + values[ROLLING.name]
    return {
        "bulk_density": 0.6 * values[DENSITY.name] + random.normal(0.0, 5.0),
        "angle": 20.0 + 10.0 * friction + random.normal(0.0, 0.5),
    }


def runs(
    problem: Problem,
    count: int,
    respond: Callable[[dict[str, float], np.random.Generator], dict[str, float]] = simulated,
    failing: int = 0,
) -> list[Evaluation]:
    """A design, of which the last ones fail."""
    random = np.random.default_rng(7)
    points = qmc.LatinHypercube(problem.dimension, rng=random).random(count)
    found = []
    for number, point in enumerate(points):
        values = problem.from_unit(point)
        proposal = Proposal(values, number, "design")
        if number >= count - failing:
            found.append(Evaluation(proposal, {}, {"heap": "it blew up"}))
        else:
            responses = {name: Response(v) for name, v in respond(values, random).items()}
            found.append(Evaluation(proposal, responses))
    return found


@pytest.fixture(scope="module")
def whole() -> Analysis:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        return grainfit.analyse(PROBLEM, runs(PROBLEM, 36, failing=4), answer=ANSWER)


def test_a_calibration_of_two_frictions_and_a_density_is_seen_through(whole: Analysis) -> None:
    assert whole.notes == ()
    assert whole.metamodels is not None
    assert [model.n for model in whole.metamodels.models] == [32, 32]
    assert whole.quality["bulk_density"].q2 > 0.95
    assert whole.identifiability is not None
    ridge, density = whole.identifiability.verdicts
    assert ridge.startswith(
        "particle_particle.sliding_friction and particle_particle.rolling_friction cannot be told"
    )
    assert density.startswith("particle.density is determined to ±")
    assert whole.posterior is not None
    low, high = whole.posterior.interval(DENSITY.name)
    assert low < 2500.0 < high
    # A tolerance of 20 is 17 in the density of the solid, and the metamodel adds little.
    assert (high - low) / 4 == pytest.approx(20.0 / 1.96 / 0.6, rel=0.3)
    assert whole.posterior.correlations[1, 2] < -0.9
    assert whole.sensitivity is not None
    np.testing.assert_allclose(
        whole.sensitivity.total, [[1.0, 0.0, 0.0], [0.0, 0.5, 0.5]], atol=0.06
    )
    assert whole.pareto is not None
    assert whole.pareto.parameters[-1][DENSITY.name] == pytest.approx(3000.0)
    assert whole.pareto.probability_all_met[0] > 0.9
    assert whole.pareto.probability_all_met[-1] < 0.01


def test_the_same_runs_give_the_same_analysis(
    whole: Analysis, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("grainfit.analysis.analysis._last", None)
    again = analyse(PROBLEM, runs(PROBLEM, 36, failing=4), answer=ANSWER)
    np.testing.assert_array_equal(again.posterior.points, whole.posterior.points)
    np.testing.assert_array_equal(again.sensitivity.total_high, whole.sensitivity.total_high)
    np.testing.assert_array_equal(again.pareto.misfits, whole.pareto.misfits)
    assert again.identifiability == whole.identifiability


@pytest.mark.parametrize(
    ("count", "failing", "note"),
    [
        (0, 0, "There is no run yet that yielded a response: nothing can be said."),
        (3, 3, "None of 3 runs yielded a response: nothing can be said."),
        (5, 1, "There is no metamodel of angle: 4 runs gave the response 'angle', at only 4"),
    ],
)
def test_too_few_runs_are_no_error_but_a_note(count: int, failing: int, note: str) -> None:
    found = analyse(PROBLEM, runs(PROBLEM, count, failing=failing))
    assert any(text.startswith(note) for text in found.notes)
    assert found == Analysis(notes=found.notes)


def test_runs_at_one_place_only_are_no_error_but_a_note() -> None:
    alike = [
        replace(run, proposal=replace(run.proposal, seed=seed))
        for seed, run in enumerate(9 * runs(PROBLEM, 1))
    ]
    (note, *_) = analyse(PROBLEM, alike).notes
    assert (
        "9 runs gave the response 'bulk_density', at only 1 different place, and 5 are needed"
        in note
    )


def test_a_response_that_no_run_yields_is_left_out_and_named() -> None:
    problem = replace(STATIC, targets=[*PROBLEM.targets, Target("flow_time", 3.0)])
    found = analyse(problem, runs(problem, 12))
    assert [target.name for target in found.metamodels.problem.targets] == ["bulk_density", "angle"]
    assert list(found.quality) == ["bulk_density", "angle"]
    assert found.posterior.responses.shape[1] == 2
    assert found.notes[0].startswith("There is no metamodel of flow_time: only 0 of 12 runs")


@pytest.mark.parametrize(
    ("answer", "words", "reach"),
    [({SLIDING.name: 0.3}, "the answer", 0.1), (None, "what looks like the answer", 0.2)],
)
def test_of_many_runs_those_near_the_answer_count_whatever_came_of_them(
    answer: dict[str, float] | None, words: str, reach: float
) -> None:
    """Had runs been chosen by what they gave, the scatter would look smaller than it is."""
    problem = Problem([SLIDING], [Target("angle", 26.0, tolerance=1.0)])

    def respond(values: dict[str, float], random: np.random.Generator) -> dict[str, float]:
        return {"angle": 20.0 + 20.0 * values[SLIDING.name] + random.normal(0.0, 2.0)}

    found = analyse(problem, runs(problem, 400, respond), answer=answer)
    assert found.metamodels.models[0].n == 150
    (note,) = found.notes
    assert note.startswith("The analysis rests on 150 of 400 runs, ")
    assert f"the 75 nearest to {words} and 75 spread over the others" in note
    assert found.quality["angle"].noise == pytest.approx(2.0, rel=0.25)
    points = np.array(found.metamodels.models[0].to_plain()["points"])
    assert (np.abs(points - 0.25) < reach).sum() >= 75


def test_runs_not_far_outside_the_intervals_count_and_others_are_left_out() -> None:
    narrower = replace(STATIC, parameters=[replace(DENSITY, maximum=2400.0), SLIDING, ROLLING])
    evaluations = runs(PROBLEM, 30)
    # The half of an interval of 400 beyond 2400.
    near = sum(e.proposal.parameters[DENSITY.name] <= 2600.0 for e in evaluations)
    found = analyse(narrower, evaluations)
    assert found.metamodels.models[0].n == near
    assert found.notes[0].startswith(
        f"{30 - near} of 30 runs are farther outside the intervals than 50% of their widths"
    )
    assert found.posterior.values.max(axis=0)[0] <= 2400.0


def test_the_order_of_the_runs_does_not_matter(whole: Analysis) -> None:
    again = analyse(PROBLEM, runs(PROBLEM, 36, failing=4)[::-1], answer=ANSWER)
    assert again.intervals == whole.intervals
    np.testing.assert_array_equal(again.sensitivity.total, whole.sensitivity.total)


def test_a_response_that_is_always_the_same_is_no_obstacle() -> None:
    problem = Problem([SLIDING, ROLLING], [Target("angle", 30.0, tolerance=1.0)])
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        found = analyse(problem, runs(problem, 12, lambda values, random: {"angle": 30.0}))
    assert found.quality["angle"].q2 is None
    assert all("is not determined" in verdict for verdict in found.identifiability.verdicts)
    assert not found.sensitivity.total.any()


def test_fourteen_parameters_can_be_analysed() -> None:
    problem = Problem(
        [Parameter(f"p{number}", 0.0, 1.0) for number in range(14)],
        [Target("angle", 30.0, tolerance=0.5)],
    )

    def respond(values: dict[str, float], random: np.random.Generator) -> dict[str, float]:
        return {"angle": 20.0 + 20.0 * values["p3"] + random.normal(0.0, 0.2)}

    found = analyse(problem, runs(problem, 40, respond))
    assert found.notes == ()
    assert found.identifiability.verdicts[-1].startswith("p3 is determined")
    assert sum("not determined" in verdict for verdict in found.identifiability.verdicts) >= 10
    assert found.sensitivity.total[0].argmax() == 3


def test_report_takes_the_sample_of_the_result_and_no_other() -> None:
    made = runs(STATIC, 12)
    result = analyse_parameters(STATIC, made, answer=ANSWER).posterior
    known = [replace(e, seconds=9.0, reused=1) for e in made]
    assert analyse(STATIC, known, answer=ANSWER).posterior is result
    other = replace(made[0], responses={**made[0].responses, "angle": Response(31.0)})
    narrower = replace(STATIC, targets=[Target("angle", 30.0, uncertainty=0.4)])
    for problem, evaluations, seed in (
        (STATIC, [other, *made[1:]], 1),
        (narrower, made, 1),
        (STATIC, made, 2),
    ):
        sample = analyse(problem, evaluations, seed=seed, answer=ANSWER).posterior
        assert sample is not None
        assert result is not None
        assert not np.array_equal(sample.points, result.points)
