"""Expected responses of the atlas guide a search; no verdict rests on them."""

from __future__ import annotations

import json
import shutil
from collections.abc import Mapping
from pathlib import Path

import numpy as np
import pytest

import grainfit as gf
from grainfit.atlas import expectation
from grainfit.atlas import messages as atlas_messages
from grainfit.atlas.expectation import Expectation
from grainfit.atlas.guide import Guide, guide, guided
from grainfit.atlas.shelf import SHIPPED, Atlas
from grainfit.bulk_tests.parameter_names import DENSITY, ROLLING, SLIDING
from grainfit.calibration import messages
from grainfit.evaluation import scalars
from grainfit.solvers.dem.lammps.program import Lammps
from grainfit.testing.materials import ROUGH_PLATE, ROUGH_SPHERES

FREE = [gf.Parameter(SLIDING, 0.2, 0.8), gf.Parameter(ROLLING, 0.05, 0.6)]
MORE = [
    gf.Parameter(DENSITY, 1000.0, 3000.0),
    *(
        gf.Parameter(f"particle_wall.{name}", 0.1, 0.6)
        for name in ("sliding_friction", "restitution")
    ),
    gf.Parameter("particle_particle.restitution", 0.3, 0.8),
]
UNDAMPED = {
    name: 0.0 if name.endswith("rolling_damping") else value
    for name, value in ROUGH_SPHERES.items()
}
FIXED = {name: value for name, value in UNDAMPED.items() if name not in (SLIDING, ROLLING)}
ANGLE = gf.Target("angle_of_repose", "21.6 deg", uncertainty="1 deg")
RADIUS = gf.Target("base_radius", "130 mm", uncertainty="1 %")


class ExpectedHeap(Lammps):
    """A heap of LAMMPS whose runs are what the atlas expects, with a scatter."""

    shift = 0.0
    runs = 0

    def run(
        self, parameters: Mapping[str, float], seed: int, workspace: gf.Workspace
    ) -> dict[str, gf.Response]:
        """Return angle and base radius."""
        del workspace
        type(self).runs += 1
        values = {name: np.array([one]) for name, one in parameters.items()}
        names = ["angle_of_repose", "base_radius"]
        found = Expectation(self, parameters, Atlas()).responses(values, names)
        noise = 0.01 * np.random.default_rng(seed).standard_normal(2)
        return {
            name: gf.Response(float(found[name].means[0]) * (1 + self.shift + one))
            for name, one in zip(names, noise, strict=True)
        }


def _heap(shift: float = 0.0, **fixed: float) -> ExpectedHeap:
    heap = ExpectedHeap(gf.tests.Heap(diameter="10 mm", **ROUGH_PLATE), {**FIXED, **fixed})
    heap.shift = shift
    return heap


def _guide(problem: gf.Problem, **options: object) -> Guide:
    return guide(problem, {"heap": _heap()}, 1, **options)  # type: ignore[arg-type]


def test_a_guide_is_what_the_atlas_expects_half_of_it_near_the_answer() -> None:
    problem = gf.Problem(FREE, [ANGLE, RADIUS])

    found = _guide(problem)

    assert found.tests == ("",)
    expected = Expectation(_heap(), problem.middle)
    angles = []
    for one in found.evaluations:
        values = {name: np.array([value]) for name, value in one.proposal.parameters.items()}
        [there] = expected.responses(values, ["angle_of_repose"]).values()
        told = scalars(one.responses)[" (relative).angle_of_repose"]
        assert told.value == pytest.approx(float(there.means[0]))
        assert told.standard_error == pytest.approx(float(there.means[0] * there.errors[0]))
        angles.append(told.value)
    near = np.abs(np.array(angles) - 21.6) < 1.5
    assert 0.4 < near.mean() < 0.9


#: Without rolling friction there is no heap.
WIDE = [gf.Parameter(SLIDING, 0.02, 0.8, "log"), gf.Parameter(ROLLING, 0.01, 0.6, "log")]


def test_where_a_run_is_expected_to_fail_so_does_the_guide() -> None:
    problem = gf.Problem(WIDE, [ANGLE, RADIUS])

    found = _guide(problem).evaluations

    values = {
        name: np.array([one.proposal.parameters[name] for one in found])
        for name in (SLIDING, ROLLING)
    }
    chances = Expectation(_heap(), problem.middle).chance(values, [ANGLE.name, RADIUS.name])
    fails = [one.failed_in(" (relative)") for one in found]
    assert fails == (chances < 0.5).tolist()
    assert 5 < sum(fails) < 50
    assert [not one.responses for one in found] == fails


@pytest.mark.parametrize(
    ("problem", "without"),
    [
        (gf.Problem(FREE, [gf.Target("angle", 25.0)]), ()),
        (gf.Problem([gf.Parameter("particle.poissons_ratio", 0.1, 0.4)], [ANGLE]), ()),
        (gf.Problem(FREE, [ANGLE]), ("",)),
        (gf.Problem([*FREE, *MORE], [ANGLE]), ()),
    ],
)
def test_nothing_guides_where_the_atlas_tells_nothing_or_something_else_does(
    problem: gf.Problem, without: tuple[str, ...]
) -> None:
    assert _guide(problem, without=without) == Guide()
    assert bool(guided(problem, {"heap": _heap()})) == bool(without)


def test_nothing_stands_for_a_law_that_the_atlas_does_not_have() -> None:
    damped = _heap(**{"particle_particle.rolling_damping": 0.25})
    assert guide(gf.Problem(FREE, [ANGLE]), {"heap": damped}, 1) == Guide()


def test_a_guide_is_the_same_after_it_was_stored() -> None:
    found = _guide(gf.Problem(WIDE, [ANGLE]))

    again = Guide.from_json(json.loads(json.dumps(found.to_json())))
    assert again == found
    assert Guide.from_json({}) == Guide()


@pytest.mark.thorough
@pytest.mark.parametrize("shift", [0.0, 0.15])
def test_a_guided_search_takes_fewer_runs_and_a_wrong_guide_few_more(shift: float) -> None:
    measured = {"angle_of_repose": 21.6 * (1 + shift), "base_radius": 0.13 * (1 + shift)}
    targets = [
        gf.Target("angle_of_repose", measured["angle_of_repose"], uncertainty=1.0),
        gf.Target("base_radius", measured["base_radius"], uncertainty="1 %"),
    ]
    problem = gf.Problem(FREE, targets)
    runs = {}
    for atlas in (True, False):
        results = [gf.calibrate(problem, _heap(shift), seed=s, atlas=atlas) for s in (1, 2, 3)]
        for result in results:
            assert result.status == "calibrated"
            values = {name: np.array([one]) for name, one in result.parameters.items()}
            true = Expectation(_heap(), problem.middle).responses(values, list(measured))
            for target in targets:
                mean = (1 + shift) * float(true[target.name].means[0])
                assert abs(mean - target.value) < target.tolerance
        runs[atlas] = np.mean([result.runs.total for result in results])

    assert runs[True] <= runs[False] + (3 if shift else 0)


def test_a_later_start_keeps_the_guide_of_the_first_one(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def calibrated(atlas: bool = True) -> gf.Result:
        problem = gf.Problem(FREE, [ANGLE, RADIUS])
        return gf.calibrate(
            problem, {"heap": _heap()}, workdir=tmp_path / "work", atlas=atlas, max_runs=9
        )

    first = calibrated()
    made = ExpectedHeap.runs
    monkeypatch.setattr(expectation, "shipped_atlas", lambda: Atlas(tmp_path / "nothing"))

    assert calibrated().parameters == first.parameters
    assert ExpectedHeap.runs == made
    assert messages.GUIDED_BY_ATLAS.is_in(" ".join(first.notices), tests="heap")
    without = calibrated(atlas=False)
    assert without.identity != first.identity
    assert not messages.GUIDED_BY_ATLAS.is_in(" ".join(without.notices))


def test_a_guided_search_finds_its_way_out_of_failing_runs() -> None:
    class Failing(ExpectedHeap):
        def run(
            self, parameters: Mapping[str, float], seed: int, workspace: gf.Workspace
        ) -> dict[str, gf.Response]:
            if parameters[ROLLING] < 0.5:
                raise gf.RunFailedError("there is no heap")
            return super().run(parameters, seed, workspace)

    heap = Failing(gf.tests.Heap(diameter="10 mm", **ROUGH_PLATE), FIXED)
    steep = gf.Target("angle_of_repose", "27 deg", uncertainty="2 deg")
    narrow = gf.Target("base_radius", "120 mm", uncertainty="5 %")

    result = gf.calibrate(gf.Problem(FREE, [steep, narrow]), {"heap": heap}, seed=1, atlas=True)

    assert result.status == "calibrated"


def test_a_guide_is_none_of_the_runs_that_failed() -> None:
    class Choked(ExpectedHeap):
        made = 0

        def run(
            self, parameters: Mapping[str, float], seed: int, workspace: gf.Workspace
        ) -> dict[str, gf.Response]:
            self.made += 1
            if self.made > 2:
                raise gf.RunFailedError(f"the slot is choked by particle {self.made}")
            return super().run(parameters, seed, workspace)

    heap = Choked(gf.tests.Heap(diameter="10 mm", **ROUGH_PLATE), FIXED)

    with pytest.raises(gf.RunFailedError) as caught:
        gf.calibrate(gf.Problem(WIDE, [ANGLE, RADIUS]), heap)

    assert f"2 of {heap.made} runs" in str(caught.value)
    assert "the slot is choked" in str(caught.value)
    assert not atlas_messages.EXPECTED_TO_FAIL.is_in(str(caught.value))


def test_a_given_size_of_the_design_stays() -> None:
    problem = gf.Problem(FREE, [ANGLE, RADIUS])
    strategy = gf.Sequential(design_runs=6)

    result = gf.calibrate(problem, {"heap": _heap()}, strategy=strategy, max_runs=9, atlas=True)

    assert result.runs.design == 6


def test_a_damaged_atlas_is_named_and_the_search_goes_on(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    damaged = tmp_path / "atlas"
    shutil.copytree(SHIPPED, damaged)
    (damaged / "heap.jsonl").write_text("{}")
    monkeypatch.setattr(expectation, "shipped_atlas", lambda: Atlas(damaged))

    result = gf.calibrate(gf.Problem(FREE, [ANGLE, RADIUS]), _heap(), atlas=True)

    assert result.status == "calibrated"
    [notice] = [one for one in result.notices if messages.WITHOUT_ATLAS.is_in(one)]
    assert atlas_messages.DAMAGED.is_in(notice)


def test_an_own_model_has_no_atlas_and_no_word() -> None:
    problem = gf.Problem([gf.Parameter(DENSITY, 1000.0, 3000.0)], [gf.Target("bulk", 1200.0)])

    result = gf.calibrate(problem, lambda p, _: {"bulk": 0.6 * p[DENSITY]}, atlas=True)

    assert "atlas" not in " ".join(result.notices)


def test_atlas_is_true_or_false() -> None:
    problem = gf.Problem(FREE, [ANGLE])
    with pytest.raises(gf.InputError, match="atlas"):
        gf.calibrate(problem, _heap(), atlas="yes")  # type: ignore[arg-type]
