"""Estimates by the atlas: parameters that agree with measurements, before any simulation."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from PIL import Image
from typer.testing import CliRunner

import grainfit as gf
from grainfit.atlas import messages
from grainfit.atlas.estimate import estimate_of
from grainfit.atlas.forecast import Forecast
from grainfit.atlas.row import rows_in
from grainfit.atlas.shelf import SHIPPED
from grainfit.atlas.strata import strata
from grainfit.calibration_file.checks import messages as checked
from grainfit.cli.app import app
from grainfit.materials.particle_shape import ASPECT_RATIO
from grainfit.testing.materials import ROUGH_PLATE, ROUGH_SPHERES
from grainfit.work_folder.estimate import estimate_of_heap

SLIDING, ROLLING = "particle_particle.sliding_friction", "particle_particle.rolling_friction"
#: Rows of a stratum whose material is estimated.
_ESTIMATES = 8
FRICTIONS = [gf.Parameter(SLIDING, 0.1, 1.0), gf.Parameter(ROLLING, 0.02, 1.0)]
MATERIAL = {
    **ROUGH_SPHERES,
    "particle_particle.rolling_damping": 0.0,
    "particle_wall.rolling_damping": 0.0,
}
HEAP = gf.tests.Heap(diameter="10 mm", **ROUGH_PLATE)


def _without_frictions(material: Mapping[str, float]) -> dict[str, float]:
    return {name: one for name, one in material.items() if name not in (SLIDING, ROLLING)}


def _heaps() -> dict[str, gf.Solver]:
    return {"heap": gf.solvers.Lammps(HEAP, _without_frictions(MATERIAL))}


def _of_angle(angle: float, uncertainty: float = 1.0) -> gf.Problem:
    return gf.Problem(FRICTIONS, [gf.Target("angle_of_repose", angle, uncertainty=uncertainty)])


def _about(name: str, value: float) -> tuple[float, float]:
    """Return an interval about a value; an aspect ratio has ends."""
    return (1.1, 2.0) if name == ASPECT_RATIO else (value / 2, 2 * value)


@pytest.mark.parametrize(("told", "expected"), [(-3.0, 0.0), (25.0, 25.0), (95.0, 90.0)])
def test_nothing_impossible_is_expected(told: float, expected: float) -> None:
    forecast = Forecast(_of_angle(25.0), _heaps())

    assert forecast.possible(np.array([[told]])) == pytest.approx(np.array([[expected]]))


def test_what_the_atlas_misses_of_a_heap_makes_it_higher_and_narrower() -> None:
    names = ("bulk_density", "base_radius", "heap_height")
    problem = gf.Problem(FRICTIONS, [gf.Target(name, 1.0, uncertainty=0.1) for name in names])

    found = Forecast(problem, _heaps()).correlation

    assert found == pytest.approx(found.T)
    assert found.diagonal() == pytest.approx(1.0)
    assert found[1, 2] < -0.3
    assert abs(found[0, 1]) < 0.3


class OwnModel(gf.Solver):
    """A model of the user."""

    name = "own"
    response_names = ("wear",)

    def model(self) -> dict[str, str]:
        """Return nothing."""
        return {}

    def run(
        self, parameters: Mapping[str, float], seed: int, workspace: gf.Workspace
    ) -> dict[str, gf.Response]:
        """Return nothing."""
        del parameters, seed, workspace
        return {}


@pytest.mark.parametrize(
    ("stratum", "free"),
    [
        ("heap", (SLIDING, ROLLING)),
        ("heap-cohesive", (SLIDING, "particle_particle.surface_energy")),
        pytest.param("heap-clumps", (SLIDING, ASPECT_RATIO), marks=pytest.mark.thorough),
    ],
)
def test_the_intervals_of_an_estimate_hold_the_material_of_a_row(
    stratum: str, free: tuple[str, ...]
) -> None:
    # What a row gave is not known better than its scatter.
    rows = [r for r in rows_in(SHIPPED / f"{stratum}.jsonl") if "angle_of_repose" in r.responses]
    inside = 0
    for row in rows[:_ESTIMATES]:
        test, material = strata()[stratum].simulated(row.inputs)
        density = row.responses["bulk_density"][0] * material["particle.density"]
        problem = gf.Problem(
            [gf.Parameter(name, *_about(name, material[name])) for name in free],
            [
                gf.Target("bulk_density", density, uncertainty="1 %"),
                gf.Target("angle_of_repose", row.responses["angle_of_repose"][0], uncertainty=1.0),
            ],
        )
        fixed = {name: one for name, one in material.items() if name not in free}
        solver = gf.solvers.Lammps(test, fixed)
        for one in estimate_of(problem, {"heap": solver}).parameters:
            inside += one.low <= material[one.parameter.name] <= one.high

    assert inside >= len(free) * _ESTIMATES - 2


def test_numbers_of_an_estimate_have_one_notation() -> None:
    modulus = gf.Parameter("particle.youngs_modulus", 5e6, 1e7, unit="Pa")
    given = {n: one for n, one in _without_frictions(MATERIAL).items() if n != modulus.name}
    problem = gf.Problem([*FRICTIONS, modulus], _of_angle(28.0).targets)

    found = estimate_of(problem, {"heap": gf.solvers.Lammps(HEAP, given)})

    assert "·10⁶ Pa" in str(found)
    assert "e+0" not in str(found)


def test_a_steeper_heap_needs_more_friction() -> None:
    best = [estimate_of(_of_angle(angle), _heaps()).best for angle in (18.0, 28.0, 35.0)]

    low, middle, high = (one[SLIDING] * one[ROLLING] for one in best)
    assert low < middle < high


def test_an_estimate_says_that_nothing_was_simulated_and_what_stays_open() -> None:
    text = str(estimate_of(_of_angle(25.0), _heaps()))

    assert messages.NOT_SIMULATED.is_in(text)
    assert messages.OPEN.is_in(text)
    assert messages.TO_VERIFY.is_in(text)


def _of_little_friction(angle: float) -> gf.Estimate:
    frictions = [replace(FRICTIONS[0], maximum=0.4), replace(FRICTIONS[1], maximum=0.1)]
    return estimate_of(replace(_of_angle(angle), parameters=frictions), _heaps())


def test_a_value_that_intervals_just_miss_is_named_with_the_end_that_keeps_it() -> None:
    reached, missed = _of_little_friction(12.0), _of_little_friction(16.0)

    assert not messages.BEYOND_BOUND.is_in(str(reached))
    assert messages.BEYOND_BOUND.is_in(str(missed))
    assert ROLLING in str(missed).partition("off by")[2]
    assert missed.runs > reached.runs


def _of_cylinder(height: float) -> tuple[float, gf.Estimate]:
    """Return the standard error of the density in a measuring cylinder, and the estimate."""
    test = gf.tests.Packing(diameter="10 mm", fill_height=height, bulk_density_top="60 mm")
    solver = gf.solvers.Lammps(test, _without_frictions(MATERIAL))
    target = gf.Target("bulk_density", "1300 kg/m^3", uncertainty="1 %")
    found = estimate_of(gf.Problem(FRICTIONS, [target]), {"packing": solver})
    return found.responses[0].standard_error, found


def test_an_apparatus_beyond_the_rows_is_told_less_surely_and_named() -> None:
    inside, usual = _of_cylinder(0.12)
    beyond, high = _of_cylinder(0.4)

    assert beyond > 2 * inside
    assert not usual.less_sure
    assert messages.LESS_SURE.is_in(str(high))


def test_a_further_measurement_is_named_that_narrows_what_is_open() -> None:
    found = estimate_of(_of_angle(25.0), _heaps())

    assert messages.WOULD_NARROW.is_in(str(found))
    best = found.most_telling(ROLLING)
    assert best is not None
    assert (best.test, best.response) != ("heap", "angle_of_repose")
    assert all(0 <= left <= 1 for one in found.further for left in one.left.values())


def test_a_free_friction_of_walls_has_an_estimate_too() -> None:
    wall = "particle_wall.rolling_friction"
    fixed = {name: one for name, one in _without_frictions(MATERIAL).items() if name != wall}
    problem = gf.Problem(
        [*FRICTIONS, gf.Parameter(wall, 0.01, 0.5)],
        [gf.Target("angle_of_repose", 25.0, uncertainty=1.0)],
    )

    found = estimate_of(problem, {"heap": gf.solvers.Lammps(HEAP, fixed)})

    # What lies on a rough plate tells nothing of smooth walls.
    assert found.parameters[2].is_open


def test_a_target_out_of_reach_is_named() -> None:
    text = str(estimate_of(_of_angle(70.0, 0.5), _heaps()))
    assert messages.OUT_OF_REACH.is_in(text.partition("most probable")[0])
    assert not messages.TO_VERIFY.is_in(text)


def test_targets_that_are_at_odds_are_not_called_out_of_reach() -> None:
    targets = [
        gf.Target(f"{name}.angle_of_repose", angle, uncertainty=1.0)
        for name, angle in (("a", 18.0), ("b", 30.0))
    ]
    scopes = [
        gf.TestScope(name, [f"{name}.angle_of_repose"], [SLIDING, ROLLING]) for name in ("a", "b")
    ]
    solver = _heaps()["heap"]

    found = estimate_of(gf.Problem(FRICTIONS, targets, tests=scopes), {"a": solver, "b": solver})

    assert found.out_of_reach == ()
    assert found.at_odds
    for name in found.at_odds:
        assert messages.AT_ODDS.is_in(str(found), response=name)
    assert not messages.TO_VERIFY.is_in(str(found))


def test_intervals_beyond_the_rows_are_cut_and_that_is_said() -> None:
    wide = [replace(FRICTIONS[0], maximum=2.9), FRICTIONS[1]]
    found = estimate_of(replace(_of_angle(25.0), parameters=wide), _heaps())

    # A little beyond the rows is as good as their end.
    assert found.parameters[0].high <= 1.8
    assert found.best[SLIDING] <= 1.8
    [left_out] = found.left_out
    assert messages.LEFT_OUT.is_in(str(found), name=SLIDING, low="0.05", high="1.5")
    assert left_out in str(found)
    assert estimate_of(_of_angle(25.0), _heaps()).left_out == ()


def test_a_tolerance_that_no_calibration_reaches_has_no_number_of_runs() -> None:
    text = str(estimate_of(_of_angle(25.0, 1e-6), _heaps()))

    assert messages.TOO_MANY_RUNS.is_in(text, response="angle_of_repose", most=1000)
    assert not messages.TO_VERIFY.is_in(text)


def test_parameters_of_a_target_out_of_reach_come_nearest_to_it() -> None:
    steepest, flattest = (estimate_of(_of_angle(angle, 0.5), _heaps()) for angle in (85.0, 1.0))

    assert steepest.responses[0].value > 35
    assert flattest.responses[0].value < 15
    assert steepest.best[SLIDING] > flattest.best[SLIDING]


def test_a_test_that_the_atlas_does_not_have_is_left_out_with_the_reason() -> None:
    targets = [gf.Target("heap.angle_of_repose", 25.0, uncertainty=1.0), gf.Target("own.wear", 1.0)]
    scopes = [
        gf.TestScope("heap", ["heap.angle_of_repose"], [SLIDING, ROLLING]),
        gf.TestScope("own", ["own.wear"], [SLIDING]),
    ]

    found = estimate_of(
        gf.Problem(FRICTIONS, targets, tests=scopes), {**_heaps(), "own": OwnModel()}
    )

    assert list(found.untold) == ["own.wear"]


def test_no_estimate_is_made_of_a_model_of_the_user() -> None:
    with pytest.raises(gf.InputError) as refused:
        estimate_of(gf.Problem(FRICTIONS, [gf.Target("wear", 1.0)]), {"own": OwnModel()})

    assert messages.NOTHING_TOLD.is_in(str(refused.value))


def test_a_built_in_test_without_an_estimate_is_not_called_a_model_of_the_user() -> None:
    with pytest.raises(gf.InputError, match=messages.NOTHING_TOLD.pattern) as refused:
        gf.estimate(Path(__file__).parents[2] / "examples" / "glass_beads" / "calibration.toml")

    assert "model" not in str(refused.value)


def test_an_estimate_needs_no_file() -> None:
    found = estimate_of_heap("3 mm", "540 kg/m^3", "30 deg")

    density = found.parameters[0]
    assert 830 <= density.low < density.high <= 1080
    assert {one.target.name for one in found.responses} == {"bulk_density", "angle_of_repose"}


def test_the_command_answers_with_a_picture(tmp_path: Path) -> None:
    picture = tmp_path / "it's a picture.png"
    quantities = ["--diameter", "3mm", "--bulk-density", "540kg/m^3", "--angle", "30deg"]

    found = CliRunner().invoke(app, ["estimate", *quantities, "-o", str(picture)])

    assert found.exit_code == 0, found.output
    assert "not simulated" in found.output
    with Image.open(picture) as image:
        assert image.width > 300


@pytest.mark.parametrize(
    ("given", "named"),
    [
        ([], "--diameter"),
        (["--diameter", "3mm"], "--angle"),
        (["--diameter", "3mm", "--angle", "30deg"], "--density"),
        (["--diameter", "3 apples", "--bulk-density", "540kg/m^3"], "--diameter"),
        (["--diameter", '3" mm', "--bulk-density", "540kg/m^3"], "--diameter"),
        (["--diameter", "3mm", "--bulk-density", "-1"], "--bulk-density"),
        (["--diameter", "3mm", "--bulk-density", "0"], "--bulk-density"),
        (["--diameter", "0mm", "--bulk-density", "540kg/m^3"], "--diameter"),
        (["--diameter", "3000km", "--bulk-density", "540kg/m^3"], "--diameter"),
        (["--diameter", "3mm", "--bulk-density", "540kg/m^3", "--angle", "95deg"], "--angle"),
        (["no_such_file.toml"], "no_such_file.toml"),
        (["no_such_file.toml", "--angle", "30deg"], "--angle"),
    ],
)
def test_bad_input_is_named_without_a_traceback(given: list[str], named: str) -> None:
    found = CliRunner().invoke(app, ["estimate", *given])

    assert found.exit_code != 0
    assert isinstance(found.exception, gf.InputError)
    assert named in str(found.exception)
    assert "heap.toml" not in str(found.exception)


def test_an_estimate_names_impossible_measurements_as_check_does() -> None:
    dense = estimate_of_heap("3 mm", "540", density="500")
    steep = estimate_of_heap("3 mm", angle="89 deg", density="1000")

    assert checked.IMPOSSIBLE_BULK_DENSITY.is_in(str(dense))
    assert checked.STEEP_ANGLE.is_in(str(steep))
    assert estimate_of_heap("3 mm", "540", "34 deg").doubts == ()
