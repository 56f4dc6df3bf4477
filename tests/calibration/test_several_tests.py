"""Calibrations with several tests: each is run where it is worth its time, and no more."""

from __future__ import annotations

import pickle
import re
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import grainfit as gf
from grainfit.calibration import messages
from grainfit.calibration.readiness import obstacles
from grainfit.calibration.scopes import restricted, with_scopes
from grainfit.calibration_file.build import load_calibration
from grainfit.calibration_file.plan import describe_plan
from grainfit.campaign.store.store import RunStore
from grainfit.errors import InputError
from grainfit.evaluation import Evaluation, Proposal
from grainfit.metamodels.kriging import Kriging
from grainfit.solvers.own_model import messages as of_own_model
from grainfit.solvers.own_model.python_callable import PythonCallable
from grainfit.strategies.run_costs import RunCosts

calls: Counter[str] = Counter()


def heap(parameters: dict[str, float], seed: int) -> dict[str, float]:
    """A noisy test of both parameters; it counts its runs and can be interrupted."""
    calls["heap"] += 1
    if calls["heap"] == calls["interrupt at"]:
        raise KeyboardInterrupt
    noise = np.random.default_rng([seed, 1]).standard_normal()
    return {"angle": 20 + 15 * parameters["friction"] - 6 * parameters["bounce"] + 0.7 * noise}


def drop(parameters: dict[str, float], seed: int) -> dict[str, float]:
    """A precise test of one parameter."""
    calls["drop"] += 1
    assert set(parameters) == {"bounce"}, "a run is passed only what its test depends on"
    noise = np.random.default_rng([seed, 2]).standard_normal()
    return {"rebound": 100 * parameters["bounce"] ** 2 + 0.05 * noise}


class Needs(PythonCallable):
    """A function that depends on some parameters."""

    def __init__(self, function, names: Sequence[str] = ()) -> None:
        super().__init__(function)
        self._names = names

    def depends_on(self, names: Sequence[str]) -> tuple[str, ...]:
        return tuple(name for name in names if not self._names or name in self._names)


@pytest.fixture(autouse=True)
def _fresh() -> None:
    calls.clear()


def problem() -> gf.Problem:
    return gf.Problem(
        [gf.Parameter("friction", 0.1, 0.9), gf.Parameter("bounce", 0.3, 0.95)],
        [
            gf.Target("heap.angle", 24.0, tolerance=0.5),
            gf.Target("drop.rebound", 36.0, tolerance=1.0),
        ],
    )


def solvers() -> dict[str, gf.Solver]:
    return {"heap": Needs(heap), "drop": Needs(drop, ["bounce"])}


def scoped(**seconds: float) -> gf.Problem:
    return replace(
        problem(),
        tests=[
            gf.TestScope("heap", ["heap.angle"], ["friction", "bounce"], seconds.get("heap")),
            gf.TestScope("drop", ["drop.rebound"], ["bounce"], seconds.get("drop")),
        ],
    )


# A calibration ------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def whole() -> gf.Result:
    return gf.calibrate(problem(), solvers(), seed=2)


def asked_tests(result: gf.Result) -> list[tuple[str, ...]]:
    return [tuple(run.runs) for run in result.history]


def test_two_tests_calibrate_with_fewer_runs_of_the_precise_one(whole: gf.Result) -> None:
    assert whole.status == "calibrated"
    assert whole.parameters["bounce"] == pytest.approx(0.6, abs=0.02)
    count = Counter(test for tests in asked_tests(whole) for test in tests)
    assert whole.runs.total == sum(count.values())
    # Two parameters need 5 runs of a design, one needs 4.
    design = Counter(t for r in whole.history if r.stage == "design" for t in r.runs)
    assert design == {"heap": 5, "drop": 4}
    assert count["drop"] < count["heap"]


def test_a_response_that_scatters_little_is_verified_by_two_fresh_seeds() -> None:
    # With few runs of the drop, its scatter is not known to be little, and three are made.
    found = gf.calibrate(problem(), solvers(), seed=3).responses
    assert len(found["drop.rebound"].verified_values) == 2
    assert len(found["heap.angle"].verified_values) >= 3


@pytest.mark.parametrize("interrupted_at", [7, "verification"])
def test_interrupted_between_the_tests_of_a_parameter_set_it_repeats_no_run(
    tmp_path: Path, whole: gf.Result, interrupted_at: int | str
) -> None:
    heaps = [run.stage for run in whole.history if "heap" in run.runs]
    if isinstance(interrupted_at, str):
        interrupted_at = heaps.index("verification") + 2
    calls["interrupt at"] = interrupted_at
    stopped = gf.calibrate(problem(), solvers(), seed=2, workdir=tmp_path)
    assert stopped.status == "interrupted"
    store = RunStore.in_folder(tmp_path)
    finished = Counter(run.test for run in store.runs("finished"))
    store.close()
    result = gf.calibrate(problem(), solvers(), seed=2, workdir=tmp_path)
    assert [(r.stage, r.seed, r.parameters, tuple(r.runs)) for r in result.history] == [
        (r.stage, r.seed, r.parameters, tuple(r.runs)) for r in whole.history
    ]
    assert result.runs.reused == sum(finished.values())
    count = Counter(test for tests in asked_tests(whole) for test in tests)
    # One more call of the heap: the interrupted one.
    assert (calls["heap"], calls["drop"]) == (count["heap"] + 1, count["drop"])


def test_a_saved_calibration_has_the_runs_of_each_test(tmp_path: Path, whole: gf.Result) -> None:
    told: list[gf.Progress] = []
    result = gf.calibrate(problem(), solvers(), seed=2, workdir=tmp_path, on_progress=told.append)
    assert told[-1].done == result.runs.total == whole.runs.total
    # Runs after the design are of one test: the best one says nothing about the answer.
    with_best = {progress.stage for progress in told if progress.best_deviation is not None}
    assert with_best == {"design"}
    saved = gf.open(tmp_path)
    assert [e.proposal.tests or ("heap", "drop") for e in saved.evaluations] == asked_tests(whole)
    assert saved.problem.tests == with_scopes(problem(), solvers()).tests
    assert saved.result is not None
    assert f"{result.runs.total} runs ended" in str(saved)
    assert set(result.intervals) == {"friction", "bounce"}


def test_no_more_runs_are_said_to_run_than_there_are_workers() -> None:
    told: list[gf.Progress] = []

    def on_progress(progress: gf.Progress) -> None:
        told.append(progress)
        if progress.done >= 4:
            raise KeyboardInterrupt

    gf.calibrate(problem(), solvers(), seed=2, workers=1, on_progress=on_progress)
    assert max(len(progress.pending) for progress in told) == 2
    assert max(progress.running for progress in told) == 1


def test_correlated_targets_of_two_tests_are_read_back(tmp_path: Path) -> None:
    pairs = (("heap.angle", "drop.rebound", 0.5),)
    known = replace(problem(), correlations=pairs)
    gf.calibrate(known, solvers(), workdir=tmp_path / "w", max_runs=16, seed=2)
    saved = gf.open(tmp_path / "w").problem
    assert saved.correlations == pairs
    assert [scope.parameters for scope in saved.tests] == [("friction", "bounce"), ("bounce",)]


def test_the_budget_counts_runs_of_any_test() -> None:
    result = gf.calibrate(problem(), solvers(), seed=2, max_runs=17)
    assert result.runs.total <= 17


def test_runs_of_one_test_alone_are_used_for_both(tmp_path: Path) -> None:
    friction = gf.Problem(
        [gf.Parameter("bounce", 0.3, 0.95)], [gf.Target("rebound", 36.0, tolerance=1.0)]
    )
    alone = gf.calibrate(friction, Needs(drop, ["bounce"]), seed=5, workdir=tmp_path)
    both = gf.calibrate(problem(), solvers(), seed=2, workdir=tmp_path)
    assert both.status == "calibrated"
    assert both.runs.warm_start_runs == alone.runs.total
    design = Counter(t for r in both.history if r.stage == "design" for t in r.runs)
    assert design == {"heap": 5}


def test_a_strategy_that_asks_for_all_tests_calibrates() -> None:
    result = gf.calibrate(problem(), solvers(), strategy=gf.Staged(design_runs=8), seed=1)
    assert result.status == "calibrated"
    search = [run for run in result.history if run.stage != "verification"]
    assert all(len(run.runs) == 2 for run in search)


# What a test depends on ---------------------------------------------------------------------


def test_a_run_is_the_same_at_all_values_of_what_its_test_does_not_depend_on() -> None:
    own = restricted(with_scopes(problem(), solvers()), solvers())
    runs = [own["drop"].definition({"friction": f, "bounce": 0.5}, 3) for f in (0.2, 0.8)]
    assert runs[0].identity == runs[1].identity
    # A test that depends on all has the identity that it has alone.
    values = {"friction": 0.2, "bounce": 0.5}
    assert own["heap"].definition(values, 3).identity == (
        Needs(heap).definition(values, 3).identity
    )


def test_restricted_solvers_can_be_sent_to_other_processes() -> None:
    model = gf.solvers.Command(Path(__file__).parent, ["true"], parameters={})
    own = restricted(problem(), {"a": model, "b": Needs(drop, ["bounce"])})
    assert pickle.loads(pickle.dumps(own["a"])).name == model.name


def test_a_metamodel_of_few_parameters_is_flat_along_the_others() -> None:
    random = np.random.default_rng(1)
    points = random.random((12, 2))
    values = points @ [3.0, -1.0] + np.sin(3 * points[:, 0]) + 0.05 * random.standard_normal(12)
    small = Kriging.fit(points, values)
    runs = random.random((12, 4))
    runs[:, [2, 0]] = points
    large = small.embedded([2, 0], runs)
    at = random.random((6, 4))
    for found, wanted in (
        (large.predict(at), small.predict(at[:, [2, 0]])),
        (
            large.condition_on_pending(at).predict(at),
            small.condition_on_pending(at[:, [2, 0]]).predict(at[:, [2, 0]]),
        ),
    ):
        assert found.mean == pytest.approx(wanted.mean, rel=1e-9)
        assert found.variance_of_mean == pytest.approx(wanted.variance_of_mean, rel=1e-6)
    slopes = large.gradients(at)
    assert slopes[:, [2, 0]] == pytest.approx(small.gradients(at[:, [2, 0]]), rel=1e-9)
    assert np.abs(slopes[:, [1, 3]]).max() < 1e-12


# Cost ---------------------------------------------------------------------------------------


def evaluated(test: str, bounce: float, seconds: float) -> Evaluation:
    proposal = Proposal({"friction": 0.5, "bounce": bounce}, 1, "design", (test,))
    return Evaluation(proposal, {}, test_seconds={test: seconds})


def test_costs_are_estimated_before_any_run_and_equal_when_not_known() -> None:
    centre = np.full((1, 2), 0.5)
    known = RunCosts(scoped(heap=100.0, drop=1000.0), [])
    heap_scope, drop_scope = scoped().scopes
    ratio = known.seconds(drop_scope, centre) / known.seconds(heap_scope, centre)
    assert ratio == pytest.approx(10, rel=0.3)
    unknown = RunCosts(scoped(heap=100.0), [])
    assert unknown.seconds(drop_scope, centre) == unknown.seconds(heap_scope, centre)


def test_costs_are_learnt_where_they_vary_over_the_intervals() -> None:
    own = scoped(heap=100.0, drop=1.0)
    bounces = np.linspace(0.3, 0.95, 8)
    # From 60 s to 600 s.
    runs = [evaluated("drop", b, 60 * 10 ** ((b - 0.3) / 0.65)) for b in bounces]
    costs = RunCosts(own, runs)
    ends = np.array([[0.5, 0.0], [0.5, 1.0]])
    assert costs.seconds(own.scopes[1], ends) == pytest.approx([61, 601], rel=0.35)
    assert costs.seconds(own.scopes[0], ends)[0] == costs.seconds(own.scopes[0], ends)[1]


def asked_after(seconds: Mapping[str, float]) -> Counter[str]:
    """Tests that a search asks for after its design, with these wall times."""
    search = gf.Sequential().start(scoped(), seed=4)
    asked: Counter[str] = Counter()
    for _ in range(14):
        proposal = search.ask()
        if proposal is None:
            break
        tests = proposal.tests or ("heap", "drop")
        functions = {"heap": (heap, "heap.angle"), "drop": (noisy_drop, "drop.rebound")}
        responses = {}
        for test in tests:
            function, name = functions[test]
            (value,) = function(dict(proposal.parameters), proposal.seed).values()
            responses[name] = gf.Response(value)
        times = {test: seconds[test] for test in tests}
        search.tell(proposal, Evaluation(proposal, responses, test_seconds=times))
        if proposal.stage != "design":
            asked.update(tests)
    return asked


def noisy_drop(parameters: dict[str, float], seed: int) -> dict[str, float]:
    noise = np.random.default_rng([seed, 2]).standard_normal()
    return {"rebound": 100 * parameters["bounce"] ** 2 + noise}


def test_the_cheap_one_of_two_equally_telling_tests_is_asked_for() -> None:
    cheap, dear = ({"heap": 30.0, "drop": drop} for drop in (30.0, 30000.0))
    assert asked_after(cheap)["drop"] > asked_after(dear)["drop"]


# Check and run ------------------------------------------------------------------------------

FILE = """
name = "two models"
[parameters]
friction = {{ min = 0.1, max = 0.9 }}
bounce = {{ min = 0.3, max = 0.95 }}
{more}
[[test]]
name = "heap"
type = "command"
folder = "heap"
command = ["true"]
targets.angle = {{ value = 24.0, tolerance = 0.5 }}
[[test]]
name = "drop"
type = "command"
folder = "drop"
command = ["true", "{{{{ bounce }}}}"]
{drop}
targets.rebound = {{ value = 36.0, tolerance = 1.0 }}
"""


def written(folder: Path, more: str = "", drop: str = "") -> Path:
    for name in ("heap", "drop"):
        (folder / name).mkdir()
    (folder / "heap" / "in.j2").write_text("{{ friction }} {{ bounce }}")
    (folder / "drop" / "readme").write_text("nothing")
    path = folder / "two.toml"
    path.write_text(FILE.format(more=more, drop=drop))
    return path


def test_a_model_need_not_mention_what_another_test_depends_on(tmp_path: Path) -> None:
    setup = load_calibration(written(tmp_path))
    assert [scope.parameters for scope in setup.problem.tests] == [
        ("friction", "bounce"),
        ("bounce",),
    ]
    assert describe_plan(setup).problems == ()
    assert list(obstacles(setup.problem, setup.solvers)) == []


def test_a_parameter_that_no_test_mentions_is_refused_by_check_and_run(tmp_path: Path) -> None:
    path = written(tmp_path, more="fricton = { min = 0.1, max = 0.9 }")
    setup = load_calibration(path)
    [words] = describe_plan(setup).problems
    assert re.search(rf"two\.toml: fricton: {messages.IDLE_PARAMETER.pattern}", words)
    with pytest.raises(InputError, match=rf"^fricton: {messages.IDLE_PARAMETER.pattern}"):
        setup.calibrate(tmp_path / "work")


def test_the_file_can_say_what_a_test_depends_on(tmp_path: Path) -> None:
    setup = load_calibration(written(tmp_path, drop='parameters = ["bounce"]'))
    assert setup.problem.tests[1].parameters == ("bounce",)


def test_what_the_file_says_and_the_model_does_not_is_refused_by_check_and_run(
    tmp_path: Path,
) -> None:
    path = written(tmp_path, drop='parameters = ["friction"]')
    (tmp_path / "heap" / "in.j2").write_text("{{ friction }}")
    setup = load_calibration(path)
    undefined, unmentioned, unused = describe_plan(setup).problems
    said = "test drop, friction: is mentioned nowhere in the model"
    assert re.search(
        rf"test drop, command\[1\], line 1: {of_own_model.UNDEFINED.matching(name='bounce')}",
        undefined,
    )
    assert said in unmentioned
    assert re.search(rf"two\.toml: bounce: {messages.IDLE_PARAMETER.pattern}", unused)
    with pytest.raises(InputError, match=said):
        setup.calibrate(tmp_path / "work")


def test_a_name_that_is_no_free_parameter_is_refused_with_its_key(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"test 2, parameters: name 'bonce'"):
        load_calibration(written(tmp_path, drop='parameters = ["bonce"]'))


def test_a_test_that_depends_on_nothing_free_is_refused_by_check_and_run(tmp_path: Path) -> None:
    path = written(tmp_path)
    path.write_text(path.read_text().replace('"true", "{{ bounce }}"', '"true"'))
    setup = load_calibration(path)
    assert re.search(f"drop: {messages.IDLE_TEST.pattern}", describe_plan(setup).problems[0])
    with pytest.raises(InputError, match=f"drop: {messages.IDLE_TEST.pattern}"):
        setup.calibrate(tmp_path / "work")


@pytest.mark.parametrize("seed", [1, 2])
def test_two_tests_of_one_parameter_are_both_run_until_their_scatter_is_known(
    seed: int, tmp_path: Path
) -> None:
    def density(slope: float, base: float) -> PythonCallable:
        def simulate(parameters: dict[str, float], seed: int) -> dict[str, float]:
            noise = np.random.default_rng([seed, int(base)]).standard_normal()
            return {"density": base + slope * parameters["x"] + 8 * noise}

        return PythonCallable(simulate)

    wanted = {"loose": 1215.0, "tapped": 1204.0}
    targets = [gf.Target(f"{n}.density", v, uncertainty=0.01 * v) for n, v in wanted.items()]
    result = gf.calibrate(
        gf.Problem([gf.Parameter("x", 0.0, 1.0)], targets),
        {"loose": density(700.0, 900.0), "tapped": density(720.0, 880.0)},
        workdir=tmp_path,
        workers=1,
        seed=seed,
    )

    assert result.status == "calibrated"
    assert result.runs.total < 25
    assert result.parameters["x"] == pytest.approx(0.45, abs=0.03)


@pytest.mark.parametrize(("design_runs", "failures"), [(4, 0), (None, 1)])
def test_a_test_with_too_few_runs_for_a_trend_is_run_again(
    design_runs: int | None, failures: int
) -> None:
    failed: list[float] = []

    def angle(parameters: dict[str, float], seed: int) -> dict[str, float]:
        noise = np.random.default_rng(seed).standard_normal()
        return {"angle": 10 + 40 * parameters["x"] + 0.5 * noise}

    def flow(parameters: dict[str, float], seed: int) -> dict[str, float]:
        if len(failed) < failures:
            failed.append(parameters["x"])
            raise gf.RunFailedError("it jammed")
        noise = np.random.default_rng([seed, 2]).standard_normal()
        return {"flow": 2 + 20 * parameters["x"] + 0.3 * noise}

    targets = [
        gf.Target("heap.angle", 30.0, tolerance=0.8),
        gf.Target("funnel.flow", 12.0, tolerance=0.5),
    ]
    result = gf.calibrate(
        gf.Problem([gf.Parameter("x", 0.0, 1.0)], targets),
        {"heap": PythonCallable(angle), "funnel": PythonCallable(flow)},
        strategy=gf.Sequential(design_runs=design_runs),
    )
    assert len(failed) == failures
    assert result.status == "calibrated", result
