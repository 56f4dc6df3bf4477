"""`grainfit simulate --repeat` and `gf.repeat_runs`: mean and scatter before a calibration."""

from __future__ import annotations

import statistics
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

import grainfit as gf
from grainfit.analysis import messages as of_analysis
from grainfit.analysis.scatter import RepeatedRuns, ResponseScatter, scatter_over_seeds
from grainfit.campaign.batch import ExpectedWork
from grainfit.cli.app import app
from grainfit.verdict import messages as of_verdict
from grainfit.work_folder import messages

MODEL = """\
import random

def drum(parameters, seed):
    with open("calls", "a") as calls:
        calls.write(f"{seed}\\n")
    if seed == 5 and parameters["friction"] > 0.8:
        raise ValueError("the drum broke")
    return {"angle": 40 * parameters["friction"] + random.Random(seed).gauss(0, 2), "blades": 4}
"""
FILE = """\
name = "sand"
[parameters]
friction = { min = 0.1, max = 0.9 }
[[test]]
type = "python"
function = "model.py:drum"
targets.angle = { value = 20, tolerance = 0.5, unit = "deg" }
"""


@pytest.fixture
def sand(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    (tmp_path / "model.py").write_text(MODEL)
    (tmp_path / "sand.toml").write_text(FILE)
    monkeypatch.chdir(tmp_path)
    return tmp_path


def calls() -> list[int]:
    return [int(line) for line in Path("calls").read_text().split()]


@pytest.mark.usefixtures("sand")
def test_mean_and_scatter_are_those_of_the_seeds_and_only_missing_runs_are_made() -> None:
    first = gf.repeat_runs("sand.toml", repeat=np.int64(4), seed=np.int64(3))
    assert sorted(calls()) == [3, 4, 5, 6]
    works: list[ExpectedWork] = []
    progress: list[tuple[int, int]] = []
    runs = gf.repeat_runs(
        "sand.toml",
        repeat=6,
        seed=3,
        on_start=works.append,
        on_progress=lambda done, count: progress.append((done, count)),
    )
    assert sorted(calls()) == [3, 4, 5, 6, 7, 8], "finished runs are not repeated"
    assert (works[0].runs, works[0].known) == (2, 4)
    assert progress[-1] == (6, 6)
    angle = runs["angle"]
    assert angle.values[:4] == first["angle"].values
    assert angle.mean == statistics.fmean(angle.values)
    assert angle.standard_deviation == statistics.stdev(angle.values)
    assert runs.parameters == {"friction": 0.5}
    assert runs["blades"].standard_deviation == 0
    text = str(runs)
    assert "20.00 ± 0.50" in text
    assert of_analysis.ONE_RUN_SCATTERS.is_in(text, name="angle")
    assert "<table" in runs._repr_html_()


def test_the_intervals_hold_mean_and_standard_deviation_in_95_percent() -> None:
    random = np.random.default_rng(3)
    held = np.zeros(2)
    count = 600
    for values in random.normal(-3.0, 2.0, (count, 6)):
        found = ResponseScatter("angle", tuple(map(float, values)))
        assert found.mean_interval is not None
        assert found.standard_deviation_interval is not None
        low, high = found.standard_deviation_interval
        held += [abs(found.mean + 3.0) <= found.mean_interval, low <= 2.0 <= high]
    # Four standard errors of a share of 95 % of 600.
    assert held / count == pytest.approx([0.95, 0.95], abs=0.036)


def test_numbers_of_the_scatter_of_a_response_have_one_notation() -> None:
    target = gf.Target("stress", 9e6, tolerance=3e5, unit="Pa")
    found = ResponseScatter("stress", (8e6, 9.1e6, 1.03e7), target, "Pa")
    text = str(RepeatedRuns((found,), {}, ()))
    assert "·10⁶" in text
    assert "e+" not in text


def test_the_number_of_runs_for_the_tolerance_holds_the_mean_within_it() -> None:
    target = gf.Target("angle", 20.0, tolerance=0.5)
    found = ResponseScatter("angle", (18.0, 22.0, 18.0, 22.0), target)
    # (1.96 · 2.309 / 0.5)²
    assert found.runs_for_tolerance == 82
    assert ResponseScatter("angle", (20.0, 20.0), target).runs_for_tolerance == 1
    assert ResponseScatter("angle", (20.0,), target).runs_for_tolerance is None


def test_a_response_that_scatters_by_several_tolerances_is_called_useless() -> None:
    zero = gf.Target("force", 0.0, tolerance=0.5, unit="N")
    runs = RepeatedRuns((ResponseScatter("force", (-2.0, 2.0, -2.0, 2.0), zero),), {}, ())
    assert of_verdict.USELESS_SCATTER.is_in(
        str(runs), target="force", scatter="2.3 N", tolerance="0.5 N", runs=22
    )
    assert "82 runs is within it (95 %)" in str(runs)
    calm = RepeatedRuns((ResponseScatter("force", (-1.0, 1.0, -1.0, 1.0), zero),), {}, ())
    assert "tells nothing" not in str(calm)


@pytest.mark.usefixtures("sand")
def test_simulate_keeps_its_runs_apart_from_the_calibration_unless_told() -> None:
    runner = CliRunner()
    done = runner.invoke(app, ["simulate", "sand.toml", "--repeat", "3"])
    assert done.exit_code == 0, done.output
    assert "standard deviation" in done.output
    assert Path("sand.simulated").is_dir()
    assert not Path("sand.grainfit").exists()
    runner.invoke(app, ["simulate", "sand.toml", "--workdir", "sand.grainfit"])
    assert Path("sand.grainfit").is_dir()
    assert sorted(calls()) == [1, 1, 2, 3]


@pytest.mark.usefixtures("sand")
def test_the_answer_of_a_calibration_is_simulated_in_another_file(tmp_path: Path) -> None:
    calibrated = gf.load("sand.toml").calibrate(max_runs=12, workdir="of a 'jar'")
    other = FILE.replace("max = 0.9", "max = 0.8").replace("value = 20", "value = 25")
    (tmp_path / "other.toml").write_text(other)
    runs = gf.repeat_runs("other.toml", repeat=2, answer_of=gf.open("of a 'jar'"))
    assert runs.parameters == calibrated.parameters
    runs = gf.repeat_runs("other.toml", settings=["friction=0.3"], answer_of="of a 'jar'")
    assert runs.parameters == {"friction": 0.3}

    (tmp_path / "strange.toml").write_text(FILE.replace("friction", "roughness"))
    with pytest.raises(gf.InputError) as caught:
        gf.repeat_runs("strange.toml", answer_of="of a 'jar'")
    assert [fault.key for fault in caught.value.faults] == ["friction", "roughness"]

    done = CliRunner().invoke(app, ["simulate", "other.toml", "--answer-of", "sand.toml"])
    assert done.exit_code == 1
    assert "Traceback" not in done.output


@pytest.mark.usefixtures("sand")
def test_failed_seeds_are_named_and_the_others_counted() -> None:
    done = CliRunner().invoke(
        app, ["simulate", "sand.toml", "--repeat", "6", "--set", "friction=0.9"]
    )
    assert done.exit_code == 1
    assert "Seed 5: python failed" in done.output
    assert "the drum broke" in done.output
    [row] = [line for line in done.output.splitlines() if line.startswith("angle in °")]
    assert row.split()[-1] == "5"


@pytest.mark.usefixtures("sand")
def test_impossible_numbers_and_mixed_runs_are_refused() -> None:
    with pytest.raises(gf.InputError, match="repeat: is 0"):
        gf.repeat_runs("sand.toml", repeat=0)
    with pytest.raises(gf.InputError, match=messages.SEED_TOO_LARGE.pattern):
        gf.repeat_runs("sand.toml", repeat=2, seed=900_000_000)

    def run(friction: float, seed: int) -> gf.Evaluation:
        proposal = gf.Proposal({"friction": friction}, seed, "design")
        return gf.Evaluation.of(proposal, {"angle": 20.0})

    with pytest.raises(gf.InputError, match="2 parameter sets"):
        scatter_over_seeds([run(0.1, 1), run(0.2, 2)])
    with pytest.raises(gf.InputError, match="seed 1"):
        scatter_over_seeds([run(0.1, 1), run(0.1, 1)])
    with pytest.raises(gf.InputError, match="are empty"):
        scatter_over_seeds([])
