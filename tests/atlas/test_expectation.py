"""What the atlas says that a response depends on, with walls of several materials."""

from __future__ import annotations

import numpy as np
import pytest

import grainfit as gf
from grainfit.atlas import messages
from grainfit.atlas.expectation import Expectation
from grainfit.atlas.reading import NotInAtlasError, Reading
from grainfit.testing.materials import GLASS_BEADS, ROUGH_PLATE

DENSITY, MODULUS = "particle.density", "particle.youngs_modulus"
STEEL = {
    name.replace("wall.", "wall.steel."): value
    for name, value in GLASS_BEADS.items()
    if "wall." in name
}
BEADS = {**GLASS_BEADS, "particle_particle.rolling_damping": 0.0}
OWN = "particle_wall.steel.sliding_friction"


def heap(material: dict[str, float], walls: dict[str, str], **options: object) -> gf.solvers.Lammps:
    return gf.solvers.Lammps(gf.tests.Heap(diameter="10 mm", **options), material, walls=walls)


def inputs(solver: gf.solvers.Lammps) -> dict[str, float]:
    reading = Reading(solver, {}, is_nearest=True)
    return reading.inputs(solver.run_parameters({}))


def test_a_plate_of_another_wall_is_one_with_a_friction_of_its_own() -> None:
    plain = heap(BEADS, {}, plate_sliding_friction=0.7)
    apart = heap({**BEADS, **STEEL, OWN: 0.7}, {"plate": "steel"})
    assert inputs(apart) == inputs(plain)


def test_the_wall_that_most_particles_touch_is_the_wall_of_the_atlas() -> None:
    cylinder = heap({**BEADS, **STEEL, OWN: 0.9}, {"cylinder": "steel"}, plate_sliding_friction=0.7)
    assert inputs(cylinder)["particle_wall.sliding_friction"] == 0.9


def test_it_says_of_which_frictions_it_tells() -> None:
    material = {**BEADS, **STEEL}
    told = Expectation(heap(material, {"plate": "steel"}), {}).tells_of
    assert told(OWN)
    assert told("particle_wall.rolling_friction")
    # Plates of the rows are as rough as the particles when these roll.
    assert not told("particle_wall.steel.rolling_friction")
    assert not told("particle.aspect_ratio")
    assert not told("particle_particle.surface_energy")


def test_a_part_that_no_row_varies_is_not_told_but_for_derivatives() -> None:
    hopper = gf.solvers.Lammps(
        gf.tests.Hopper(diameter="10 mm"), {**BEADS, **STEEL}, walls={"container": "steel"}
    )
    with pytest.raises(NotInAtlasError, match=messages.WALLS.pattern):
        Reading(hopper, {})
    assert Expectation(hopper, {}).responses({DENSITY: np.array([2000.0, 2500.0])}, ["mass_flow"])


def test_bulk_densities_follow_the_density_beyond_the_rows_of_stiffness() -> None:
    solver = heap({n: v for n, v in BEADS.items() if n != DENSITY}, {}, **ROUGH_PLATE)
    found = Expectation(solver, {DENSITY: 2000.0}).responses(
        {DENSITY: np.array([1000.0, 2000.0])}, ["bulk_density"]
    )
    assert found.keys() == {"bulk_density"}
    low, high = found["bulk_density"].means
    assert 2.0 <= high / low < 2.1
    assert found["bulk_density"].covariance.shape == (2, 2)
    assert found["bulk_density"].scatter == pytest.approx(0.006)
