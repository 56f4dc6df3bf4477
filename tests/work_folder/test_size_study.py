"""`grainfit size` and `gf.size_study`: a material in apparatus of several sizes."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

import grainfit as gf
from grainfit import ground_messages
from grainfit.analysis import messages
from grainfit.analysis.size_trend import Prediction, predict, together
from grainfit.bulk_tests.registry import BUILT_IN
from grainfit.bulk_tests.size import resized, size_power
from grainfit.calibration_file.starter import starter_file
from grainfit.campaign.batch import ExpectedWork
from grainfit.cli.app import app
from grainfit.errors import InputError
from grainfit.work_folder import messages as of_folder
from grainfit.work_folder.size_study import usual_times

RESIZED = [name for name, kind in BUILT_IN.items() if hasattr(kind, "at_size")]


@pytest.fixture
def pot(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    text = starter_file(["packing"]).replace(
        'youngs_modulus = "10 MPa"', 'youngs_modulus = "1 MPa"'
    )
    size = 'type = "packing"\ncylinder_radius = "35 mm"\nfill_height = "90 mm"'
    (tmp_path / "my pot.toml").write_text(text.replace('type = "packing"', size))
    monkeypatch.chdir(tmp_path)
    return Path("my pot.toml")


@pytest.mark.parametrize("name", RESIZED)
def test_an_apparatus_holds_as_many_times_the_particles(name: str) -> None:
    test = BUILT_IN[name](diameter="10 mm")
    larger = resized(test, 4.0)
    assert larger.number_of_particles == pytest.approx(4 * test.number_of_particles, rel=0.35)
    assert resized(test, 1) is test
    assert {size_power(test, response) for response in test.responses} <= {None, 0.0, 1, 3}


def test_a_given_number_of_particles_grows_with_its_apparatus() -> None:
    heap = gf.tests.Heap(diameter="10 mm", particle_count=1600)
    assert resized(heap, 2.0).number_of_particles == 3200


def test_speeds_follow_froude() -> None:
    heap = gf.tests.Heap(diameter="10 mm")
    assert resized(heap, 8.0).setup.lift_speed == pytest.approx(heap.setup.lift_speed * 2**0.5)
    drum = gf.tests.Drum(diameter="10 mm")
    assert resized(drum, 8.0).setup.froude_number == drum.setup.froude_number


def test_intervals_of_a_trend_hold_what_another_size_gives() -> None:
    random = np.random.default_rng(4)
    scales, errors, held = np.array([1.0, 1.26, 1.59]), [0.1, 0.1, 0.1], 0
    for _ in range(200):
        level, walls, depth = random.normal(100.0, 5.0), random.normal(-4.0, 1.0), random.random()

        def expected(s: np.ndarray | float, a=level, b=walls, c=depth) -> np.ndarray:
            return a + b / np.asarray(s) + c * np.log(s)

        found = predict(scales, expected(scales) + random.normal(0.0, 0.1, 3), errors, 4.0)
        held += abs(found.value - float(expected(4.0))) <= found.half_width
    # A stated 95 %; the form of the trend is never quite the true one.
    assert 185 <= held <= 200


@pytest.mark.parametrize("between", [0.0, 0.05])
def test_ratios_of_several_answers_hold_that_of_another_one(between: float) -> None:
    random = np.random.default_rng(5)
    held, widths = 0, []
    for _ in range(400):
        truth = random.normal(0.9, between, 7)
        found = [Prediction(random.normal(one, 0.02), 0.02, 0.0) for one in truth[:-1]]
        ratio = together(found)
        held += abs(ratio.value - truth[-1]) <= ratio.half_width
        widths.append(ratio.error)
    # Six runs of each: 95 % by the normal quantile, less what it costs to estimate their spread.
    assert 348 <= held <= 394
    assert np.median(widths) == pytest.approx(
        np.hypot(0.02 / 6**0.5, between * (7 / 6) ** 0.5), rel=0.2
    )


def test_the_form_of_the_trend_is_an_error_that_more_series_do_not_lower() -> None:
    alone = Prediction(0.9, 0.01, 0.05)
    assert together([alone]) == alone
    assert together([alone] * 9).half_width == pytest.approx(0.05, rel=0.02)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"times": [1.0]}, messages.FEW_SIZES),
        ({"times": [1.0, -2.0]}, messages.NO_SIZE),
        ({"times": [1.0, 2.0], "to": float("nan")}, messages.NO_SIZE),
        ({"times": [1.0, 2.0], "to": np.array([1.0, 2.0])}, ground_messages.NO_NUMBERS),
        ({"times": [1.0, 1e-4]}, messages.IMPOSSIBLE_SIZE),
    ],
)
def test_impossible_sizes_are_refused(pot: Path, options: dict, message) -> None:
    with pytest.raises(InputError) as caught:
        gf.size_study(pot, **options)
    assert message.is_in(str(caught.value))


def test_an_own_model_has_no_size(tmp_path: Path) -> None:
    (tmp_path / "model.py").write_text("def simulate(parameters, seed):\n    return {'y': 1.0}\n")
    path = tmp_path / "own.toml"
    path.write_text(
        "name = 'x'\n[parameters]\na = { min = 0, max = 1 }\n[[test]]\ntype = 'python'\n"
        "function = 'model.py:simulate'\ntargets.y = { value = 1, tolerance = 1 }\n"
    )
    with pytest.raises(InputError) as caught:
        gf.size_study(path)
    assert of_folder.NO_SIZES.is_in(str(caught.value))


def test_a_large_apparatus_is_simulated_smaller() -> None:
    assert usual_times(1500) == (1.0, 2.0, 4.0)
    assert [round(t * 108_751) for t in usual_times(108_751)] == [1000, 2000, 4000]


@pytest.mark.slow
def test_a_packing_becomes_denser_with_its_size_and_runs_are_kept(pot: Path) -> None:
    works: list[ExpectedWork] = []
    study = gf.size_study(pot, times=[1, 3], to=8, seeds=2, on_start=works.append)
    [test] = study.tests
    small, large = (row.responses["bulk_density"].mean for row in test.rows)
    predicted = test.prediction(test.targets[0])
    assert small < large
    assert predicted is not None
    assert large < predicted.value < 1.1 * large
    assert test.goal.particles > 2 * test.rows[1].particles
    assert test.goal.seconds

    done = CliRunner().invoke(
        app, ["size", str(pot), "--times", "1,3", "--to", "8", "--seeds", "2"]
    )
    assert done.exit_code == 0, done.output
    assert f"{test.goal.particles} (trend)" in done.output
    assert Path("my pot.size.png").read_bytes().startswith(b"\x89PNG")
    assert [(work.runs, work.known) for work in works] == [(4, 0)]
    assert "All runs are known already" in done.output
