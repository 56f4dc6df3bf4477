"""The shear test: geometry, closed plates, evaluation against closed forms, checks of validity."""

from __future__ import annotations

import math
import shutil
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy import ndimage
from scipy.spatial import cKDTree

import grainfit as gf
from grainfit.analysis.soft_particles import stiffness_notes
from grainfit.bulk_tests.abilities import material_faults
from grainfit.bulk_tests.natural_units import natural_run
from grainfit.bulk_tests.shared import messages
from grainfit.bulk_tests.shear import Shear
from grainfit.bulk_tests.shear.flow import Frame, block_mean, velocity_profile
from grainfit.bulk_tests.shear.setup import PlateLayout, plate_layout
from grainfit.bulk_tests.stiffness import overlap_law, stiffness_number
from grainfit.errors import InputError, RunFailedError
from grainfit.evaluation import Response
from grainfit.materials.sizes import ParticleSizes
from grainfit.measurement.particles import Particles, read_dump
from grainfit.scenes.run_output import RunOutput
from grainfit.scenes.scene import Load, Velocity
from grainfit.solvers.base import Workspace
from grainfit.solvers.dem.lammps.program import Lammps
from grainfit.testing.materials import ROUGH_SPHERES

BEADS = ParticleSizes((0.010,))
MIXTURES = [
    BEADS,
    ParticleSizes((0.008, 0.010, 0.012), (0.3, 0.4, 0.3)),
    ParticleSizes((0.0035, 0.010), (0.3, 0.7)),
]


def small(**options: object) -> Shear:
    """Return a shear test that runs in two seconds."""
    given = {"length": 0.07, "depth": 0.04, "gap": 0.07, "transient_strain": 0.5}
    return Shear(BEADS, **{**given, "averaged_strain": 1.0, **options})


# --- geometry ----------------------------------------------------------------------------------


def test_the_scene_has_the_wanted_inertial_number_stress_and_no_gravity():
    test = Shear(BEADS, normal_stress="400 Pa", inertial_number=0.05)
    scene = test.scene(ROUGH_SPHERES, 3)
    velocity, load = scene.stages[-1].motions_of("upper")

    assert isinstance(velocity, Velocity)
    assert isinstance(load, Load)
    rate = velocity.speed / 0.085
    density = ROUGH_SPHERES["particle.density"]
    assert rate * 0.010 / math.sqrt(400 / density) == pytest.approx(0.05)
    assert load.force == pytest.approx(-400 * 0.10 * 0.05)
    assert scene.gravity == 0.0
    strains = [rate * stage.until.time for stage in scene.stages[1:]]
    assert strains[0] == pytest.approx(1.5)
    assert sum(strains[1:]) == pytest.approx(4.5)
    # Between two snapshots nobody can go around half of the period.
    assert max(strains[1:]) * 0.085 <= 0.4 * 0.10 + 1e-12


@pytest.mark.parametrize("sizes", MIXTURES, ids=str)
def test_no_particle_touches_another_or_a_plate_at_the_beginning(sizes):
    scene = Shear(sizes).scene(ROUGH_SPHERES, 2)
    radii = np.array(sizes.diameters) / 2
    bed, own = scene.particles.positions, radii[scene.particles.size_indices]
    period = [scene.box.high[0], scene.box.high[1], 0]
    for plate in scene.glued.values():
        tree = cKDTree(plate.positions, boxsize=period)
        distance, index = tree.query(bed)
        assert (distance > own + radii[plate.size_indices][index]).all()
    assert scene.glued["lower"].positions[:, 2].mean() == pytest.approx(0, abs=3e-4)
    assert (scene.glued["upper"].positions[:, 2] > bed[:, 2].max()).all()


@pytest.mark.parametrize("sizes", MIXTURES, ids=str)
def test_the_smallest_particle_finds_no_way_through_a_plate(sizes):
    length, depth = 6 * max(sizes.diameters), 4 * max(sizes.diameters)
    layout = plate_layout(sizes, length, depth)
    smallest = min(sizes.diameters)
    assert not _is_open(layout, length, depth, smallest)
    # A plate whose particles are glued half as densely has holes, and the search finds them.
    loose = replace(layout, columns=layout.columns // 2, rows=layout.rows // 2)
    assert _is_open(loose, length, depth, smallest)


def _is_open(layout: PlateLayout, length: float, depth: float, smallest: float) -> bool:
    """Return whether the centre of a sphere can go from below a plate to above it."""
    plate = layout.glued(length, depth, 0.0, np.random.default_rng(1))
    grid, top = smallest / 5, layout.reach + smallest
    axes = [np.arange(0.0, length, grid), np.arange(0.0, depth, grid), np.arange(-top, top, grid)]
    places = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1)
    reach = (layout.diameter + smallest) / 2
    tree = cKDTree(plate.positions, boxsize=(length, depth, 0))
    distance, _ = tree.query(places.reshape(-1, 3), distance_upper_bound=reach)
    parts, _ = ndimage.label((distance > reach).reshape(places.shape[:3]))
    return bool(parts[0, 0, 0] == parts[0, 0, -1])


def test_defaults_are_the_same_test_at_every_size():
    runs = []
    for diameter, density, modulus in (
        (0.010, 2100.0, 3.6e5),
        (0.002, 800.0, 3.6e5 * 0.2 * 8 / 21),
    ):
        test = Shear(ParticleSizes((diameter,)), normal_stress=500 * modulus / 3.6e5)
        material = {
            **ROUGH_SPHERES,
            "particle.density": density,
            "particle.youngs_modulus": modulus,
            "wall.youngs_modulus": 1e13,
        }
        definition = Lammps(test, {}).definition(material, 1)
        scene = test.scene(material, 1)
        time = diameter / math.sqrt(test.setup.normal_stress / density)
        runs.append(natural_run(definition))
        steps = [scene.steps(stage.until.time) for stage in scene.stages]
        velocity, load = scene.stages[-1].motions_of("upper")
        numbers = [
            velocity.speed * time / diameter,
            load.force / (test.setup.normal_stress * diameter**2),
            load.gain * test.setup.normal_stress * diameter * time,
            scene.typical_load * density * diameter / test.setup.normal_stress,
        ]
        if len(runs) == 1:
            first = (steps, numbers, scene.particles.positions / diameter)
    assert runs[0].is_same(runs[1])
    assert steps == first[0]
    assert numbers == pytest.approx(first[1])
    assert scene.particles.positions / diameter == pytest.approx(first[2])


@pytest.mark.parametrize(
    ("options", "key", "message"),
    [
        ({"gap": "60 mm"}, "gap", "0.06 m is less than 7 of the largest particles"),
        ({"length": "5 cm"}, "length", "0.05 m is less than 6"),
        ({"depth": "1 cm"}, "depth", "0.01 m is less than 4"),
        ({"length": "400 m"}, "gap", "at most 1e+06 are allowed"),
        ({"inertial_number": 0.5}, "inertial_number", "0.5"),
        ({"normal_stress": "2 kg"}, "normal_stress", "has the unit kg"),
    ],
)
def test_an_impossible_option_is_named_with_its_value_and_a_remedy(options, key, message):
    with pytest.raises(InputError) as caught:
        Shear(BEADS, **options)
    (fault,) = caught.value.faults
    assert fault.key == key
    assert message in fault.message
    assert fault.remedy


def test_a_stress_that_is_too_much_for_the_particles_is_refused():
    test = Shear(BEADS, normal_stress="600 Pa")
    (fault,) = material_faults(test, ROUGH_SPHERES)
    assert fault.key == "normal_stress"
    assert messages.TOO_SOFT.is_in(str(fault), stress=600, modulus=360000, ratio=600)
    assert "at least 420000 Pa" in fault.remedy
    assert not list(material_faults(Shear(BEADS), ROUGH_SPHERES))
    assert not list(material_faults(test, {}))
    with pytest.raises(InputError, match=messages.TOO_SOFT.pattern):
        Lammps(test, ROUGH_SPHERES)


# --- evaluation --------------------------------------------------------------------------------


def _flow(velocity: Callable[[np.ndarray], np.ndarray], count: int = 4) -> list[Frame]:
    """Return snapshots of a bed between z = 0 and 8, in a period of 10, with a given velocity."""
    random = np.random.default_rng(1)
    start = random.random((2000, 3)) * [10, 5, 8]
    ones = np.ones(len(start))
    plates = [Particles(np.array([[5.0, 2.0, z]]), ones[:1], ones[:1]) for z in (0.0, 8.0)]
    frames = []
    for n in range(count):
        positions = start.copy()
        positions[:, 0] = (positions[:, 0] + 4.0 * n * velocity(start[:, 2] / 8)) % 10
        frames.append(Frame(2.0 * n, Particles(positions, ones / 2, ones), *plates))
    return frames


def test_the_velocity_profile_of_an_even_flow_is_a_straight_line():
    profile = velocity_profile(_flow(lambda z: z), 10.0, 2.0)
    assert profile.gap == pytest.approx(8.0)
    assert profile.velocities == pytest.approx(profile.heights / 8, abs=0.01)
    assert profile.middle_share == pytest.approx(0.5, abs=0.01)
    assert profile.steepest == pytest.approx(1.0, abs=0.05)


def test_a_band_of_shear_and_a_plug_are_told_from_an_even_flow():
    band = velocity_profile(_flow(lambda z: np.clip(4 * z - 1.5, 0, 1)), 10.0, 2.0)
    # 4 in truth; layers one diameter thick take a quarter off.
    assert band.steepest == pytest.approx(3.0, rel=0.05)
    assert band.middle_share == pytest.approx(1.0, abs=0.01)
    plug = velocity_profile(_flow(lambda z: 0.5 + 0 * z), 10.0, 2.0)
    assert plug.middle_share == pytest.approx(0.0, abs=0.01)


def test_a_lost_particle_is_refused():
    frames = _flow(lambda z: z)
    frames[2] = replace(frames[2], bed=frames[2].bed.select(np.arange(2000) > 0))
    with pytest.raises(RunFailedError, match="particles were lost"):
        velocity_profile(frames, 10.0, 2.0)


@pytest.mark.parametrize("correlation", [0.0, 0.4])
def test_the_standard_error_of_block_means_knows_their_correlation(correlation):
    random = np.random.default_rng(2)
    steps = random.normal(size=(3000, 30))
    blocks = np.zeros_like(steps)
    for n in range(1, 30):
        blocks[:, n] = correlation * blocks[:, n - 1] + steps[:, n]
    found = [block_mean(row) for row in blocks[:, 10:]]
    scatter = np.std([mean.value for mean in found])
    stated = math.sqrt(np.mean([mean.standard_error**2 for mean in found]))
    # Independent blocks would state 0.66 of the scatter at a correlation of 0.4.
    assert stated / scatter == pytest.approx(1.0, abs=0.15)


def test_equal_blocks_have_no_error():
    assert block_mean([2.0, 2.0, 2.0]).standard_error == 0.0


# --- validity: a real run, and what was changed in it -------------------------------------------


@pytest.fixture(scope="module")
def sheared(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, dict[str, Response]]:
    """Folder and responses of a small run."""
    folder = tmp_path_factory.mktemp("sheared")
    return folder, Lammps(small(), ROUGH_SPHERES).run({}, 4, Workspace(folder, 300.0))


@pytest.fixture
def changed(sheared: tuple[Path, dict[str, Response]], tmp_path: Path) -> Path:
    """Return a copy of the run, to be changed."""
    return Path(shutil.copytree(sheared[0], tmp_path / "run"))


def _scale(folder: Path, factors: dict[str, float]) -> None:
    """Multiply columns of all series."""
    for path in folder.glob("series_*.csv"):
        header, *rows = path.read_text().splitlines()
        names = header.split(",")
        table = np.array([[float(v) for v in row.split(",")] for row in rows])
        table *= [factors.get(name, 1.0) for name in names]
        lines = [",".join(map(repr, row)) for row in table.tolist()]
        path.write_text("\n".join([header, *lines]) + "\n")


def _move(folder: Path, snapshot: str, move: Callable[[np.ndarray], np.ndarray]) -> None:
    """Change the positions of the loose particles of a snapshot."""
    path = folder / f"snapshots/{snapshot}.dump"
    lines = path.read_text().splitlines()
    rows = [n for n in range(9, len(lines)) if lines[n].split()[7] == "0"]
    table = [lines[n].split() for n in rows]
    order = np.argsort([int(row[0]) for row in table])
    moved = move(np.array([table[n][2:5] for n in order], dtype=float))
    for n, place in zip(order, moved, strict=True):
        table[n][2:5] = map(repr, place.tolist())
        lines[rows[n]] = " ".join(table[n])
    path.write_text("\n".join(lines) + "\n")


def _refused(folder: Path, reason: str) -> None:
    with pytest.raises(RunFailedError, match=reason):
        small().measure(RunOutput(folder))


def test_a_small_bed_has_a_plausible_angle_and_density(sheared):
    folder, responses = sheared
    assert responses["internal_friction_angle"].value == pytest.approx(23.5, abs=3)
    assert 0.2 < responses["internal_friction_angle"].standard_error < 3
    # Mass of all particles over the space between the plates, which are half filled themselves.
    bed = read_dump(folder / "snapshots/sheared.dump")
    plates = [read_dump(folder / "snapshots/sheared.dump", n).positions[:, 2] for n in (1, 2)]
    mean = bed.masses.sum() / (0.07 * 0.04 * (plates[1].mean() - plates[0].mean() - 0.010))
    assert responses["shear_density"].value == pytest.approx(mean, rel=0.06)
    assert (folder / "sheared.vtk").read_bytes().startswith(b"# vtk")


def test_a_stress_that_is_not_held_fails_the_run(changed):
    _scale(changed, {"normal_lower": 1.02, "normal_upper": 1.02})
    _refused(changed, "normal stress was not held: 5.* Pa instead of 500 Pa")


def test_a_swing_of_the_moving_plate_is_no_other_stress(sheared, changed):
    _scale(changed, {"normal_upper": 1.3, "shear_upper": 0.6})
    found = small().measure(RunOutput(changed))
    for name, exact in sheared[1].items():
        assert abs(found[name].value - exact.value) < 2 * exact.standard_error, name


def test_a_particle_that_leaked_through_a_plate_fails_the_run(changed):
    def leak(positions: np.ndarray) -> np.ndarray:
        positions[7, 2] = -0.006
        return positions

    _move(changed, "frame1", leak)
    _refused(changed, "1 particles leaked through a plate")


def test_another_inertial_number_fails_the_run(changed):
    _scale(changed, {"travel": 1.4})
    _refused(changed, "inertial number is 0.02[0-9]* instead of 0.02")


@pytest.mark.parametrize(
    ("planned", "advice"),
    [(0.05, "looser .*; use a larger normal_stress"), (0.1, "denser .*; use sizes")],
)
def test_a_gap_that_is_not_the_planned_one_says_what_to_change(changed, planned, advice):
    # The speed belongs to the planned gap, and the gap of this run is 0.07 m.
    _scale(changed, {"travel": planned / 0.07})
    test = small()
    vars(test.setup).update(gap=planned, averaged_strain=0.07 / planned)
    with pytest.raises(RunFailedError, match=advice):
        test.measure(RunOutput(changed))


def test_a_bed_that_slips_at_the_plates_fails_the_run(changed):
    still = read_dump(changed / "snapshots/frame0.dump").positions
    for name in ("frame1", "frame2", "sheared"):
        _move(changed, name, lambda _: still)
    _refused(changed, "hardly sheared: its middle half took up 0%")


def test_localised_shear_fails_the_run(changed):
    still = read_dump(changed / "snapshots/frame0.dump").positions
    ways = RunOutput(changed)
    starts = ways.series("transient")["travel"][-1]
    for name, stage in (("frame1", "block1"), ("frame2", "block2"), ("sheared", "block3")):
        travel = ways.series(stage)["travel"][-1] - starts

        def shear(positions: np.ndarray, travel: float = travel) -> np.ndarray:
            share = np.clip((still[:, 2] - 0.03) / 0.01, 0, 1)
            return np.column_stack(((still[:, 0] + travel * share) % 0.07, still[:, 1:]))

        _move(changed, name, shear)
    _refused(changed, r"shear is localised: within two diameters the shear rate is \d")


def test_a_run_with_a_stage_that_broke_fails(changed):
    path = changed / "stages.csv"
    path.write_text(path.read_text().replace("block1,done", "block1,broken"))
    _refused(changed, "particles broke out of the gap between the plates")


def test_particles_that_are_far_too_soft_fail_the_run(tmp_path):
    # Only the solver's own check of the material is left out: the run is real.
    soft = {**ROUGH_SPHERES, "particle.youngs_modulus": 1.2e4}
    test = small(transient_strain=0.2, averaged_strain=0.3)
    out = Lammps(test, {}).simulate(test.scene(soft, 1), Workspace(tmp_path, 300.0))
    with pytest.raises(RunFailedError, match=r"overlap grossly|leaked|inertial number"):
        test.measure(out)


def test_check_tells_how_much_soft_particles_raise_the_density_in_shear():
    test = Shear(BEADS)
    assert stiffness_number(test, ROUGH_SPHERES) == pytest.approx(720)
    assert overlap_law(test).excess(720) == pytest.approx(0.091, abs=0.001)
    targets = [gf.Target("shear_density", 1230), gf.Target("internal_friction_angle", 23.5)]
    problem = gf.Problem([gf.Parameter("particle.density", 2000, 2200)], targets)
    (note,) = stiffness_notes(problem, {"shear": test}, ROUGH_SPHERES)
    assert "E/normal stress = 720: shear_density is about 9.1 % above that of stiff" in note
    assert "internal_friction_angle" not in note


@pytest.mark.slow
def test_spheres_of_little_restitution_are_sheared(tmp_path):
    """Their dashpots overcame the control of the plate, which bounced on the bed."""
    material = {
        **ROUGH_SPHERES,
        "particle.youngs_modulus": 20e6,
        "particle.poissons_ratio": 0.3,
        "particle.density": 2000.0,
        "particle_particle.sliding_friction": 0.3,
        "particle_particle.rolling_friction": 0.43,
        "particle_particle.rolling_damping": 0.0,
        "particle_particle.restitution": 0.29,
        "particle_wall.restitution": 0.29,
    }
    lengths = {"length": "86.5 mm", "depth": "43.3 mm", "gap": "73.5 mm"}
    step = {"time_step_fraction": 0.22, "averaged_strain": 2.0}
    test = Shear(diameter="10 mm", normal_stress="4 kPa", **lengths, **step)

    responses = Lammps(test, material).run({}, 1, Workspace(tmp_path, 300.0))
    assert 18 < responses["internal_friction_angle"].value < 30


@pytest.mark.parametrize(("restitution", "slower"), [(0.9, 1.0), (0.6, 1.0), (0.2, 2.0)])
def test_the_control_of_the_plate_is_slower_where_contacts_overcome_it(restitution, slower):
    def gain(value):
        material = {**ROUGH_SPHERES, "particle.youngs_modulus": 2e6}
        material["particle_particle.restitution"] = value
        load = Shear(diameter="10 mm").setup.motions(material)[1]
        return load.gain

    assert gain(0.9) / gain(restitution) == pytest.approx(slower, rel=0.3)
