"""Coarse graining: larger particles in the apparatus of the real ones."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import pytest

import grainfit as gf
from grainfit.bulk_tests.abilities import material_faults
from grainfit.bulk_tests.base import BulkTest
from grainfit.bulk_tests.checks import CheckedTest
from grainfit.bulk_tests.discharge import Discharge
from grainfit.bulk_tests.draw_down import DrawDown
from grainfit.bulk_tests.heap import Heap
from grainfit.bulk_tests.packing import Packing
from grainfit.bulk_tests.registry import BUILT_IN
from grainfit.bulk_tests.shared import messages
from grainfit.contact_models.registry import simulated_material
from grainfit.errors import InputError
from grainfit.materials.particle_shape import ParticleShape
from grainfit.materials.sizes import ParticleSizes
from grainfit.options.kinds import Quantity
from grainfit.solvers.base import Workspace
from grainfit.solvers.dem.lammps.program import Lammps
from grainfit.solvers.dem.liggghts.program import Liggghts
from grainfit.testing.materials import GLASS_BEADS

REAL = ParticleSizes((0.004, 0.005), (0.25, 0.75))
TWICE = ParticleSizes((0.008, 0.010), (0.25, 0.75))
FILE = """
name = "pellets"
[particle]
diameter = "3 mm"
coarse_graining = FACTOR
density = 1000
youngs_modulus = "5 MPa"
poissons_ratio = 0.3
[wall]
youngs_modulus = "5 MPa"
poissons_ratio = 0.3
density = 1000
[particle_particle]
sliding_friction = { min = 0.1, max = 0.8 }
rolling_friction = { min = 0.01, max = 0.4 }
restitution = 0.5
rolling_damping = 0
[particle_wall]
sliding_friction = 0.4
rolling_friction = 0.1
restitution = 0.5
rolling_damping = 0
[[test]]
type = "heap"
plate_sliding_friction = 0.5
plate_rolling_friction = "particle_particle"
solver = "lammps"
cylinder_radius = "50 mm"
strike_off_height = "150 mm"
plate_radius = "140 mm"
bulk_density_top = "120 mm"
lift_height = "150 mm"
targets.bulk_density = { value = "540 kg/m^3", tolerance = "3 %" }
targets.angle_of_repose = { value = "34 deg", tolerance = "2 deg" }
"""


def apparatus(test: BulkTest) -> dict[str, Any]:
    """Return the lengths, speeds and stresses of a test."""
    resolved = test.resolved_options()
    kinds = {key.name: key.kind for key in test.option_keys() if resolved[key.name] is not None}
    return {
        name: resolved[name]
        for name, kind in kinds.items()
        if isinstance(kind, Quantity) and kind.unit not in {None, "", "s", "m/s^2"}
    }


def pellets(folder: Path, factor: float) -> Path:
    path = folder / "pellets.toml"
    path.write_text(FILE.replace("FACTOR", str(factor)))
    return path


@pytest.mark.parametrize("kind", BUILT_IN.values(), ids=BUILT_IN)
def test_coarse_grained_test_is_that_of_larger_particles_in_the_same_apparatus(kind):
    large = kind(TWICE)

    coarse = kind(REAL.coarse_grained(2), **apparatus(large))

    assert coarse.definition() == {**large.definition(), "coarse_graining": 2}
    assert kind.from_definition(coarse.definition()).definition() == coarse.definition()


@pytest.mark.parametrize("kind", BUILT_IN.values(), ids=BUILT_IN)
def test_coarse_grained_defaults_are_those_of_the_real_particles(kind):
    real = kind(REAL)

    coarse = kind(REAL.coarse_grained(1.02))

    lengths = apparatus(coarse)
    assert lengths == pytest.approx(apparatus(real))
    assert len(lengths) > 2
    assert coarse.number_of_particles < real.number_of_particles


def test_coarse_grained_run_is_that_of_larger_particles(tmp_path):
    large = Packing(TWICE, cylinder_radius=0.03, fill_height=0.06)
    coarse = Packing(REAL.coarse_grained(2), **apparatus(large))

    responses = []
    for number, test in enumerate((large, coarse)):
        (tmp_path / str(number)).mkdir()
        workspace = Workspace(tmp_path / str(number))
        responses.append(Lammps(test, GLASS_BEADS).run({}, 1, workspace)["bulk_density"])

    assert responses[0] == responses[1]


def test_coarse_graining_of_one_changes_no_identity():
    assert Heap(REAL.coarse_grained(1)).definition() == Heap(REAL).definition()


def test_file_with_coarse_graining_simulates_fewer_particles_with_longer_steps(tmp_path):
    one, two = (gf.load(pellets(tmp_path, factor)) for factor in (1, 2))
    middle = one.problem.from_unit([0.5, 0.5])
    costs = [setup.solvers["heap"].estimate_cost(middle) for setup in (one, two)]

    assert costs[0].particles == pytest.approx(8 * costs[1].particles, rel=0.01)
    assert 2 * costs[0].time_step == pytest.approx(costs[1].time_step)
    rayleigh = [setup.problem.rayleigh(middle) for setup in (one, two)]
    assert 2 * rayleigh[0] == pytest.approx(rayleigh[1])


def test_factor_that_leaves_no_room_is_refused_with_the_largest_that_does(tmp_path):
    words = r"narrower.*Or use particle\.coarse_graining = 8\.33 at most: particles are 9 times"
    with pytest.raises(InputError, match=words):
        gf.load(pellets(tmp_path, 9))

    gf.load(pellets(tmp_path, 8.33))


@pytest.mark.parametrize("kind", BUILT_IN.values(), ids=BUILT_IN)
def test_largest_factor_is_named_for_everything_that_is_too_narrow(kind):
    with pytest.raises(InputError) as refused:
        kind(REAL.coarse_grained(50))

    remedies = [fault.remedy for fault in refused.value.faults]
    [factor] = {float(*re.findall(r"coarse_graining = (\S+) at most", words)) for words in remedies}
    assert [*material_faults(kind(REAL.coarse_grained(factor)), {})] == []
    with pytest.raises(InputError):
        cohesionless(kind(REAL.coarse_grained(factor + 0.01)))


def test_factor_has_to_go_where_only_the_real_particles_fit():
    with pytest.raises(InputError, match=r"Or leave particle\.coarse_graining out: .* 1\.5 times"):
        Packing(REAL.coarse_grained(1.5), cylinder_radius=0.01)


def test_no_factor_is_named_where_the_real_particles_are_too_large_too():
    least = messages.CYLINDER_IS_NARROW.matching(least=0.02)
    with pytest.raises(InputError, match=rf"{least} Particles are 2 times as large"):
        Packing(REAL.coarse_grained(2), cylinder_radius=0.009)


def test_no_factor_is_named_for_clumps_whose_extent_is_not_known():
    pairs = ParticleSizes((0.005,), shape=ParticleShape("two_spheres"))
    with pytest.raises(InputError, match=r"Particles are 2\.4 times as large") as refused:
        Discharge(pairs.coarse_grained(2.4))
    assert "at most" not in str(refused.value)


def test_factor_is_named_where_real_particles_would_be_too_many():
    # The cylinder holds millions of grains of 0.2 mm.
    room = {"cylinder_radius": 0.1, "fill_height": 0.3, "bulk_density_top": 0.2}
    grains = ParticleSizes((0.0002,))
    with pytest.raises(InputError, match=messages.TOO_MANY_PARTICLES.pattern):
        Packing(grains, **room)

    with pytest.raises(InputError, match=r"coarse_graining = 250 at most"):
        Packing(grains.coarse_grained(400), **room)


@pytest.mark.parametrize("factor", [0.5, 1e4, '"x"', "[2]", "nan"])
def test_impossible_factor_is_refused_by_its_line(tmp_path, factor):
    with pytest.raises(InputError, match=r"line 5, particle\.coarse_graining"):
        gf.load(pellets(tmp_path, factor))


def test_check_proposes_a_factor_where_a_run_takes_hours(tmp_path):
    slow, fast = (gf.load(pellets(tmp_path, factor)).notes() for factor in (1, 3))

    assert any("particle.coarse_graining = 2 " in note for note in slow)
    assert not any("coarse_graining" in note for note in fast)


def test_surface_energy_of_simulated_particles_grows_with_the_factor():
    real = {
        "particle.youngs_modulus": 5e6,
        "particle_particle.surface_energy": 0.1,
        "particle_wall.steel.surface_energy": 0.2,
        "particle_particle.cohesion_energy_density": 300.0,
        "friction of the user": 0.3,
    }

    simulated = simulated_material(real, 4.0)

    assert simulated == {
        **real,
        "particle_particle.surface_energy": 0.4,
        "particle_wall.steel.surface_energy": 0.8,
    }


def test_coarse_grained_scene_has_the_surface_energy_of_its_particles():
    """A deck of larger particles has the surface energy with which their bed is as cohesive."""
    cohesive = {**GLASS_BEADS, "particle_particle.surface_energy": 0.05}
    solver = Lammps(
        Packing(REAL.coarse_grained(2), cylinder_radius=0.03, fill_height=0.06), cohesive
    )

    scene = solver.scene({}, 1)

    assert scene.material["particle_particle.surface_energy"] == pytest.approx(0.1)
    assert solver.run_parameters({})["particle_particle.surface_energy"] == 0.05


def test_proposed_factor_changes_a_given_number_of_particles_with_it(tmp_path):
    """A factor alone would leave as many particles, which do not fit into the cylinder."""
    path = pellets(tmp_path, 1)
    given = path.read_text().replace('type = "heap"', 'type = "heap"\nparticle_count = 60000')
    path.write_text(given)

    [note] = [note for note in gf.load(path).notes() if "coarse_graining" in note]

    words = re.search(r"coarse_graining = (\S+) and particle_count = (\d+) in test heap", note)
    assert words is not None
    factor, count = float(words[1]), int(words[2])
    assert count == pytest.approx(60000 / factor**3, rel=0.01)
    coarser = given.replace("coarse_graining = 1", f"coarse_graining = {factor}")
    path.write_text(coarser.replace("60000", str(count)))
    assert gf.load(path).bulk_tests["heap"].number_of_particles == count


def test_number_of_particles_far_above_the_strike_off_height_is_noted(tmp_path):
    path = pellets(tmp_path, 2.5)
    text = path.read_text().replace('type = "heap"', 'type = "heap"\nparticle_count = COUNT')
    notes = {}
    for count in (5000, 40000):
        path.write_text(text.replace("COUNT", str(count)))
        notes[count] = [note for note in gf.load(path).notes() if "strike_off_height" in note]

    assert notes[5000] == []
    [note] = notes[40000]
    assert "particle_count = 40000" in note
    assert "cut off" in note


SMALL = ParticleSizes((0.002,))
SLENDER = ParticleSizes((0.002,), shape=ParticleShape("cylinder", aspect_ratio=3.0))
BOX = {"width": "160 mm", "fill_height": "160 mm"}
SLOT_BOX = {**BOX, "depth": "80 mm", "slot_width": "20 mm"}
ROUND_BOX = {**BOX, "orifice": "round", "orifice_diameter": "20 mm"}


def cohesionless(test: BulkTest) -> Lammps | Liggghts:
    return (Liggghts if getattr(test, "orifice", "") == "round" else Lammps)(test, GLASS_BEADS)


@pytest.mark.parametrize(
    ("kind", "options", "sizes", "largest"),
    [
        (Discharge, SLOT_BOX, SMALL, 2.5),
        (Discharge, ROUND_BOX, SMALL, 2.5),
        (DrawDown, SLOT_BOX, SMALL, 2.5),
        (Discharge, SLOT_BOX, ParticleSizes((0.002, 0.0025), (0.8, 0.2)), 2.0),
        (Discharge, SLOT_BOX, SLENDER, 1.29),
    ],
)
def test_orifice_of_less_than_four_simulated_particles_is_refused_with_the_largest_factor(
    kind: type[BulkTest], options: dict[str, Any], sizes: ParticleSizes, largest: float
) -> None:
    with pytest.raises(InputError, match=f"coarse_graining = {largest:g} at most"):
        cohesionless(kind(sizes.coarse_grained(largest + 0.01), **options))

    cohesionless(kind(sizes.coarse_grained(largest), **options))


def test_orifice_that_is_narrow_for_the_real_particles_is_refused_with_enlarged_ones_only() -> None:
    narrow = {**SLOT_BOX, "slot_width": "6 mm"}
    cohesionless(Discharge(SMALL, **narrow))

    with pytest.raises(InputError, match=r"Leave particle\.coarse_graining out, or a slot"):
        cohesionless(Discharge(SMALL.coarse_grained(1.1), **narrow))


def test_orifice_is_wide_enough_for_the_most_slender_particles_of_an_interval() -> None:
    unknown = ParticleSizes((0.002,), shape=ParticleShape("cylinder")).coarse_grained(2)
    solver = cohesionless(Discharge(unknown, **SLOT_BOX))

    assert solver.interval_faults({"particle.aspect_ratio": (1.0, 1.2)}) == []
    [fault] = solver.interval_faults({"particle.aspect_ratio": (1.0, 3.0)})
    assert (fault.key, "= 1.29 at most" in fault.remedy) == ("slot_width", True)


def test_factor_for_an_interval_of_aspect_ratios_is_never_that_of_spheres() -> None:
    # Spheres of this size would arch, too; a factor for them would be refused in turn.
    unknown = ParticleSizes((0.002,), shape=ParticleShape("cylinder")).coarse_grained(3)
    solver = cohesionless(Discharge(unknown, **SLOT_BOX))

    [fault] = solver.interval_faults({"particle.aspect_ratio": (1.0, 3.0)})
    assert "= 1.29 at most" in fault.remedy


def beside_a_discharge(folder: Path) -> Path:
    """Return the file of the pellets with a slot of 30 mm for the same material."""
    path = pellets(folder, 1)
    path.write_text(
        path.read_text()
        + """
[[test]]
type = "discharge"
solver = "lammps"
width = "160 mm"
depth = "50 mm"
fill_height = "100 mm"
slot_width = "30 mm"
targets.mass_flow = { value = 1 }
"""
    )
    return path


def test_no_factor_is_proposed_at_which_another_test_of_the_file_is_refused(tmp_path):
    """Particles have one factor in all tests: 30 mm are four of them at 2.5."""
    path = beside_a_discharge(tmp_path)
    path.write_text(path.read_text().replace('"150 mm"', '"450 mm"'))

    notes = "\n".join(gf.load(path).notes())

    proposed = {float(factor) for factor in re.findall(r"coarse_graining = ([\d.]+)", notes)}
    assert max(proposed) == 2.5
    wider = path.read_text().replace('slot_width = "30 mm"', 'slot_width = "60 mm"')
    path.write_text(wider)
    notes = "\n".join(gf.load(path).notes())
    assert "coarse_graining = 4" in notes


@pytest.mark.parametrize(
    ("test", "words"),
    [
        (
            Discharge(SMALL, slot_width="7 mm"),
            "a slot of 7 mm is 3.5 times as wide as the largest particles (2 mm)",
        ),
        (Discharge(SMALL), ""),
        (
            Discharge(SLENDER, slot_width="9 mm"),
            "9 mm is 2.33 times as wide as the largest particles (3.86 mm)",
        ),
        (Discharge(SMALL, **{**ROUND_BOX, "orifice_diameter": "7 mm"}), "an orifice of 7 mm"),
        (DrawDown(SMALL, slot_width="7 mm"), "a slot of 7 mm"),
    ],
)
def test_orifice_of_a_laboratory_that_is_narrow_for_the_real_particles_is_noted(
    test: BulkTest, words: str
) -> None:
    checked = CheckedTest(test, {}, {}, {})
    found = [one.text for check in test.checks for one in check(checked)]

    assert len(found) == bool(words)
    assert words in "".join(found)
