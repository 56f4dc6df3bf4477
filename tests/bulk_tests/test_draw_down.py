"""Draw-down: geometry, what is refused, and runs that mean nothing although they end well."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest

import grainfit as gf
from grainfit.bulk_tests.draw_down import DrawDown
from grainfit.bulk_tests.draw_down import messages as of_draw_down
from grainfit.bulk_tests.draw_down.surfaces import Surfaces
from grainfit.bulk_tests.draw_down.view import DrawDownView
from grainfit.bulk_tests.shared import messages
from grainfit.bulk_tests.shared.validity import (
    require_apex_below,
    require_emptied,
    require_foot_on_floor,
)
from grainfit.calibration_file.starter import starter_file
from grainfit.campaign.batch import simulate_batch
from grainfit.campaign.campaign import CampaignOptions
from grainfit.errors import InputError, NotMeasurableError, RunFailedError
from grainfit.materials.starting_materials import read_starting_material
from grainfit.measurement.height_map import HeightMap
from grainfit.measurement.particles import Particles
from grainfit.solvers.base import Workspace
from grainfit.solvers.dem.lammps.program import Lammps
from grainfit.testing.materials import ROUGH_SPHERES


def faults_of(**options: object) -> dict[str, str]:
    with pytest.raises(InputError) as caught:
        DrawDown(diameter="10 mm", **options)
    return {fault.key: str(fault) for fault in caught.value.faults}


def balls(*centres: tuple[float, float, float]) -> Particles:
    count = len(centres)
    return Particles(np.array(centres).reshape(count, 3), np.full(count, 0.005), np.ones(count))


def test_defaults_follow_the_diameter() -> None:
    small, large = DrawDown(diameter="2 mm").setup, DrawDown(diameter="50 mm").setup

    assert small.filling.particle_count == large.filling.particle_count == 2127
    assert small.box.slot_width == pytest.approx(0.010)
    assert large.box.slot_width == pytest.approx(0.250)
    assert large.floor == pytest.approx(-14.5 * 0.05)
    assert large.flow_time == pytest.approx(5 * small.flow_time)


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({"slot_width": "25 cm"}, "slot_width: a slot of 0.25 m is not narrower than"),
        ({"slot_width": "9 mm"}, "slot_width: no particle of 0.01 m passes a slot of 0.009 m"),
        ({"depth": "3 cm"}, "depth: a depth of 0.03 m repeats .* Use at least 0.04 m"),
        ({"width": "5 cm", "slot_width": "4 cm"}, "width: 0.05 m is .* Use at least 0.06 m"),
        ({"fill_height": "3 cm"}, "fill_height: a bed of 0.03 m .* Use at least 0.04 m"),
        ({"floor_distance": "4 cm"}, "floor_distance: a floor 0.04 m .* Use at least 0.05 m"),
        ({"floor_half_width": "12 cm"}, "floor_half_width: .* 0.12 m .* Use at least 0.3 m"),
        ({"fill_height": "900 m"}, r"fill_height: \d+ particles are more than 1000000 \("),
        ({"width": "900 m"}, r"width: \d+ particles are more .*width 900 m, depth 0.08 m"),
    ],
)
def test_impossible_geometry_is_refused_with_its_option(
    options: dict[str, object], said: str
) -> None:
    found = faults_of(**options)

    assert list(found) == [said.split(":")[0]]
    assert re.search(said, found[said.split(":")[0]])


def test_every_impossible_length_is_named_at_once() -> None:
    found = faults_of(width="1 mm", depth="1 mm", fill_height="1 mm")

    assert set(found) == {"width", "depth", "fill_height", "slot_width"}


def test_heap_that_reaches_the_shelf_chokes_the_slot() -> None:
    require_apex_below(0.115, 0.140, 0.020, 0.010)
    with pytest.raises(RunFailedError, match=messages.CHOKED.matching(found=1.5)):
        require_apex_below(0.125, 0.140, 0.020, 0.010)


def test_particles_held_above_the_slot_are_an_arch() -> None:
    require_emptied(balls((0, 0, 0.01), (0, 0.02, 0.01)), "slot")
    with pytest.raises(RunFailedError, match="arches over the slot: 4 particles"):
        require_emptied(balls(*[(0.0, 0.01 * i, 0.01) for i in range(4)]), "slot")


def test_foot_beyond_the_floor_fails() -> None:
    x = np.linspace(-0.3, 0.3, 601)
    whole = HeightMap(np.maximum(0.08 - 0.4 * np.abs(x), 0)[None], x, 0.1)
    wide = HeightMap(np.maximum(0.08 - 0.25 * np.abs(x), 0)[None], x, 0.1)

    require_foot_on_floor(whole, 0.01, 0.010)
    with pytest.raises(RunFailedError, match=messages.FOOT_OFF_FLOOR.matching(percent=5.0)):
        require_foot_on_floor(whole, 0.05, 0.010)
    with pytest.raises(RunFailedError, match=messages.FOOT_OFF_FLOOR.pattern):
        require_foot_on_floor(wide, 0.0, 0.010)


def test_end_on_one_side_only_is_not_measurable() -> None:
    setup = DrawDown(diameter="10 mm").setup
    with pytest.raises(NotMeasurableError, match=of_draw_down.NONE_LEFT.pattern):
        Surfaces.of(balls(), setup)
    with pytest.raises(NotMeasurableError, match=of_draw_down.ONE_SIDE.pattern):
        _ = Surfaces.of(balls((0.1, 0.05, 0.005)), setup).apex


def test_view_has_the_edges_of_box_and_floor() -> None:
    setup = DrawDown(diameter="10 mm").setup
    end = balls((0.1, 0.05, 0.005), (-0.1, 0.05, 0.005), (0.0, 0.05, setup.floor + 0.005))
    view = DrawDownView(Surfaces.of(end, setup))
    corners = np.array([corner for outline in view.outlines() for corner in outline])

    # The floor is at z = 0 and the slice lies on both sides of y = 0, as the particles do.
    assert corners[:, 2].min() == pytest.approx(0)
    assert corners[:, 2].max() == pytest.approx(0.145 + 0.10)
    assert (corners[:, 1].min(), corners[:, 1].max()) == pytest.approx((-0.04, 0.04))
    assert view.particles.positions[:, 2].min() == pytest.approx(0.005)
    assert view.drawing().path.count("M") == 2
    assert view.measured_drawing(25.0).words == ""


@pytest.mark.slow
def test_heap_on_a_floor_9_d_below_chokes_the_slot(tmp_path: Path) -> None:
    test = DrawDown(diameter="10 mm", depth="4 cm", floor_distance="9 cm")

    with pytest.raises(RunFailedError, match=messages.CHOKED.pattern):
        Lammps(test, ROUGH_SPHERES).run({}, 1, Workspace(tmp_path, 300.0))
    assert (tmp_path / "draw_down.png").stat().st_size > 10_000
    assert (tmp_path / "draw_down.vtk").is_file()


@pytest.mark.slow
def test_the_file_that_new_writes_gives_every_response(tmp_path: Path) -> None:
    text = starter_file(["draw_down"], read_starting_material("glass_beads"))
    # Soft and shallow, for time.
    text = text.replace('youngs_modulus = "10 MPa"', 'youngs_modulus = "0.36 MPa"')
    text = text.replace('solver = "lammps"', 'solver = "lammps"\ndepth = "50 mm"')
    path = tmp_path / "beads.toml"
    path.write_text(text, encoding="utf-8")
    setup = gf.load(path)
    proposal = gf.Proposal(setup.values([]), 1, "design")
    options = CampaignOptions(1)
    [evaluation] = simulate_batch(setup.solvers, [proposal], tmp_path / "work", options)
    assert evaluation.failures == {}
    assert set(evaluation.responses) == set(DrawDown.responses)


def test_a_smooth_floor_is_lined_for_particles_that_would_roll_off() -> None:
    rolling = "particle_wall.rolling_friction"
    assert DrawDown.options_for({rolling: 0.1}) == {}
    lined = DrawDown.options_for({rolling: 0.005})
    assert lined == {"floor_rolling_friction": 0.5}
