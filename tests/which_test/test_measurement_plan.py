"""Combinations of tests before the laboratory: closed forms, and the figures of the trials."""

from __future__ import annotations

import json
import math
from pathlib import Path

import numpy as np
import pytest

import grainfit as gf
from grainfit.bulk_tests.abilities import options_for
from grainfit.bulk_tests.accuracy import Accuracy, usual_accuracy
from grainfit.bulk_tests.parameter_names import DENSITY, RESTITUTION, ROLLING, SLIDING, WALL_SLIDING
from grainfit.bulk_tests.registry import BUILT_IN
from grainfit.testing.materials import ROUGH_SPHERES
from grainfit.which_test import messages
from grainfit.which_test.candidate import Candidate, CandidateResponse
from grainfit.which_test.knowledge import Knowledge
from grainfit.which_test.measurement_plan import rank_combinations
from grainfit.which_test.slopes import Cloud
from grainfit.which_test.told_by_atlas import told_responses

TRIALS = Path(__file__).parents[2] / "benchmarks" / "data" / "trial_slopes.json"
#: Known before any test in the trials, as a standard deviation of the logarithm.
BEFORE = {DENSITY: 1.0, SLIDING: 1.0, ROLLING: 1.5, RESTITUTION: 0.17, WALL_SLIDING: 0.03}
#: Responses of today's heap and drum that are not in the figures of the trials.
LEFT_OUT = ("base_radius", "heap_height", "surface_angle", "upper_angle", "lower_angle")


#: The trials had a rolling damping, and this slope was 0.57. Without it, as in the atlas, it is
#: 0.51 ± 0.02: 14 seeds each of a rolling friction of 0.143 and 0.28.
WITHOUT_DAMPING = {("heap", "angle_of_repose", ROLLING): 0.51}


def known(**changed: float) -> Knowledge:
    before = {**BEFORE, **{DENSITY: changed.get("density", 1.0)}}
    return Knowledge(tuple(before), np.diag([d**2 for d in before.values()]))


def told(name: str) -> Candidate:
    """Return a test with the slopes of the atlas about the material of the trials."""
    names = {SLIDING: 0.5, ROLLING: 0.2, DENSITY: 2100.0, RESTITUTION: 0.6, WALL_SLIDING: 0.4}
    around = [gf.Parameter(key, value / 1.4, value * 1.4, "log") for key, value in names.items()]
    material = {**ROUGH_SPHERES, **names}
    kind = BUILT_IN[name]
    if name == "compression":
        material["particle.youngs_modulus"] = 10e6
    test = kind(diameter="10 mm", **options_for(kind, material))
    fixed = {key: value for key, value in material.items() if key not in names}
    found = told_responses(
        name,
        gf.solvers.Lammps(test, fixed),
        Cloud.even(around),
        lambda key, info: None if key in LEFT_OUT else usual_accuracy(key, info.unit),
    )
    return Candidate(name, 5.0, found)


@pytest.mark.parametrize(
    "name", ["compression", "discharge", "draw_down", "drum", "funnel", "heap", "packing", "shear"]
)
def test_slopes_over_the_frictions_are_those_of_the_trials(name: str) -> None:
    # 291 runs that are no rows of the atlas, docs/choosing_tests.md.
    trials = json.loads(TRIALS.read_text(encoding="utf-8"))[name]
    slopes = {one.short_name: one.slopes for one in told(name).responses}
    for response in slopes.keys() & trials.keys():
        seen = trials[response]["at_low_rolling"]
        for friction in {SLIDING, ROLLING} & seen.keys():
            expected = WITHOUT_DAMPING.get((name, response, friction), seen[friction])
            assert slopes[response][friction] == pytest.approx(expected, abs=0.1), response


def test_a_draw_down_and_a_compression_help_a_heap_more_than_another_angle() -> None:
    left = {}
    for other in ("compression", "draw_down", "shear", "drum"):
        responses = [r for name in ("heap", other) for r in told(name).responses]
        errors = np.diag([r.variance() for r in responses])
        after = known().after([r.slopes for r in responses], errors)
        left[other] = after.deviation(SLIDING)
    assert max(left["compression"], left["draw_down"]) < 0.8 * min(left["shear"], left["drum"])


def test_a_plan_for_two_frictions_begins_with_tests_that_tell_them_apart() -> None:
    names = ("heap", "discharge", "packing", "compression", "draw_down")
    plan = rank_combinations(
        [told(name) for name in names], known().without([RESTITUTION]), 0.5, [], ""
    )
    assert plan.best is not None
    best = {test.name for test in plan.best.tests}
    assert "heap" in best
    assert best & {"compression", "draw_down"}
    by_name = {c.name: c for c in plan.combinations}
    assert by_name["heap + packing"].coarser < 1
    assert by_name["heap"].coarser < 1
    # A further test beside those that are enough is not offered.
    enough = [{test.name for test in c.tests} for c in plan.combinations if c.coarser >= 1]
    assert not any(one < other for one in enough for other in enough)


def one(slope: float, accuracy: float, name: str = "t", scatter: float = 0.0) -> Candidate:
    share = Accuracy(accuracy, is_share=True)
    return Candidate(
        name, 1.0, (CandidateResponse(f"{name}.y", 1.0, share, {"a": slope}, scatter),)
    )


def test_the_accuracy_that_is_needed_is_the_closed_form() -> None:
    before = Knowledge(("a",), np.array([[0.25]]))
    plan = rank_combinations([one(2.0, 0.01)], before, 0.1, [], "")
    # 1 / (1 / 0.25 + 4 / u^2) = (0.1 / 1.96)^2
    needed = math.sqrt(4 / ((1.96 / 0.1) ** 2 - 4))
    assert plan.combinations[0].coarser == pytest.approx(needed / 0.01, rel=1e-4)
    assert plan.combinations[0].half_widths["a"] == pytest.approx(0.0098, rel=1e-3)


def test_scatter_of_the_runs_is_not_measured_away() -> None:
    before = Knowledge(("a",), np.array([[0.25]]))
    plan = rank_combinations([one(1.0, 0.01, scatter=0.5)], before, 0.1, [], "")
    assert plan.combinations[0].coarser == 0.0
    assert plan.best is None
    assert plan.out_of_reach() == ("a",)
    text = str(plan)
    assert messages.NOT_SETTLED.is_in(text, wanted="every free parameter to ± 10 %")
    assert messages.NOT_SETTLED_TO.is_in(text, name="a", wanted="10 %")


def test_a_finer_accuracy_that_would_do_is_named() -> None:
    before = Knowledge(("a",), np.array([[0.25]]))
    plan = rank_combinations([one(1.0, 0.1)], before, 0.1, [], "")
    assert 0 < plan.combinations[0].coarser < 1
    assert messages.SETTLED_IF_FINER.is_in(str(plan))
    assert "t (y to 5.1 %) would." in str(plan)


def test_the_cheapest_combination_that_is_enough_comes_first() -> None:
    before = Knowledge(("a",), np.array([[0.25]]))
    cheap, dear = one(1.0, 0.01, "cheap"), one(1.0, 0.001, "dear")
    dear = Candidate("dear", 9.0, dear.responses)
    plan = rank_combinations([dear, cheap], before, 0.1, ["Not compared: other. Too soft."], "")
    assert [c.name for c in plan.combinations] == ["cheap", "dear"]
    assert "Measure cheap (y to 1 %): that settles every free parameter to ± 10 %." in str(plan)
    assert "Not compared: other. Too soft." in str(plan)
    assert "<table" in plan._repr_html_()
