"""Fresh seeds at an answer: which runs count, and when they contradict the other runs."""

import numpy as np
import pytest

import grainfit as gf
from grainfit.calibration.judged_answer import Demands, JudgedAnswer, judge_by_runs
from grainfit.calibration.verification import fresh_runs, mean_with_interval
from grainfit.evaluation import Evaluation, Proposal, Response
from grainfit.strategies.answer import answer_from_runs
from grainfit.verdict import messages
from grainfit.verdict.evidence import Expected
from grainfit.verdict.rule import contradicts

ANGLE = gf.Target("angle_of_repose", 22.0, tolerance=0.5, unit="deg")
PROBLEM = gf.Problem([gf.Parameter("friction", 0.1, 0.9)], [ANGLE])
ANSWER = {"friction": 0.5}


def run(friction: float, angle: float, seed: int, stage: str = "verification") -> Evaluation:
    return Evaluation(
        Proposal({"friction": friction}, seed, stage), {ANGLE.name: Response(angle)}, {}
    )


@pytest.fixture(scope="module")
def design() -> list[Evaluation]:
    """Runs of a response that is 22 degrees at the answer, and rises by 10 over the interval."""
    random = np.random.default_rng(5)
    return [
        run(x, 22 + 12.5 * (x - 0.5) + 0.1 * random.standard_normal(), 100 + i, "design")
        for i, x in enumerate(np.linspace(0.1, 0.9, 12).tolist())
    ]


def judged(runs: list[Evaluation]) -> JudgedAnswer:
    answer = answer_from_runs(PROBLEM, runs, ANSWER)
    return judge_by_runs(PROBLEM, answer, runs, Demands(0.95, 3, {}))


@pytest.mark.parametrize(
    ("values", "error", "noise", "differs"),
    [
        # The mean of four runs has a standard error of 0.4, and the expectation of 0.3: three of
        # the difference are 1.5.
        *(
            ([off + d for d in (-0.3, -0.1, 0.1, 0.3)], 0.3, 0.8, abs(off) > 1.5)
            for off in (0.0, 1.45, 1.55, -1.55)
        ),
        # Seeds that do not scatter contradict from a hundredth of the tolerance on.
        ([0.004] * 3, 1e-9, 1e-9, False),
        ([0.006] * 3, 1e-9, 1e-9, True),
    ],
)
def test_fresh_seeds_contradict_beyond_three_standard_errors(
    values: list[float], error: float, noise: float, differs: bool
) -> None:
    fresh = mean_with_interval([22 + value for value in values])
    assert contradicts(fresh, Expected(22.0, error), noise, ANGLE.tolerance) == differs


def test_only_runs_at_exactly_the_answer_verify_it(design: list[Evaluation]) -> None:
    runs = [
        *design,
        run(0.5, 22.1, 1),
        run(0.5000001, 22.3, 2),
        run(0.5, 21.0, 3, stage="optimisation"),
    ]
    found = fresh_runs(PROBLEM, ANSWER, runs)
    assert found.values[ANGLE.name] == {1: 22.1}
    assert found.count == 1


def test_a_failed_run_is_no_fresh_seed(design: list[Evaluation]) -> None:
    failed = Evaluation(Proposal(ANSWER, 7, "verification"), {}, {"heap": "it blew up"})
    found = fresh_runs(PROBLEM, ANSWER, [*design, failed, run(0.5, 22.0, 8)])
    assert found.count == 1
    assert len(found.evaluations) == 2


def test_fresh_seeds_are_compared_with_what_the_others_expect(design: list[Evaluation]) -> None:
    random = np.random.default_rng(6)
    far = [run(0.5, 24 + 0.1 * random.standard_normal(), seed) for seed in (1, 2, 3)]
    found = judged([*design, *far])
    assert found.fresh.expected[ANGLE.name].mean == pytest.approx(22.0, abs=0.2)
    assert found.judgement.contradicted == (ANGLE.name,)
    [reason] = [one for one in found.reasons if one.kind == "contradicted"]
    assert messages.CONTRADICTED.is_in(str(reason), expected=22)


def test_seeds_after_a_contradiction_are_compared_with_what_is_known_then(
    design: list[Evaluation],
) -> None:
    # A response with a step just below the answer, which no run of the design has seen.
    high = [
        run(x, value + 2.0, one.proposal.seed, "design")
        for one in design
        for x, value in [(one.proposal.parameters["friction"], one.responses[ANGLE.name].value)]
        if x < 0.5
    ]
    random = np.random.default_rng(7)
    far = [run(0.5, 22 + 0.1 * random.standard_normal(), seed) for seed in range(1, 7)]
    first = judged([*high, *far[:3]])
    assert first.judgement.contradicted == (ANGLE.name,)
    found = judged([*high, *far])
    assert found.judgement.contradicted == ()
    assert list(found.fresh.values[ANGLE.name]) == [4, 5, 6]


def test_fresh_seeds_beside_a_cliff_contradict_however_large_the_scatter_seems() -> None:
    random = np.random.default_rng(9)
    # The target is in the middle of what a cliff leaves out: the metamodel takes it for scatter.
    places = np.append(np.linspace(0.1, 0.9, 14), random.uniform(0.45, 0.55, 16))
    runs = [
        run(x, 20.0 + 4.0 * (x > 0.5) + 0.1 * random.standard_normal(), 100 + i, "design")
        for i, x in enumerate(places.tolist())
    ]
    close = [run(0.5, 20 + 0.1 * random.standard_normal(), seed) for seed in (1, 2, 3)]
    found = judged([*runs, *close])
    assert found.judgement.contradicted == (ANGLE.name,)
    assert found.status != "calibrated"
