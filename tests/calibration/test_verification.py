"""Verdicts of the verification runs, and when all other runs count as well."""

import grainfit as gf
from grainfit.calibration.verification import contradictions, mean_with_interval
from grainfit.strategies.answer import Answer

ANGLE = gf.Target("angle_of_repose", 22.0, tolerance=0.5, unit="deg")
PROBLEM = gf.Problem([gf.Parameter("friction", 0.1, 0.9)], [ANGLE])
#: Mean 22.3, of which four runs are sure to 0.6 and forty to 0.1.
SCATTERED, CLOSE = [21.9, 22.1, 22.5, 22.7], [22.0, 22.2, 22.4, 22.6] * 10


def contradiction(values: list[float], expected: float) -> list[str]:
    known = Answer({"friction": 0.5}, {"angle_of_repose": expected}, {"angle_of_repose": 0.1}, 0.5)
    verified = {"angle_of_repose": mean_with_interval(values)}
    return list(map(str, contradictions(PROBLEM, verified, known)))


def test_runs_that_may_have_met_the_target_by_luck_need_all_others_on_their_side() -> None:
    assert contradiction(SCATTERED, expected=22.4) == []
    assert contradiction(SCATTERED, expected=22.6) == [
        "angle_of_repose is in doubt: the verification runs alone give 22.30 ± 0.58, where "
        "22 ± 0.5° is accepted, but by all runs together 22.60 ± 0.2 is expected."
    ]
    assert len(contradiction(SCATTERED, expected=21.4)) == 1


def test_runs_that_settle_it_outweigh_the_metamodel() -> None:
    assert contradiction(CLOSE, expected=22.6) == []


def test_a_target_that_is_missed_anyway_is_not_contradicted() -> None:
    assert contradiction([value + 1 for value in SCATTERED], expected=23.3) == []
