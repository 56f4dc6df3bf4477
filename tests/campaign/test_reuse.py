"""Runs of a problem are recognised among others, by what defines them."""

from __future__ import annotations

import random
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from statistics import stdev
from typing import Any

import pytest

import grainfit as gf
from grainfit.bulk_tests.heap import Heap
from grainfit.calibration_file.build import build_calibration
from grainfit.calibration_file.load import load_calibration_file
from grainfit.campaign import messages
from grainfit.campaign.reuse import runs_of
from grainfit.campaign.store.records import RunRecord
from grainfit.campaign.store.store import RunStore
from grainfit.campaign.unused_source import why_unused
from grainfit.evaluation import Evaluation, Proposal, Response
from grainfit.materials.sizes import ParticleSizes
from grainfit.metamodels.known_runs import nearest_runs
from grainfit.solvers.base import Solver
from grainfit.solvers.dem.lammps.program import Lammps
from grainfit.solvers.own_model.python_callable import PythonCallable
from grainfit.solvers.parameters_for import ParametersFor

EXAMPLE = Path(__file__).parents[2] / "examples" / "glass_beads" / "calibration.toml"


def run(solver: Solver, values: dict[str, float], seed: int, **changes: object) -> RunRecord:
    definition = solver.definition(values, seed)
    given = {"status": "finished", "responses": {"angle": Response(22.0)}} | changes
    return RunRecord(definition.identity, "drum", definition=definition, **given)  # type: ignore[arg-type]


def drum(low: float = 0.1, high: float = 0.9) -> tuple[gf.Problem, Solver]:
    # Equal intervals must not be mistaken for each other.
    problem = gf.Problem(
        [gf.Parameter("sliding", low, high), gf.Parameter("rolling", low, high)],
        [gf.Target("angle", 22.0)],
    )
    return problem, PythonCallable(lambda p, s: {"angle": p["sliding"]}, identity="drum")


def test_runs_of_the_heap_test_are_recognised_and_those_of_other_materials_are_not() -> None:
    setup = build_calibration(load_calibration_file(EXAMPLE))
    [(test, solver)] = setup.solvers.items()
    assert isinstance(solver, Lammps)
    values = setup.problem.from_unit([0.3, 0.8])
    measured = {target.name: Response(target.value) for target in setup.problem.targets}
    same = run(solver, values, 7, responses=measured)
    stiffer = Lammps(solver.test, solver.material | {"particle.youngs_modulus": 1e7})
    bigger = Lammps(Heap(ParticleSizes((0.012,))), solver.material)
    others = [run(other, values, 7, responses=measured) for other in (stiffer, bigger)]
    # Of a version that measured less.
    others.append(run(solver, values, 8, responses={"bulk_density": Response(1500.0)}))
    [found] = runs_of(setup.problem, {test: solver}, [*others, same])
    assert found.proposal == Proposal(values, 7, "design")
    assert found.runs == {test: same.identity}


def test_parameters_of_equal_intervals_are_told_apart() -> None:
    problem, solver = drum()
    values = {"sliding": 0.31, "rolling": 0.77}
    [found] = runs_of(problem, {"drum": solver}, [run(solver, values, 3)])
    assert found.proposal.parameters == values


def test_only_runs_not_far_from_the_intervals_that_tell_something_count() -> None:
    problem, solver = drum()
    inside = {"sliding": 0.3, "rolling": 0.4}
    records = [
        run(solver, inside, 1),
        # The intervals are 0.8 wide, and the half of that is used.
        run(solver, {"sliding": 1.29, "rolling": 0.4}, 2),
        run(solver, {"sliding": 1.31, "rolling": 0.4}, 3),
        run(solver, inside, 4, status="failed", responses={}, kind="simulation", reason="exploded"),
        run(solver, inside, 5, status="failed", responses={}, kind="machine"),
        run(solver, inside, 6, status="running", responses={}),
    ]
    found = runs_of(problem, {"drum": solver}, records)
    assert sorted(evaluation.proposal.seed for evaluation in found) == [1, 2, 4]
    assert found[1].failures == {"drum": "exploded"}


def test_a_negative_value_is_infinitely_far_from_a_logarithmic_interval() -> None:
    problem = gf.Problem([gf.Parameter("E", 1e5, 1e7, "log")], [gf.Target("angle", 22.0)])
    solver = PythonCallable(lambda p, s: {"angle": 1.0}, identity="drum")
    records = [run(solver, {"E": value}, 1) for value in (-1.0, 0.0, 9e3, 1.1e4, 9e7)]
    found = runs_of(problem, {"drum": solver}, records)
    assert [e.proposal.parameters["E"] for e in found] == [1.1e4, 9e7]


def test_with_several_tests_a_point_counts_when_all_of_them_were_run_with_its_seed() -> None:
    problem, one = drum()
    two = PythonCallable(lambda p, s: {"angle": p["rolling"]}, identity="heap")
    values = {"sliding": 0.3, "rolling": 0.4}
    records = [run(one, values, 1), run(two, values, 1), run(one, values, 2)]
    [found] = runs_of(problem, {"drum": one, "heap": two}, records)
    assert set(found.responses) == {"drum.angle", "heap.angle"}


def test_a_test_that_takes_fewer_parameters_is_joined_with_those_that_take_them_all() -> None:
    problem, one = drum()
    two = ParametersFor(
        PythonCallable(lambda p, s: {"angle": p["rolling"]}, identity="heap"),
        takes={"rolling"}.__contains__,
    )
    records = [
        run(one, {"sliding": sliding, "rolling": rolling}, seed)
        for sliding, rolling, seed in ((0.3, 0.4, 1), (0.5, 0.4, 1), (0.3, 0.6, 1), (0.3, 0.4, 2))
    ]
    found = runs_of(problem, {"heap": two, "drum": one}, [*records, run(two, {"rolling": 0.4}, 1)])
    assert [evaluation.proposal.parameters for evaluation in found] == [
        {"sliding": 0.3, "rolling": 0.4},
        {"sliding": 0.5, "rolling": 0.4},
    ]


def test_the_order_of_the_store_does_not_count() -> None:
    problem, solver = drum()
    generator = random.Random(1)
    records = [
        run(solver, {"sliding": generator.uniform(0.1, 0.9), "rolling": 0.5}, seed)
        for seed in range(20)
    ]
    assert runs_of(problem, {"drum": solver}, records) == runs_of(
        problem, {"drum": solver}, records[::-1]
    )


def angles(values: list[tuple[float, float]], scatter: float = 0.0) -> list[Evaluation]:
    generator = random.Random(1)
    return [
        Evaluation(
            Proposal({"sliding": x, "rolling": y}, seed, "design"),
            {"angle": Response(10 + 20 * x + generator.gauss(0, scatter))},
        )
        for seed, (x, y) in enumerate(values)
    ]


def test_of_too_many_runs_those_near_the_answer_are_taken_and_some_from_everywhere() -> None:
    problem, _ = drum()
    generator = random.Random(2)
    values = [(generator.uniform(0.1, 0.9), generator.uniform(0.1, 0.9)) for _ in range(1000)]
    place = {"sliding": 0.6, "rolling": 0.5}
    evaluations = angles(values)
    chosen = nearest_runs(problem, evaluations, place, most=100)
    ranked = sorted(values, key=lambda v: (v[0] - 0.6) ** 2 + (v[1] - 0.5) ** 2)
    taken = {tuple(e.proposal.parameters.values()) for e in chosen}
    assert len(chosen) == 100
    assert taken >= set(ranked[:50])
    assert taken & set(ranked[900:])
    assert nearest_runs(problem, evaluations[:100], place, most=100) == evaluations[:100]


def test_runs_are_not_taken_because_of_what_they_gave() -> None:
    """At one place, the runs that hit the target by chance would make the scatter look small."""
    problem, _ = drum()
    generator = random.Random(3)
    values = [(0.6, generator.uniform(0.1, 0.9)) for _ in range(1000)]
    chosen = nearest_runs(problem, angles(values, scatter=2.0), most=150)
    off = [e.responses["angle"].value - 22.0 for e in chosen]
    assert stdev(off) == pytest.approx(2.0, rel=0.15)


def test_runs_within_the_intervals_come_before_those_beyond_and_nearer_ones_before_others() -> None:
    problem, _ = drum()
    inside = [(0.1 + 0.08 * number, 0.5) for number in range(10)]
    beyond = [(0.9 + 0.02 * number, 0.5) for number in range(20, 0, -1)]
    chosen = nearest_runs(problem, angles([*beyond, *inside]), most=15)
    assert {e.proposal.parameters["sliding"] for e in chosen} == {
        x for x, _ in [*inside, *beyond[-5:]]
    }


@pytest.mark.parametrize("strategy", ["sequential", "staged"])
def test_runs_beyond_the_intervals_teach_but_the_answer_stays_within(
    tmp_path: Path, strategy: str
) -> None:
    """The first material is beyond the bound of the second, whose target is best met there."""

    def simulate(parameters: dict[str, float], seed: int) -> dict[str, float]:
        noise = random.Random(seed).gauss(0, 0.05)
        return {"angle": 10 + 20 * parameters["sliding"] + noise}

    solver = PythonCallable(simulate, identity="drum")
    wide, target = gf.Parameter("sliding", 0.4, 1.0), gf.Target("angle", 26.2, tolerance=0.3)
    gf.calibrate(gf.Problem([wide], [target]), solver, workdir=tmp_path, strategy=strategy)
    narrow = gf.Problem([gf.Parameter("sliding", 0.3, 0.8)], [target])
    result = gf.calibrate(narrow, solver, workdir=tmp_path, strategy=strategy)
    saved = gf.open(tmp_path)
    beyond = [e for e in saved.warm_start if e.proposal.parameters["sliding"] > 0.8]
    assert beyond
    assert saved.analyse().metamodels.models[0].n == len(saved.known)
    assert result.parameters["sliding"] <= 0.8
    assert result.intervals["sliding"].high <= 0.8
    assert all(e.proposal.parameters["sliding"] <= 0.8 for e in saved.evaluations)


def test_runs_beyond_the_intervals_replace_no_run_of_the_design(tmp_path: Path) -> None:
    solver = PythonCallable(lambda p, s: {"angle": 10 + 20 * p["sliding"]}, identity="drum")
    target = gf.Target("angle", 20.0)
    gf.calibrate(
        gf.Problem([gf.Parameter("sliding", 0.45, 0.6)], [target]), solver, workdir=tmp_path
    )
    narrow = gf.Problem([gf.Parameter("sliding", 0.1, 0.44)], [replace(target, value=15.0)])
    result = gf.calibrate(narrow, solver, workdir=tmp_path)
    assert result.runs.warm_start_runs > 4
    assert result.runs.design == 4
    assert result.status == "calibrated"


@pytest.mark.parametrize("strategy", ["sequential", "staged"])
def test_a_calibration_with_runs_from_elsewhere_is_resumed_as_it_was(
    tmp_path: Path, strategy: str
) -> None:
    def simulate(parameters: dict[str, float], seed: int) -> dict[str, float]:
        noise = random.Random(seed).gauss(0, 0.1)
        return {"angle": 10 + 20 * parameters["sliding"] + 8 * parameters["rolling"] + noise}

    problem, _ = drum()
    solver = PythonCallable(simulate, identity="drum")
    gf.calibrate(problem, solver, workdir=tmp_path / "first", strategy=strategy)
    other = gf.Problem(problem.parameters, [gf.Target("angle", 26.0)])
    folder = tmp_path / "second"
    sources = [tmp_path / "first"]
    whole = gf.calibrate(other, solver, workdir=folder, runs_from=sources, strategy=strategy)
    assert whole.runs.warm_start_runs > 0
    again = gf.calibrate(other, solver, workdir=folder, strategy=strategy)
    assert again.history == whole.history
    assert again.parameters == whole.parameters
    assert again.runs.warm_start_runs == whole.runs.warm_start_runs
    assert again.runs.reused == again.runs.total


@pytest.mark.parametrize("given", [lambda folder: [folder], str, Path])
def test_a_source_that_is_no_work_folder_is_an_error(
    tmp_path: Path, given: Callable[[Path], Any]
) -> None:
    problem, solver = drum()
    with pytest.raises(gf.InputError, match=messages.NO_WORK_FOLDER.pattern):
        gf.calibrate(problem, solver, runs_from=given(tmp_path))
    assert not list(tmp_path.iterdir())


def slide(identity: str = "drum", response: str = "angle") -> Solver:
    return PythonCallable(lambda p, s: {response: p["sliding"]}, [response], identity=identity)


def why_none(
    solver: Solver,
    test: str = "drum",
    interval: tuple[float, float] = (0.1, 0.9),
    response: str = "angle",
    *known: dict[str, float],
) -> str:
    """Return why a source has no run for a test; its runs are of a drum."""
    source = RunStore.in_memory()
    for values in known or ({"sliding": 0.2}, {"sliding": 0.5}):
        source.save(run(slide(), values, 1))
    problem = gf.Problem([gf.Parameter("sliding", *interval)], [gf.Target(response, 20.0)])
    return why_unused(source, problem, {test: solver})


def test_a_source_of_which_no_run_is_used_has_a_reason() -> None:
    assert why_none(slide()) == why_none(slide(), interval=(0.55, 0.9)) == ""
    beyond = why_none(slide(), interval=(0.95, 0.99))
    assert messages.BEYOND_INTERVALS.is_in(beyond, name="sliding", there="0.2 to 0.5")
    flow = why_none(slide(response="flow"), response="flow")
    assert messages.WITHOUT_RESPONSES.is_in(flow, names="flow")
    assert messages.OTHER_MODEL.is_in(why_none(slide("new")), test="drum")
    assert messages.OTHER_TESTS.is_in(why_none(slide("new"), "heap"), theirs="drum", ours="heap")


def test_a_source_of_other_fixed_parameters_has_a_reason() -> None:
    def why(**fixed: float) -> str:
        rolling = {"sliding": 0.2, "rolling": 0.3}
        return why_none(ParametersFor(slide(), fixed), "drum", (0.1, 0.9), "angle", rolling)

    assert why(rolling=0.3) == ""
    assert messages.OTHER_FIXED_VALUE.is_in(why(rolling=0.4), here="0.4", there="0.3")
    assert messages.PARAMETER_NOT_HERE.is_in(why(), name="rolling")
    assert messages.PARAMETER_NOT_THERE.is_in(why(rolling=0.3, damping=1.0), name="damping")


def test_a_source_of_which_no_run_is_used_is_named_before_the_first_run(tmp_path: Path) -> None:
    problem, _ = drum()
    narrow = gf.Problem(problem.parameters[:1], [gf.Target("angle", 0.3)])
    gf.calibrate(narrow, slide(), workdir=tmp_path / "other")
    seen: list[gf.Progress] = []

    def calibrated(solver: Solver) -> list[str]:
        seen.clear()
        result = gf.calibrate(narrow, solver, runs_from=tmp_path / "other", on_progress=seen.append)
        return [notice for notice in result.notices if messages.NO_RUN_USED.is_in(notice)]

    [notice] = calibrated(slide("new"))
    assert seen[0].notices == (notice,)
    assert seen[0].done == 0
    assert not calibrated(slide())
