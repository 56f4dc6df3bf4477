"""Hopper: geometry, filling by mass, and runs that empty, arch or leave a rest."""

from __future__ import annotations

import math
import re
from pathlib import Path

import numpy as np
import pytest

import needs
from grainfit.bulk_tests.discharge import Discharge
from grainfit.bulk_tests.hopper import Hopper
from grainfit.bulk_tests.outline import concepts
from grainfit.bulk_tests.size import growth, resized
from grainfit.bulk_tests.workload import workload
from grainfit.errors import InputError
from grainfit.evaluation import Curve, Response
from grainfit.scenes.run_output import RunOutput
from grainfit.scenes.scene_faults import scene_faults
from grainfit.solvers.base import Workspace
from grainfit.solvers.dem.lammps.program import Lammps
from grainfit.solvers.dem.liggghts.program import Liggghts
from grainfit.solvers.dem.program import DeckSolver
from grainfit.solvers.dem.yade.program import Yade
from grainfit.testing.materials import GLASS_BEADS

SMALL = {"orifice_diameter": "5 cm", "width": "9 cm", "fill_height": "9 cm"}
WEDGE = {"orifice": "slot", "width": "9 cm", "fill_height": "9 cm", "depth": "4 cm"}
ROUGH = {**GLASS_BEADS, "particle_particle.sliding_friction": 0.8}


def simulated(
    test: Hopper, folder: Path, material: dict[str, float], program: type[DeckSolver] = Lammps
) -> dict[str, Response]:
    responses = program(test, material).run({}, 1, Workspace(folder, 300.0))
    return {n: found for n, found in responses.items() if isinstance(found, Response)}


@pytest.mark.parametrize(
    ("options", "key"),
    [
        ({"half_angle": "85 deg"}, "half_angle"),
        ({"half_angle": "2 deg"}, "half_angle"),
        ({"fill_mass": "1 kg", "fill_height": "9 cm"}, "fill_mass"),
        ({"fill_mass": "100 t"}, "width"),
        ({"stem_length": "-1 mm"}, "stem_length"),
        ({"orifice_diameter": "20 cm"}, "orifice_diameter"),
        ({"orifice": "slot", "orifice_diameter": "5 cm"}, "orifice_diameter"),
        ({"slot_width": "5 cm"}, "slot_width"),
    ],
)
def test_impossible_options_are_refused_by_name(options: dict[str, str], key: str) -> None:
    with pytest.raises(InputError) as caught:
        Hopper(diameter="10 mm", **options)
    assert [fault.key for fault in caught.value.faults] == [key]


@pytest.mark.parametrize("stem", [0.0, 0.02])
@pytest.mark.parametrize("orifice", ["round", "slot"])
@pytest.mark.parametrize("half_angle", [10.0, 45.0, 80.0, 90.0])
def test_a_vessel_holds_what_its_section_says(orifice: str, half_angle: float, stem: float) -> None:
    options = {"half_angle": half_angle, "stem_length": stem, "orifice": orifice}
    test = Hopper(diameter="10 mm", **options)
    vessel, depth = test.setup.container, test.setup.container.period
    high = vessel.slope_top + 0.05

    # Slices, each with the width in its middle.
    heights = (np.arange(200_000) + 0.5) / 200_000 * high
    corners = np.array(vessel.section(high))
    halves = np.interp(heights, corners[:, 1], corners[:, 0])
    slices = math.pi * halves**2 if depth is None else 2 * halves * depth
    assert vessel.volume(high) == pytest.approx(slices.mean() * high, rel=1e-4)
    for share in (0.05, 0.5, 1.0, 1.5):
        volume = share * vessel.volume(vessel.slope_top) or 1e-4
        assert vessel.volume(vessel.level(volume)) == pytest.approx(volume, rel=1e-9)
    assert not scene_faults(test.scene(GLASS_BEADS, 1))


@pytest.mark.parametrize("orifice", ["round", "slot"])
def test_a_flat_hopper_has_the_walls_of_a_discharge(orifice: str) -> None:
    options = {"orifice": orifice, "width": "16 cm", "fill_height": "12 cm"}
    flat = Hopper(diameter="10 mm", half_angle="90 deg", **options).scene(GLASS_BEADS, 1)
    discharge = Discharge(diameter="10 mm", flow_until="rest", **options).scene(GLASS_BEADS, 1)

    assert (flat.walls, flat.box, flat.stages) == (discharge.walls, discharge.box, discharge.stages)
    assert np.array_equal(flat.particles.positions, discharge.particles.positions)


def test_every_solver_has_cones_and_wedges_and_yade_no_flat_round_floor() -> None:
    cone, wedge = Hopper(diameter="10 mm"), Hopper(diameter="10 mm", orifice="slot")
    stem = Hopper(diameter="10 mm", stem_length="5 mm")
    flat = Hopper(diameter="10 mm", half_angle="90 deg")

    assert concepts(cone) == concepts(stem) == {"cylinder", "cone", "disc"}
    assert concepts(wedge) == {"block", "prism", "periodic y"}
    for program in (Lammps, Liggghts, Yade):
        assert not set(program.missing) & (concepts(cone) | concepts(wedge))
        assert bool(set(program.missing) & concepts(flat)) == (program is Yade)


@pytest.mark.parametrize("density", [900.0, 7800.0])
@pytest.mark.parametrize("orifice", ["round", "slot"])
def test_a_mass_is_filled_in_whatever_the_density(density: float, orifice: str) -> None:
    test = Hopper(diameter="10 mm", orifice=orifice, fill_mass="1.5 kg")
    material = {**GLASS_BEADS, "particle.density": density}
    scene = test.scene(material, 1)

    one = density * math.pi / 6 * 0.01**3
    assert scene.mass == pytest.approx(1.5, abs=1.01 * one)
    assert workload(test, material).particles == scene.number_of_particles
    assert not scene_faults(scene)


def test_a_mass_that_is_too_little_of_a_heavy_material_is_refused_before_any_run() -> None:
    test = Hopper(diameter="10 mm", fill_mass="800 g")

    assert not [*test.material_faults({"particle.density": 2500.0})]
    [fault] = test.material_faults({"particle.density": 11000.0})
    assert fault.key == "fill_mass"
    least = float(re.search(r"at least (.*) kg", str(fault)).group(1))
    enough = Hopper(diameter="10 mm", fill_mass=1.01 * least)
    assert not [*enough.material_faults({"particle.density": 11000.0})]
    assert [*enough.material_faults({"particle.density": 11400.0})]


@pytest.mark.slow
@pytest.mark.parametrize(
    "program", [Lammps, pytest.param(Liggghts, marks=needs.LIGGGHTS)], ids=lambda p: p.name
)
def test_a_steep_cone_runs_empty(program: type[DeckSolver], tmp_path: Path) -> None:
    found = simulated(Hopper(diameter="10 mm", **SMALL), tmp_path, GLASS_BEADS, program)

    filled = RunOutput(tmp_path).snapshot("bed").masses
    assert found["residual_mass"] == Response(0.0, pytest.approx(filled[0]))
    # The flow is nearly constant to the end.
    time = float(filled.sum()) / found["mass_flow"].value
    assert found["discharge_time"].value == pytest.approx(time, rel=0.15)
    assert "bulk_density" not in found


@pytest.mark.slow
def test_what_leaves_and_what_stays_is_what_was_filled_in(tmp_path: Path) -> None:
    test = Hopper(diameter="10 mm", half_angle="90 deg", **{**WEDGE, "width": "15 cm"})
    responses = Lammps(test, ROUGH).run({}, 1, Workspace(tmp_path, 300.0))

    residual, curve = responses["residual_mass"], responses["discharged_mass"]
    assert isinstance(residual, Response)
    assert isinstance(curve, Curve)
    filled = float(RunOutput(tmp_path).snapshot("bed").masses.sum())
    assert 0.05 * filled < residual.value < 0.5 * filled
    assert 0 < residual.standard_error < 0.3 * residual.value
    assert curve.values[-1] + residual.value == pytest.approx(filled, rel=0.01)
    assert test.view(RunOutput(tmp_path)).drawn_when == ""


@pytest.mark.slow
def test_a_material_that_arches_over_the_outlet_has_no_flow_and_no_time(tmp_path: Path) -> None:
    found = simulated(Hopper(diameter="10 mm", slot_width="15 mm", **WEDGE), tmp_path, ROUGH)

    assert found["mass_flow"].value == 0.0
    assert "discharge_time" not in found
    filled = float(RunOutput(tmp_path).snapshot("bed").masses.sum())
    assert found["residual_mass"].value == pytest.approx(filled, rel=0.2)
    drawn = Hopper(diameter="10 mm", slot_width="15 mm", **WEDGE).view(RunOutput(tmp_path))
    assert "arches over the slot" in drawn.measured_drawing(1.0).words


def test_a_smaller_bucket_has_a_narrower_outlet_and_its_flow_follows_beverloo() -> None:
    bucket = Hopper(
        diameter="4 mm",
        half_angle="90 deg",
        width="200 mm",
        orifice_diameter="50 mm",
        fill_height="200 mm",
    )
    half, small = (resized(bucket, times) for times in (0.75**3, 0.02))
    # 0.75 of 50 mm, and 8 d where that is wider.
    assert half.setup.orifice_diameter == pytest.approx(0.0375)
    assert small.setup.orifice_diameter == pytest.approx(0.032)
    assert resized(bucket, 2.0).setup.orifice_diameter == pytest.approx(0.05)
    flow = ((37.5 - 6) / (50 - 6)) ** 2.5
    assert growth(bucket, "mass_flow", 0.75**3) == pytest.approx(flow)
    assert growth(bucket, "discharge_time", 0.75**3) == pytest.approx(0.75**3 / flow)
    assert growth(bucket, "bulk_density", 0.02) == 1.0
    # A default outlet is as narrow as it can be.
    usual = Hopper(diameter="4 mm")
    assert growth(usual, "mass_flow", 0.5) == 1.0
    # The flow of a slot is that of its depth.
    slot = Hopper(diameter="10 mm", orifice="slot")
    assert growth(slot, "mass_flow", 8.0) == pytest.approx(2.0)


@pytest.mark.parametrize("diameter", [0.012, 0.018, 0.0508])
def test_the_flow_that_is_expected_of_a_round_outlet_is_beverloos(diameter: float) -> None:
    """0.58 rho sqrt(g) (D - 1.4 d)^2.5 (Beverloo, Leniger & van de Velde, 1961)."""
    setup = Hopper(diameter="3 mm", orifice_diameter=diameter, width=0.2).setup
    law = 0.58 * 0.58 * math.sqrt(setup.gravity) * (diameter - 1.4 * 0.003) ** 2.5

    assert setup.beverloo_flow == pytest.approx(law)
