"""Intervals hold their answers, and everything that shows them says the same."""

from __future__ import annotations

import json
import random
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import grainfit as gf
from grainfit.analysis.intervals import parameter_intervals
from grainfit.analysis.posterior import Posterior
from grainfit.calibration import messages
from grainfit.cards import render
from grainfit.formatting import ends, plain_ends
from grainfit.materials.time_step import RayleighTimeStep
from grainfit.problem import Parameter, Problem, Target
from grainfit.result import ParameterInterval, Result

SLIDING, ROLLING = "particle_particle.sliding_friction", "particle_particle.rolling_friction"
DENSITY, MODULUS = "particle.density", "particle.youngs_modulus"


def sample_of(problem: Problem, points: np.ndarray) -> Posterior:
    values = np.array([list(problem.from_unit(point).values()) for point in points])
    return Posterior(
        tuple(problem.parameters), points, values, values, True, "", float(len(points))
    )


@pytest.mark.parametrize("seed", range(40))
def test_every_answer_is_in_its_interval_which_holds_95_percent(seed: int) -> None:
    """Random problems, samples with one or two peaks or on a bound, and answers anywhere."""
    draw = np.random.default_rng(seed)
    dimension = int(draw.integers(1, 6))
    problem = Problem(
        [
            Parameter(f"p{number}", low, low * draw.uniform(1.5, 100), str(scale))
            for number, low, scale in zip(
                range(dimension),
                10 ** draw.uniform(-6, 6, dimension),
                draw.choice(["linear", "log"], dimension),
                strict=True,
            )
        ],
        [Target("angle", 30.0)],
    )
    centres = draw.choice([0.0, 1.0, *draw.random(3)], (2, dimension))
    spread = 10 ** draw.uniform(-4, 0)
    points = np.clip(
        centres[draw.integers(2, size=2000)] + spread * draw.normal(size=(2000, dimension)), 0, 1
    )
    posterior = sample_of(problem, points)
    position = draw.choice([0.0, 1.0, 0.5, *points[0], *draw.random(2)], dimension)
    answer = problem.from_unit(position)
    for name, found in parameter_intervals(posterior, problem, answer).items():
        low, high = posterior.interval(name)
        values = posterior.values[:, posterior.names.index(name)]
        assert found.low <= answer[name] <= found.high
        assert found.low <= low
        assert high <= found.high
        assert np.mean((found.low <= values) & (values <= found.high)) >= 0.949
        # Not more of it than the answer needs.
        assert found.low in (low, answer[name])
        assert found.high in (high, answer[name])
        assert problem.intervals[name][0] <= found.low
        assert found.high <= problem.intervals[name][1]


@pytest.mark.parametrize(
    ("width", "word", "words"),
    [
        (0.2, "determined", "determined to ±20 %"),
        (0.3, "narrowed", "only narrowed, 0.35 to 0.65"),
        (0.96, "not determined", "not determined, 0 to 1"),
    ],
)
def test_the_word_is_that_of_the_width(width: float, word: str, words: str) -> None:
    problem = Problem([Parameter("x", 0.0, 1.0)], [Target("angle", 30.0)])
    points = np.linspace(0.5 - width / 1.9, 0.5 + width / 1.9, 20_001)[:, None]
    found = parameter_intervals(sample_of(problem, points), problem, {"x": 0.5})["x"]
    assert found.determination == word
    # What is left open up to near its bounds is open up to them.
    assert found.high - found.low == pytest.approx(width if width < 0.9 else 1.0, rel=1e-3)
    assert found.in_words(0.5) == words


def test_an_answer_in_a_tail_makes_the_interval_wider_and_may_change_the_word() -> None:
    problem = Problem([Parameter("x", 0.0, 1.0)], [Target("angle", 30.0)])
    posterior = sample_of(problem, np.linspace(0.4, 0.6, 1001)[:, None])
    assert parameter_intervals(posterior, problem)["x"].determination == "determined"
    found = parameter_intervals(posterior, problem, {"x": 0.1})["x"]
    assert (found.low, found.determination) == (0.1, "narrowed")


def test_a_percentage_covers_the_interval_about_the_answer() -> None:
    assert ParameterInterval(90.0, 101.0, "determined").in_words(100.0) == "determined to ±10 %"
    modulus = ParameterInterval(1e5, 3e5, "determined")
    assert modulus.in_words(2.9e5, "Pa") == "determined, 1·10⁵ to 3·10⁵ Pa"


# --- In a calibration -----------------------------------------------------------------------------

RIDGE = Problem(
    [
        Parameter(DENSITY, 1000.0, 4000.0, unit="kg/m^3"),
        Parameter(SLIDING, 0.1, 0.9),
        Parameter(ROLLING, 0.1, 0.9),
        Parameter(MODULUS, 1e6, 1e8, "log", unit="Pa"),
    ],
    [Target("bulk_density", 1500.0, tolerance=20.0), Target("angle", 30.0, tolerance=0.5)],
    RayleighTimeStep(0.005, {"particle.poissons_ratio": 0.25}),
)


def ridge(values: dict[str, float], seed: int) -> dict[str, float]:
    draw = random.Random(seed)
    return {
        "bulk_density": 0.6 * values[DENSITY] + draw.gauss(0, 5),
        "angle": 20 + 10 * (values[SLIDING] + values[ROLLING]) + draw.gauss(0, 0.2),
    }


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("ridge")
    gf.calibrate(RIDGE, ridge, workdir=folder, workers=2, name="ridge")
    return folder


def test_a_large_time_step_is_answered_within_the_intervals(folder: Path) -> None:
    result = gf.open(folder).result
    assert result is not None
    words = {name: found.determination for name, found in result.intervals.items()}
    assert words[DENSITY] == "determined"
    assert words[MODULUS] == "not determined"
    assert words[SLIDING] != "determined"
    for name, value in result.parameters.items():
        assert result.intervals[name].low <= value <= result.intervals[name].high
    # The softest material has the largest time step, and is at the end of what fits.
    assert result.parameters[MODULUS] < 1.1e6


def test_every_face_shows_the_same_intervals(folder: Path) -> None:
    saved = gf.open(folder)
    result = saved.result
    assert result is not None
    assert saved.intervals == result.intervals == saved.analyse().intervals
    written = json.loads((folder / "result.json").read_text())["intervals"][SLIDING]
    assert ParameterInterval(**written) == result.intervals[SLIDING]
    page = saved.report(folder / "report.html").read_text()
    rows = str(result).splitlines()
    card = json.loads(render(saved.card(), "json"))
    for parameter in card["parameters"]:
        if parameter["origin"] == "given":
            assert parameter["determination"] is None
            continue
        name = parameter["name"]
        found = result.intervals[name]
        assert parameter["interval_95"] == [found.low, found.high]
        assert parameter["determination"] == found.determination
        (row,) = (line for line in rows if line.startswith(f"{name}  "))
        assert row.endswith(f"  {found.determination}")
        assert f"  {plain_ends(found.low, found.high)}  " in row
        assert ends(found.low, found.high) in page
    open_ones = [f for f in result.intervals.values() if f.determination == "not determined"]
    assert page.count('<span class="mark bad">✗ not determined</span>') == len(open_ones)
    [modulus] = [v for v in saved.analyse().identifiability.verdicts if v.startswith(MODULUS)]
    assert "is not determined" in modulus


def test_a_result_of_an_older_version_has_no_intervals_but_its_report_has(
    folder: Path, tmp_path: Path
) -> None:
    result = Result.from_json(folder / "result.json")
    old = result.to_dict()
    del old["intervals"]
    path = tmp_path / "result.json"
    path.write_text(json.dumps(old))
    read = Result.from_json(path)
    assert read == replace(result, intervals={})
    assert "No intervals: " in str(read)
    saved = replace(gf.open(folder), result=read)
    assert saved.intervals == result.intervals


def test_a_calibration_that_is_interrupted_early_has_no_intervals(tmp_path: Path) -> None:
    def impatient(values: dict[str, float], seed: int) -> dict[str, float]:
        raise KeyboardInterrupt

    result = gf.calibrate(RIDGE, impatient, workdir=tmp_path)
    assert result.status == "interrupted"
    assert (result.parameters, result.intervals) == ({}, {})


def test_a_second_ctrl_c_costs_the_intervals_and_not_the_result(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    def interrupt(*_arguments: object, **_options: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr("grainfit.analysis.analysis._last", None)
    monkeypatch.setattr("grainfit.analysis.analysis.sample_posterior", interrupt)
    result = gf.calibrate(RIDGE, ridge, workdir=tmp_path)
    assert result.status == "calibrated"
    assert result.intervals == {}
    assert any(messages.NO_INTERVALS.is_in(notice, why="interrupted") for notice in result.notices)
    assert Result.from_json(tmp_path / "result.json") == result


def test_where_nothing_agrees_there_are_no_intervals() -> None:
    far = replace(RIDGE, targets=[RIDGE.targets[0], Target("angle", 60.0)])
    result = gf.calibrate(far, ridge, max_runs=30)
    assert result.status == "unreachable"
    assert result.intervals == {}
    assert "No intervals: no parameter set" in str(result)
