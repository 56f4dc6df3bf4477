"""Fresh seeds at an answer: which runs count, and when they contradict all runs together."""

import pytest

import grainfit as gf
from grainfit.calibration.verification import mean_with_interval, runs_near
from grainfit.evaluation import Evaluation, Proposal, Response
from grainfit.result import MetamodelQuality
from grainfit.strategies.answer import Answer
from grainfit.verdict.rule import contradicts

ANGLE = gf.Target("angle_of_repose", 22.0, tolerance=0.5, unit="deg")
PROBLEM = gf.Problem([gf.Parameter("friction", 0.1, 0.9)], [ANGLE])


def answer(friction: float, expected: float) -> Answer:
    quality = MetamodelQuality(0.9, 0.95, 0.8)
    name = ANGLE.name
    return Answer(
        {"friction": friction}, {name: expected}, {name: 0.2}, 0.9, quality={name: quality}
    )


def fresh(friction: float, angle: float, seed: int, stage: str = "verification") -> Evaluation:
    return Evaluation(
        Proposal({"friction": friction}, seed, stage), {ANGLE.name: Response(angle)}, {}
    )


@pytest.mark.parametrize(
    ("values", "error", "noise", "differs"),
    [
        # The mean of four runs has a standard error of 0.4, and the expectation, which they are
        # part of, of 0.1: three of the difference are 3 sqrt(0.4^2 - 0.1^2) = 1.16.
        *(
            ([off + d for d in (-0.3, -0.1, 0.1, 0.3)], 0.1, 0.8, abs(off) > 1.16)
            for off in (0.0, 1.1, 1.5, -1.5)
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
    assert contradicts(fresh, 22.0, error, noise, ANGLE.tolerance) == differs


def test_runs_very_near_the_answer_count_and_are_carried_over_to_it() -> None:
    def describe(parameters):
        return answer(parameters["friction"], 22.0 + 10 * (parameters["friction"] - 0.5))

    runs = [
        fresh(0.5, 22.1, 1),
        fresh(0.51, 22.3, 2),
        fresh(0.5, 21.0, 3, stage="optimisation"),
        # Expected 0.6 degrees higher, more than half a tolerance.
        fresh(0.56, 22.6, 4),
        # Farther than a tenth of the interval.
        fresh(0.7, 24.0, 5),
    ]
    found = runs_near(PROBLEM, describe({"friction": 0.5}), runs, describe)
    assert found.values[ANGLE.name] == pytest.approx({1: 22.1, 2: 22.2})
    assert found.count == 2


def test_a_failed_run_is_no_fresh_seed() -> None:
    failed = Evaluation(Proposal({"friction": 0.5}, 7, "verification"), {}, {"heap": "it blew up"})
    found = runs_near(PROBLEM, answer(0.5, 22.0), [failed, fresh(0.5, 22.0, 8)], lambda _: None)
    assert found.count == 1
    assert len(found.evaluations) == 2
