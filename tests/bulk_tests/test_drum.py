"""Drum: geometry, what is refused, angles of known beds, and runs that mean nothing."""

from __future__ import annotations

import math
import re
from pathlib import Path

import numpy as np
import pytest

from grainfit.bulk_tests.apparatus import apparatus_of
from grainfit.bulk_tests.base import BulkTest
from grainfit.bulk_tests.checks import CheckedTest
from grainfit.bulk_tests.drum import Drum, messages
from grainfit.bulk_tests.drum.angles import DrumAngles
from grainfit.bulk_tests.drum.bed import TurningBed
from grainfit.bulk_tests.drum.end_caps import coarse_caps
from grainfit.bulk_tests.drum.soft_beds import soft_drum
from grainfit.bulk_tests.shear import Shear
from grainfit.errors import InputError, NotMeasurableError, RunFailedError
from grainfit.materials.sizes import ParticleSizes
from grainfit.measurement.particles import Frame, Particles
from grainfit.solvers.base import Workspace
from grainfit.solvers.dem.lammps.program import Lammps
from grainfit.testing.materials import ROUGH_SPHERES

SETUP = Drum(diameter="10 mm").setup
RADIUS, LENGTH = SETUP.drum_radius, SETUP.drum_length


def faults_of(**options: object) -> dict[str, str]:
    with pytest.raises(InputError) as caught:
        Drum(diameter="10 mm", **options)
    return {fault.key: str(fault) for fault in caught.value.faults}


def bed_below(surface, turned: float = 0.0, frames: int = 12) -> TurningBed:
    """Return a bed of many small particles below a surface ``height(across)``.

    Each frame has others; or they turn as a body by a share of the drum's rotation.
    """
    random = np.random.default_rng(3)
    count = 30 * SETUP.particle_count
    found = []
    for _ in range(frames):
        y, z = random.uniform(-RADIUS, RADIUS, (2, count))
        inside = (np.hypot(y, z) < RADIUS) & (z < surface(y))
        found.append((y[inside], z[inside]))
    fewest = min(len(y) for y, _ in found)
    # As many spheres as fill the bed to 0.58 with their own volume.
    volume = 0.58 * LENGTH * 4 * RADIUS**2 * np.mean([len(y) for y, _ in found]) / count
    radii = np.full(fewest, (volume / fewest * 3 / 4 / math.pi) ** (1 / 3))
    last = Particles(np.zeros((fewest, 3)), radii, np.ones(fewest))
    across = np.array([y[:fewest] for y, _ in found])
    heights = np.array([z[:fewest] for _, z in found])
    if turned:
        azimuth = np.arange(frames) * turned * SETUP.rotational_speed * SETUP.frame_interval
        across, heights = (
            across[0] * np.cos(azimuth)[:, None] - heights[0] * np.sin(azimuth)[:, None],
            across[0] * np.sin(azimuth)[:, None] + heights[0] * np.cos(azimuth)[:, None],
        )
    times = SETUP.frame_interval * np.arange(frames)
    return TurningBed(SETUP, last, times, across, heights)


def test_defaults_follow_the_diameter() -> None:
    small, large = Drum(diameter="2 mm").setup, Drum(diameter="50 mm").setup

    assert small.particle_count == large.particle_count == 534
    assert large.drum_radius == pytest.approx(0.4)
    assert large.turn_time == pytest.approx(5 * small.turn_time)
    # One turn of the trials: 178 sqrt(d/g).
    assert small.turn_time == pytest.approx(178 * math.sqrt(0.002 / 9.81), rel=2e-3)


def test_speed_and_froude_number_are_the_same_test() -> None:
    by_number = Drum(diameter="10 mm", froude_number=0.02)
    speed = by_number.setup.rotational_speed
    by_speed = Drum(diameter="10 mm", rotational_speed=speed)

    assert speed**2 * RADIUS / 9.81 == pytest.approx(0.02)
    assert by_number.definition() == by_speed.definition()
    assert Drum(diameter="10 mm", froude_number=0.01).definition() == (
        Drum(diameter="10 mm").definition()
    )


def test_a_fast_drum_is_averaged_over_more_turns() -> None:
    slow, fast = (Drum(diameter="10 mm", froude_number=n).setup for n in (0.01, 0.05))

    assert slow.averaged_turns == 0.9
    assert fast.averaged_turns * fast.turn_time == pytest.approx(150 * math.sqrt(0.01 / 9.81))


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({"drum_radius": "4 cm"}, "drum_radius: .* 0.04 m .* Use at least 0.05 m"),
        ({"drum_length": "3 cm"}, "drum_length: .* 0.03 m .* Use at least 0.04 m"),
        ({"fill_level": 0.6, "drum_radius": "5 cm"}, "fill_level: 0.6 .* Use at most 0.5"),
        ({"drum_radius": "90 m"}, r"drum_radius: \d+ particles are more than 1000000"),
        ({"rotational_speed": "20 rad/s"}, "rotational_speed: 191 rpm .* at most 46.8 rpm"),
        ({"froude_number": 0.4}, "rotational_speed: .* number of 0.4. .* no one angle"),
        (
            {"rotational_speed": 1.0, "froude_number": 0.01},
            "froude_number: 0.01 is given beside the rotational_speed 9.55 rpm. Give one of them",
        ),
    ],
)
def test_impossible_options_are_refused_with_a_remedy(options, said) -> None:
    key = said.split(":")[0]
    assert re.search(said, faults_of(**options)[key])


def test_the_lining_is_spread_over_the_wall() -> None:
    places = SETUP.lining_places()

    assert len(places) == 75
    assert np.hypot(places[:, 1], places[:, 2]) == pytest.approx(RADIUS)
    assert ((places[:, 0] >= 0) & (places[:, 0] < LENGTH)).all()
    apart = places[:, None] - places
    apart[..., 0] -= LENGTH * np.round(apart[..., 0] / LENGTH)
    distances = np.linalg.norm(apart, axis=2) + np.eye(75)
    assert 0.0195 < distances.min() < 0.023
    # No row of a mixture is lined with its finest particles.
    mixture = Drum(ParticleSizes((0.010, 0.002), (0.9, 0.1))).setup
    assert mixture.lining_diameter == 0.010


@pytest.mark.parametrize("angle", [20.0, 35.0])
def test_a_plane_bed_has_one_angle(angle: float) -> None:
    slope = math.tan(math.radians(angle))
    angles = DrumAngles(bed_below(lambda y: slope * y - 0.01))

    assert angles.mean == pytest.approx(angle, abs=0.4)
    for name, flank in angles.flanks().items():
        assert flank.angle == pytest.approx(angle, abs=0.7), name
        (y1, z1), (y2, z2) = flank.start, flank.end
        assert math.degrees(math.atan2(z2 - z1, y2 - y1)) == pytest.approx(flank.angle)
        # Half a layer of cells below the surface at most.
        assert z1 == pytest.approx(slope * y1 - 0.01, abs=0.002)
    curve = angles.surface.curve()
    across, heights = np.array(curve.coordinates), np.array(curve.values)
    middle = np.abs(across) < 0.6 * RADIUS * math.cos(math.radians(angle))
    assert middle.sum() > 15
    assert heights[middle] == pytest.approx(slope * across[middle] - 0.01, abs=0.003)


def test_the_halves_of_a_bent_surface_have_their_own_angles() -> None:
    upper, lower = math.tan(math.radians(25)), math.tan(math.radians(40))
    # The middle of the surface is below the axis, on the line to the centre of mass.
    middle = 0.02 * np.array([math.sin(math.radians(32)), -math.cos(math.radians(32))])

    def surface(y):
        beside = y - middle[0]
        return middle[1] + np.where(beside > 0, upper, lower) * beside

    flanks = DrumAngles(bed_below(surface)).flanks()
    assert flanks["upper_angle"].angle == pytest.approx(25, abs=1.5)
    assert flanks["lower_angle"].angle == pytest.approx(40, abs=1.5)


@pytest.mark.parametrize("turned", [1.0, 0.7, 0.05])
def test_slip_is_what_the_bed_lags_behind_the_drum(turned: float) -> None:
    bed = bed_below(lambda y: 0 * y - 0.01, turned)
    surface = bed.surface(0.0, slice(0, 1))

    assert bed.slip(surface) == pytest.approx(1 - turned, abs=1e-9)


def test_particles_above_the_ends_of_the_bed_are_counted() -> None:
    bed = bed_below(lambda y: 0 * y - 0.01)
    assert bed.share_above(0.0) == 0.0
    assert bed.share_above(180.0) > 0.5


def test_a_bed_that_lost_particles_or_was_recorded_too_rarely_is_refused() -> None:
    def frame(step: int, count: int) -> Frame:
        return Frame(step, Particles(np.zeros((count, 3)), np.ones(count), np.ones(count)))

    with pytest.raises(RunFailedError, match=messages.PARTICLES_LOST.matching(first=5, last=4)):
        TurningBed.of([*(frame(n, 5) for n in range(9)), frame(9, 4)], SETUP, 1e-3)
    with pytest.raises(NotMeasurableError, match="recorded 3 times"):
        TurningBed.of([frame(n, 5) for n in range(3)], SETUP, 1e-3)


def test_a_drum_with_end_caps_ends_there_and_a_slice_is_the_run_that_it_was() -> None:
    sizes = ParticleSizes((0.008, 0.010), (0.4, 0.6))
    drum = Drum(sizes, drum_length="50 mm", end_caps=True)
    column = drum.column(3)
    x, radii = column.positions[:, 0], np.array(sizes.diameters)[column.size_indices] / 2
    scene = drum.scene(ROUGH_SPHERES, 3)

    assert (x > radii).all()
    assert (x < 0.05 - radii).all()
    assert scene.box.periodic == ""
    assert set(scene.stages[0].motions) == {"drum", "cap", "other_cap", "lining"}
    assert "end_caps" not in Drum(diameter="10 mm", end_caps=False).definition()
    assert Drum.from_definition(drum.definition()) == Drum(
        sizes, **{key: drum.definition()[key] for key in drum.given_options()}
    )


def test_end_caps_carry_the_bed_up(tmp_path: Path) -> None:
    angles = {}
    for end_caps in (False, True):
        workspace = Workspace(tmp_path / str(end_caps), 300)
        workspace.folder.mkdir()
        drum = short(end_caps=end_caps)
        run = Lammps(drum, ROUGH_SPHERES).simulate(drum.scene(ROUGH_SPHERES, 1), workspace)
        angles[end_caps] = drum.view(run).angles.bed.inclinations.mean()
    assert 2.0 < angles[True] - angles[False] < 8.0


def short(**options: object) -> Drum:
    """Return a drum of a second or two."""
    given: dict = {"drum_length": "4 cm", "froude_number": 0.05, "averaged_turns": 0.5}
    return Drum(diameter="10 mm", **{**given, "discarded_turns": 0.2, **options})


@pytest.mark.slow
def test_a_smooth_drum_that_slides_under_its_bed_is_refused(tmp_path: Path) -> None:
    # Its angle is as plausible as any.
    material = {**ROUGH_SPHERES, "particle_wall.sliding_friction": 0.27}
    with pytest.raises(RunFailedError, match=messages.BED_SLIDES.pattern):
        Lammps(short(lining=False), material).run({}, 1, Workspace(tmp_path, 300))

    assert (tmp_path / "drum.png").exists()


@pytest.mark.slow
def test_a_drum_that_carries_its_particles_round_is_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    # So it is before the run where the speed alone does it.
    monkeypatch.setattr("grainfit.bulk_tests.drum.setup.FASTEST", 1.0)
    drum = short(froude_number=1.0, averaged_turns=1.0)
    with pytest.raises(RunFailedError, match=messages.CARRIED_ROUND.pattern):
        Lammps(drum, ROUGH_SPHERES).run({}, 1, Workspace(tmp_path, 300))


def said_of_caps(factor: float, *, end_caps: bool = True) -> str:
    drum = Drum(
        ParticleSizes((1.2e-3 * factor,), coarse_graining=factor),
        drum_radius="42 mm",
        drum_length="20 mm",
        end_caps=end_caps,
    )
    checked = CheckedTest(drum, {}, {}, {"dynamic_angle": 40.0})
    return " ".join(found.text for found in coarse_caps(checked))


def test_enlarged_particles_between_end_caps_are_said_to_be_steeper() -> None:
    """1.2 degrees by 20 d / length at twice the diameter, and what is told apart at 1.4 times."""
    said = said_of_caps(2.0)
    assert messages.COARSE_CAPS.is_in(said, factor=2.0, more=1.2, told=0.5, largest="1.4")
    assert said_of_caps(1.4) == said_of_caps(1.0) == said_of_caps(2.0, end_caps=False) == ""


@pytest.mark.parametrize(("test", "glued"), [(Drum, 75), (Shear, 100)])
def test_what_is_filled_in_is_not_what_is_glued(test: type[BulkTest], glued: int) -> None:
    made = test(diameter="10 mm")
    [filling] = [one for one in apparatus_of(made) if one.name == "particles"]

    assert made.number_of_glued == glued
    assert filling.value.startswith(f"{made.number_of_particles - glued} ")


def test_what_is_stiff_enough_is_stiffer_than_what_is_too_soft() -> None:
    material = {"particle.youngs_modulus": 1e7, "particle.density": 2500.0}
    checked = CheckedTest(Drum(diameter="10 mm"), material, material, {"dynamic_angle": 35.0})
    [found] = soft_drum(checked)

    assert messages.SOFT_DRUM.is_in(found.text, enough="11")
