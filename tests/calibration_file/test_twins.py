"""`[strategy] twins`: a calibration for the real apparatus by runs of smaller ones."""

from __future__ import annotations

import json
import math
import sqlite3
import time
from collections.abc import Callable
from dataclasses import replace
from html import unescape
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

import grainfit as gf
from grainfit.bulk_tests import messages as of_bulk_tests
from grainfit.bulk_tests.size import resized
from grainfit.calibration.twins import SizeRatio, Twins, combined
from grainfit.calibration_file import messages
from grainfit.calibration_file.plan import describe_plan
from grainfit.calibration_file.real_size import AllRuns, RealSizeCalibration, RealSizeOptions
from grainfit.calibration_file.run_time import costs_of_runs
from grainfit.calibration_file.twins import series_of_sizes
from grainfit.cli.app import app
from grainfit.errors import InputError
from grainfit.evaluation import Evaluation, Proposal
from grainfit.report import messages as of_pages
from grainfit.report import verdict_messages as of_report
from grainfit.result import RunCounts, RunSummary
from grainfit.solvers.own_model.python_callable import PythonCallable
from grainfit.verdict import messages as of_verdict
from grainfit.verdict.reasons import FullSizeMade, FullSizePending, RealTest
from grainfit.verdict.rule import probability_within

POT = """
name = "pot"
[particle]
diameter = "10 mm"
youngs_modulus = "0.2 MPa"
poissons_ratio = 0.22
density = { min = "1400 kg/m^3", max = "2800 kg/m^3" }
[wall]
youngs_modulus = "211 GPa"
poissons_ratio = 0.30
density = "7700 kg/m^3"
[particle_particle]
sliding_friction = 0.18
rolling_friction = 0.1
restitution = 0.5
rolling_damping = 0.0
[particle_wall]
sliding_friction = 0.27
rolling_friction = 0.05
restitution = 0.5
rolling_damping = 0.0
[[test]]
type = "packing"
solver = "lammps"
cylinder_radius = "40 mm"
fill_height = "90 mm"
targets.bulk_density = { value = "1200 kg/m^3", uncertainty = "3 %" }
[strategy]
twins = 150
workers = 1
"""


def written(folder: Path, text: str = POT, **changes: str) -> Path:
    for old, new in changes.items():
        text = text.replace(old, new)
    path = folder / "pot.toml"
    path.write_text(text)
    return path


@pytest.mark.slow
def test_an_answer_is_predicted_until_the_real_apparatus_was_run(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    setup = gf.load(written(tmp_path))
    # Ctrl-C between the phases: a part of the work is done at each start.
    phases: list[str] = []

    def stop(words: str) -> None:
        phases.append(words)
        if len(phases) % 3 == 0:
            raise KeyboardInterrupt

    interrupted = setup.calibrate(on_phase=stop)
    assert interrupted.status == "interrupted"
    assert gf.open("pot.grainfit").state == "predicted"
    assert of_verdict.NOT_MEASURED.is_in(str(interrupted))
    before = time.monotonic()
    predicted = setup.calibrate()
    assert predicted.status == "predicted"
    assert predicted.wall_seconds == pytest.approx(time.monotonic() - before, abs=0.5)
    # Every run of the searches and of the sizes, of which those of the first start are known.
    runs = predicted.runs
    assert runs.sizes >= 9
    assert runs.total == runs.design + runs.optimisation + runs.verification + runs.sizes
    with sqlite3.connect("pot.grainfit/runs.sqlite") as store:
        [(made,)] = store.execute("SELECT count(*) FROM runs")
    assert runs.total == made
    assert 0 < runs.reused < runs.total
    assert runs.warm_start_runs == 0
    assert not of_verdict.NOT_MEASURED.is_in(str(predicted))
    [pending] = [one for one in predicted.reasons if isinstance(one, FullSizePending)]
    [test] = pending.tests
    assert (test.test, test.particles, test.simulated) == ("packing", 502, 150)
    found = predicted.responses["bulk_density"]
    assert (found.target, found.verified_values) == (1200.0, ())
    assert found.standard_error > 2.0

    _is_shown_as_predicted()

    done = CliRunner().invoke(app, ["run", "pot.toml", "--full-size", "--no-report"])
    assert done.exit_code == 0, done.output
    assert of_verdict.FULL_SIZE_AGREES.is_in(done.output)
    verified = gf.Result.from_json("pot.grainfit/result.json")
    assert verified.utilisation > 0.1
    [made] = [one for one in verified.reasons if isinstance(one, FullSizeMade)]
    assert made.found == pytest.approx(1200, rel=0.03)
    # The run is known: no start makes it, or forgets it, again.
    assert setup.calibrate().status == "calibrated"
    assert gf.open("pot.grainfit").state == "calibrated"


def _is_shown_as_predicted() -> None:
    status = CliRunner().invoke(app, ["status", "pot.grainfit"])
    assert "pot: predicted" in status.output
    assert CliRunner().invoke(app, ["report", "pot.grainfit"]).exit_code == 0
    report = Path("pot.grainfit/report.html").read_text()
    assert of_report.PREDICTED() in report
    assert "Test packing: " in report
    assert of_bulk_tests.SMALLER(test="Test packing") + ": " in report
    # The target of a picture is what the smaller apparatus would give.
    assert of_pages.AT_THIS_SIZE.is_in(unescape(_line_with("measured: <strong>", report)))
    card = json.loads(CliRunner().invoke(app, ["export", "pot.grainfit", "--to", "json"]).stdout)
    assert card["status"] == "predicted"
    apparatus = dict(line.split(": ", 1) for line in card["apparatus"])
    assert "cylinder radius 40 mm" in apparatus["Apparatus of packing, given"]
    smaller = apparatus["Apparatus of packing, smaller in the search, given"]
    assert "cylinder radius " in smaller
    assert "cylinder radius 40 mm" not in smaller


def _line_with(words: str, text: str) -> str:
    return next(line for line in text.splitlines() if words in line)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"twins = 150": "twins = 150\nsmaller = 0.5"}, messages.TWINS_AND_RELATIVES),
        (
            {
                "[strategy]": "[[test]]\ntype = 'python'\nname = 'own'\nfunction = 'own.py:f'\n"
                "targets.y = { value = 1, tolerance = 1 }\n[strategy]"
            },
            messages.UNKNOWN_SIZE,
        ),
        (
            {
                '"packing"': '"draw_down"',
                "cylinder_radius": "width",
                "bulk_density": "mass_flow",
                'fill_height = "90 mm"': "",
                "1200 kg/m^3": "1 kg/s",
                '"40 mm"': '"300 mm"',
                "twins = 150": "twins = 1500",
            },
            messages.NOT_COMPARED,
        ),
    ],
)
def test_what_has_no_twin_is_refused(tmp_path: Path, changes: dict, message) -> None:
    (tmp_path / "own.py").write_text("def f(parameters, seed):\n    return {'y': 1.0}\n")
    with pytest.raises(InputError) as caught:
        gf.load(written(tmp_path, **changes))
    assert message.is_in(str(caught.value))
    assert "strategy.twins" in str(caught.value)


def test_small_tests_are_simulated_as_they_are(tmp_path: Path) -> None:
    setup = gf.load(written(tmp_path, **{"twins = 150": "twins = 2000"}))
    assert setup.twins == {}
    assert messages.ALL_SMALL(twins=2000) in describe_plan(setup).lines


def test_check_says_what_is_simulated(tmp_path: Path) -> None:
    plan = describe_plan(gf.load(written(tmp_path)))
    [line] = [one for one in plan.lines if messages.TWINS_SIMULATED.is_in(one)]
    assert "150" in line
    assert "502" in line


def test_check_counts_the_runs_and_the_time_of_all_sizes(tmp_path: Path) -> None:
    setup = gf.load(written(tmp_path))
    whole, series = describe_plan(setup), series_of_sizes(setup.solvers, setup.twins, setup.problem)
    search = describe_plan(replace(setup, twins={}))
    # Three sizes with three seeds, one to three times; at each new answer three fresh seeds.
    assert series.runs == 9
    assert whole.runs == (search.runs[0] + 9, search.runs[1] + 3 * (9 + 3))
    assert any(messages.RUNS_WITH_SIZES.is_in(one, high=whole.runs[1]) for one in whole.lines)
    [cost] = costs_of_runs(setup.problem, setup.simulated).values()
    assert whole.seconds[0] == pytest.approx(search.runs[0] * cost + series.seconds)
    assert whole.seconds[1] == pytest.approx((search.runs[1] + 9) * cost + 3 * series.seconds)


def made(mean: float, half: float, predicted: float, predicted_half: float) -> FullSizeMade:
    return FullSizeMade("angle", "deg", mean, half, predicted, predicted_half)


def test_a_run_at_full_size_is_weighed_with_what_agrees_with_it() -> None:
    # Equal errors: the middle, with the error of a mean of two.
    assert combined(made(30.0, 1.96, 31.0, 1.96)) == pytest.approx((30.5, 1 / math.sqrt(2)))
    # Beyond both intervals the run counts alone.
    assert combined(made(30.0, 1.96, 34.0, 1.96)) == pytest.approx((30.0, 1.0))
    assert of_verdict.FULL_SIZE_DIFFERS.is_in(str(made(30.0, 1.96, 34.0, 1.96)))


def test_time_and_runs_are_those_of_all_searches_and_sizes(monkeypatch: pytest.MonkeyPatch) -> None:
    clock = iter([0.0, 10.0, 40.0, 100.0])
    monkeypatch.setattr(time, "monotonic", lambda: next(clock))
    runs = AllRuns(workers=2)

    def searched(seconds: float, busy: float, warm: int, *made: str) -> gf.Result:
        counts = RunCounts(design=len(made), total=len(made), warm_start_runs=warm)
        history = tuple(RunSummary("design", {}, 1, {}, {}, {"": run}) for run in made)
        parts = "predicted", {}, {}, counts, None, None, None, seconds, busy
        return gf.Result(*parts, 1.0, "", "", "sequential", 1, "0", history=history)

    first = runs.with_search(searched(10.0, 0.8, 0, "a", "b"))
    assert (first.wall_seconds, first.utilisation) == (10.0, pytest.approx(0.8))
    proposal = Proposal({}, 1, "design")
    sizes = Evaluation(proposal, {}, runs={"": "c"}, simulated_seconds=20.0)
    known = Evaluation(proposal, {}, runs={"": "d"}, reused=1, seconds=9.0)
    runs.add_sizes([sizes, known])
    # Of the runs that the second search knows, all are those of the first.
    second = runs.with_search(searched(4.0, 0.5, 2, "e"))
    assert second.wall_seconds == 40.0
    assert second.utilisation == pytest.approx((16 + 20 + 4) / 80)
    assert second.runs == RunCounts(design=3, reused=1, total=5, sizes=2)
    # A run at full size follows.
    runs.add_sizes([Evaluation(proposal, {}, runs={"": "f"}, simulated_seconds=60.0)])
    last = runs.counted(second)
    assert (last.wall_seconds, last.utilisation) == (100.0, pytest.approx(0.5))


class Poured(PythonCallable):
    """A packing that becomes denser with its size, by a formula."""

    def __init__(self, test: gf.tests.Packing) -> None:
        self.test = test

        def density(p: dict[str, float], seed: int) -> dict[str, float]:
            walls = 1 - 0.3 / test.number_of_particles ** (1 / 3)
            scatter = np.random.default_rng(seed).normal(0.0, 2.0)
            return {"bulk_density": 0.6 * p["particle.density"] * walls + scatter}

        super().__init__(density, ["bulk_density"], identity=f"{test.number_of_particles}")

    @property
    def bulk_test(self) -> gf.tests.Packing:
        return self.test

    def of_test(self, test: gf.tests.Packing) -> Poured:
        return Poured(test)

    def estimate_cost_of(self, test, parameters) -> None:
        return None

    def default_timeout(self, parameters) -> None:
        return None


@pytest.mark.parametrize("stopped_in", ["first search", "sizes", "second search"])
def test_a_finished_result_survives_ctrl_c_in_a_search_before_its_own(
    tmp_path: Path, stopped_in: str
) -> None:
    problem = gf.Problem(
        [gf.Parameter("particle.density", 1400.0, 2800.0)],
        [gf.Target("bulk_density", 1200.0, uncertainty=36.0)],
    )
    large = Poured(gf.tests.Packing(diameter="10 mm", cylinder_radius="40 mm", fill_height="90 mm"))
    small = large.of_test(resized(large.test, 0.3))
    phases: list[str] = []

    def start(stop: Callable[[], None] = lambda: None) -> gf.Result:
        phases.clear()

        def search(twins: Twins) -> gf.Result:
            return gf.calibrate(
                problem,
                {"packing": small},
                workdir=tmp_path,
                twins=twins,
                on_progress=lambda progress: stop() if progress.done == 3 else None,
            )

        def say(words: str) -> None:
            phases.append(words)
            if len(phases) == 2:
                stop()

        named = {"packing": large}, {"packing": small}
        options = RealSizeOptions(0.95, full_size=True, on_phase=say)
        return RealSizeCalibration(problem, *named, tmp_path, search, options).run()

    first = start()
    assert first.status == "calibrated"
    kept = (tmp_path / "result.json").read_bytes()

    def interrupt() -> None:
        if len(phases) == ["first search", "sizes", "second search"].index(stopped_in) + 1:
            raise KeyboardInterrupt

    stopped = start(interrupt)

    assert (tmp_path / "result.json").read_bytes() == kept
    assert stopped == replace(first, status="interrupted")
    assert gf.open(tmp_path).state == "calibrated"
    assert gf.open(tmp_path).result == first


def test_the_probability_of_a_response_within_its_tolerance() -> None:
    assert probability_within(30.0, 0.5, 30.0, 0.98) == pytest.approx(0.95, abs=1e-3)
    assert probability_within(30.0, 0.0, 31.0, 0.5) == 0.0


def test_targets_are_those_of_the_laboratory_and_less_sure() -> None:
    problem = gf.Problem([gf.Parameter("mu", 0.1, 0.9)], [gf.Target("angle", 30.0, uncertainty=3)])
    twins = Twins({"angle": SizeRatio(0.9, 4.0)}, (RealTest("heap", 50_000, 1500),), True)
    real = twins.problem(problem)
    assert real.targets[0].value == 30.0
    assert real.targets[0].tolerance == 3.0
    assert real.targets[0].uncertainty == pytest.approx(5.0)
    # A first search is no finer than ratios that are not measured yet.
    first = replace(twins, are_measured=False).problem(problem)
    assert first.targets[0].tolerance == pytest.approx(5.0)
    found = gf.calibrate(problem, lambda p, seed: {"angle": 10 + 40 * p["mu"]}, twins=twins, seed=2)
    assert found.status == "predicted"
    # 0.9 (10 + 40 mu) = 30.
    assert found.parameters["mu"] == pytest.approx(0.583, abs=0.01)
    assert found.responses["angle"].predicted == pytest.approx(30.0, abs=0.3)
    assert found.responses["angle"].standard_error >= 4.0
    assert found.probability_all_met is not None
    assert found.probability_all_met < 0.6


def test_a_target_out_of_reach_has_both_uncertainties_by_name(tmp_path: Path) -> None:
    problem = gf.Problem([gf.Parameter("mu", 0.1, 0.9)], [gf.Target("angle", 60.0, tolerance=1)])
    twins = Twins({"angle": SizeRatio(1.0, 2.0)}, (RealTest("heap", 50_000, 1500),), True)
    found = gf.calibrate(problem, lambda p, seed: {"angle": 10 + 40 * p["mu"]}, twins=twins, seed=2)

    assert found.status == "unreachable"
    [miss] = found.out_of_reach
    expected = f"{found.responses['angle'].expected[1]:.1f}"
    assert expected == "3.9"
    words = of_verdict.WITH_RATIO(nearest=f"{miss.nearest:.1f} \u00b1 {expected}")
    assert words in str(miss)
    found.to_json(tmp_path / "result.json")
    assert gf.Result.from_json(tmp_path / "result.json").out_of_reach == found.out_of_reach
