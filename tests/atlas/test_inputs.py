"""Materials and apparatus as dimensionless inputs of the atlas, and back."""

from __future__ import annotations

from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

import grainfit as gf
from benchmarks.atlas_rows import point
from grainfit.atlas.reading import NotInAtlasError, Reading
from grainfit.atlas.strata import strata
from grainfit.bulk_tests.base import BulkTest
from grainfit.bulk_tests.varied_options import Range
from grainfit.materials.particle_shape import ASPECT_RATIO, ParticleShape
from grainfit.materials.sizes import ParticleSizes
from grainfit.testing.materials import ROUGH_PLATE, ROUGH_SPHERES

MATERIAL = {
    **ROUGH_SPHERES,
    "particle_particle.rolling_damping": 0.0,
    "particle_wall.rolling_damping": 0.0,
}
HEAP = gf.tests.Heap(diameter="10 mm", **ROUGH_PLATE)


COHESION = {"particle_particle__surface_energy": 0.5, "particle_wall__surface_energy": 0.0}
CLUMPS, PELLETS = (
    ParticleSizes((0.01,), shape=ParticleShape(family)) for family in ("two_spheres", "cylinder")
)


def _material(**changed: float) -> dict[str, float]:
    return {**MATERIAL, **{name.replace("__", "."): one for name, one in changed.items()}}


def _reading(test: BulkTest, **changed: float) -> Reading:
    return Reading(gf.solvers.Lammps(test, _material(**changed)), {})


@pytest.mark.parametrize("name", strata())
def test_the_point_of_a_row_is_read_back_from_its_test_and_material(name: str) -> None:
    stratum = strata()[name]
    for number in range(6):
        row = point(stratum, number)
        test, material = stratum.simulated(row)

        found = Reading(gf.solvers.Lammps(test, material), {}).inputs(material)

        assert found == pytest.approx(row, rel=1e-6)


@pytest.mark.parametrize("name", strata())
def test_every_input_of_a_row_changes_its_test_or_its_material(name: str) -> None:
    stratum = strata()[name]
    row = point(stratum, 3)
    before = stratum.simulated(row)
    for changed, span in stratum.ranges.items():
        other = stratum.simulated({**row, changed: span.at(0.4)})
        assert (other.test, other.material) != (before.test, before.material), changed


@pytest.mark.parametrize(
    ("test", "name"),
    [
        (HEAP, "heap"),
        (gf.tests.Heap(diameter="10 mm", base="disc", **ROUGH_PLATE), "heap-disc"),
        (gf.tests.Drum(diameter="10 mm", end_caps=True, lining=False), "drum-caps"),
        (gf.tests.Hopper(diameter="10 mm", half_angle="70 deg"), "hopper"),
        (gf.tests.Hopper(diameter="10 mm", half_angle="90 deg"), "hopper-flat"),
        (gf.tests.Tapped(diameter="10 mm"), "tapped"),
        (gf.tests.Tapped(diameter="10 mm", taps=50), "tapped-many_taps"),
    ],
)
def test_rows_are_those_of_the_apparatus_that_is_most_like_it(test: BulkTest, name: str) -> None:
    assert _reading(test).stratum.name == name


def test_the_speed_of_a_drum_is_that_of_its_froude_number() -> None:
    small, large = (
        _reading(gf.tests.Drum(diameter="10 mm", drum_radius=one)).inputs(_material())
        for one in ("80 mm", "800 mm")
    )

    assert large["rotational_speed"] == pytest.approx(small["rotational_speed"])


def test_what_differs_is_named_beside_the_most_similar_apparatus() -> None:
    smooth_disc = gf.tests.Heap(diameter="10 mm", base="disc")

    with pytest.raises(NotInAtlasError, match="plate_rolling_friction"):
        _reading(smooth_disc)


def test_a_wide_hopper_of_fine_particles_is_read_without_that_of_the_rows() -> None:
    fine = gf.tests.Hopper(
        diameter="0.3 mm", half_angle="90 deg", width="47.5 mm", fill_height="3 mm"
    )

    assert _reading(fine).inputs(_material())["size"] > 5


def test_stresses_of_a_yield_locus_are_told_over_the_load() -> None:
    material = _material(particle__youngs_modulus=1e8)
    light, heavy = (
        Reading(
            gf.solvers.Lammps(gf.tests.ShearCell(diameter="10 mm", normal_stress=one), material), {}
        )
        for one in ("500 Pa", "5 kPa")
    )

    assert heavy.unit("cohesion", {}) == pytest.approx(10 * light.unit("cohesion", {}))
    assert heavy.unit("bulk_density", {}) == pytest.approx(light.unit("bulk_density", {}))


def test_a_row_tells_about_particles_of_any_size_and_density() -> None:
    small = {"particle__youngs_modulus": 3.6e5 * 0.2 * 1000 / 2100, "particle__density": 1000.0}

    one = _reading(HEAP).inputs(_material())
    other = _reading(gf.tests.Heap(diameter="2 mm", **ROUGH_PLATE), **small)

    assert other.inputs(_material(**small)) == pytest.approx(one)


def test_the_apparatus_of_the_laboratory_is_an_input() -> None:
    usual = _reading(HEAP).inputs(_material())
    faster = _reading(replace(HEAP, lift_speed=0.1)).inputs(_material())

    assert usual["lift_speed"] == pytest.approx(1.0)
    assert faster == pytest.approx({**usual, "lift_speed": 2.0})


@pytest.mark.parametrize(
    ("test", "changed", "why"),
    [
        (gf.tests.Heap(diameter="10 mm"), {}, "plate_rolling_friction"),
        (gf.tests.Triaxial(diameter="10 mm"), {"particle__youngs_modulus": 1e8}, "no rows"),
        (HEAP, {"particle_particle__rolling_damping": 0.3}, "rolling_damping is 0.3"),
        (gf.tests.Drum(diameter="10 mm"), COHESION, "has dry spheres, and not spheres with jkr"),
        (gf.tests.Packing(CLUMPS), COHESION, "not two_spheres with jkr"),
        (gf.tests.Packing(PELLETS), {}, "clumps of two spheres, and not cylinder"),
        (gf.tests.Drum(diameter="10 mm", end_caps=True), {}, "end_caps"),
    ],
)
def test_what_the_atlas_does_not_have_is_named(
    test: BulkTest, changed: dict[str, float], why: str
) -> None:
    with pytest.raises(NotInAtlasError, match=why):
        _reading(test, **changed)


def test_a_material_outside_of_the_rows_is_named_with_their_range() -> None:
    outside = {"particle_particle.sliding_friction": 0.001}

    with pytest.raises(NotInAtlasError, match=r"sliding_friction is 0.001, .* 0.05 to 1.5"):
        _reading(HEAP).require_inside(outside)


def test_clumps_may_be_as_round_as_spheres_and_no_longer_than_those_of_the_rows() -> None:
    reading = Reading(gf.solvers.Lammps(gf.tests.Packing(CLUMPS), MATERIAL), {ASPECT_RATIO: 1.5})
    reading.require_inside({ASPECT_RATIO: 1.0})
    reading.require_inside({ASPECT_RATIO: 2.0})
    with pytest.raises(NotInAtlasError, match=r"aspect_ratio is 2.2, .* 1 to 2"):
        reading.require_inside({ASPECT_RATIO: 2.2})


def test_stiffer_particles_than_those_of_the_rows_follow_the_trend() -> None:
    _reading(HEAP).require_inside({"particle.youngs_modulus": 1e9})
    with pytest.raises(NotInAtlasError, match="stiffness"):
        _reading(HEAP).require_inside({"particle.youngs_modulus": 1e4})


def test_moduli_of_a_compression_follow_their_trend_for_as_long_as_the_rows_are_wide() -> None:
    compression = gf.tests.Compression(diameter="10 mm", stress="20 kPa")
    reading = _reading(compression, particle__youngs_modulus=2e8)
    reading.require_inside({"particle.youngs_modulus": 1.8e9})
    with pytest.raises(NotInAtlasError, match=r"stiffness .* is 2·10⁵, .* 1000 to 1·10⁵"):
        reading.require_inside({"particle.youngs_modulus": 4e9})


def test_a_smaller_apparatus_follows_the_trend_for_as_long_as_the_rows_are_wide() -> None:
    usual = gf.tests.Heap(diameter="10 mm", **ROUGH_PLATE)
    tiny, small = (replace(usual, **usual.at_size(size)) for size in (0.4, 0.55))
    _reading(small).require_inside({"particle.density": 2100.0})
    with pytest.raises(NotInAtlasError, match=r"size .* is 0.4, .* 0.479 to 1.3"):
        _reading(tiny).require_inside({"particle.density": 2100.0})


def test_a_mass_that_is_filled_in_is_the_height_of_its_bed() -> None:
    by_height, by_mass = (gf.tests.Hopper(diameter="10 mm", fill_mass=one) for one in (None, 2.0))
    height = by_mass.setup.height_of(MATERIAL["particle.density"])

    found = _reading(by_mass).inputs(MATERIAL)["fill_height"]

    assert found == pytest.approx(height / by_height.setup.usual_height)


def test_a_speed_of_a_drum_beyond_those_of_the_rows_is_refused() -> None:
    usual = gf.tests.Drum(diameter="10 mm")
    faster = replace(usual, rotational_speed=4 * usual.setup.rotational_speed)

    with pytest.raises(NotInAtlasError, match="rotational_speed is 4"):
        _reading(faster).require_inside({"particle.density": 2100.0})


@pytest.mark.parametrize("name", strata())
def test_declared_options_are_those_of_the_test(name: str) -> None:
    stratum = strata()[name]
    varied = stratum.varied
    named = {varied.size_option, *varied.factors, *varied.values, *varied.loads, *varied.same}

    options = {key.name for key in stratum.kind.option_keys()}
    assert named | {*varied.indifferent, *varied.left, *varied.wider} <= options


@given(
    st.floats(0.01, 1.0),
    st.floats(1.5, 100.0),
    st.sampled_from([-1.0, -2 / 3, 0.0, 0.3, 1.0]),
    st.floats(0.0, 1.0),
)
def test_a_range_gives_back_its_values(low: float, factor: float, power: float, at: float) -> None:
    span = Range(low, low * factor, power)

    assert float(span.share(span.at(at))) == pytest.approx(at, abs=1e-6)


def test_a_floor_without_a_friction_of_its_own_has_that_of_the_walls() -> None:
    walls = {"particle_wall__sliding_friction": 0.35, "particle_wall__rolling_friction": 0.15}
    material = _material(**walls)
    plain = gf.tests.DrawDown(diameter="10 mm")
    rough = replace(plain, floor_sliding_friction=0.6, floor_rolling_friction="particle_particle")

    own = _reading(plain, **walls).inputs(material)
    given = _reading(rough, **walls).inputs(material)

    assert (own["floor_sliding_friction"], own["floor_rolling_friction"]) == (0.35, 0.15)
    rolling = material["particle_particle.rolling_friction"]
    assert (given["floor_sliding_friction"], given["floor_rolling_friction"]) == (0.6, rolling)
