from __future__ import annotations

import math

import numpy as np
import pytest
from synthetic_heaps import DIAMETER, packing, particles_of

from grainfit.errors import InputError, NotMeasurableError
from grainfit.measurement import messages
from grainfit.measurement.bulk_density import bulk_density, bulk_density_in_box
from grainfit.measurement.particles import Particles

RADIUS = 6 * DIAMETER


def lattice(layers: int = 25, radius: float = 6.0, spacing: float = 0.8) -> Particles:
    """Two sizes of spheres in alternating rows; every horizontal layer is like any other."""
    n = math.ceil(radius)
    points = np.mgrid[-n : n + 1, -n : n + 1, 0:layers].reshape(3, -1).T + 0.0
    points[:, 2] += 0.5
    points = points[np.hypot(points[:, 0], points[:, 1]) < radius]
    radii = np.where(points[:, 0] % 2 == 0, 0.5, 0.3)
    return particles_of(points * [1, 1, spacing], radii)


@pytest.mark.parametrize("offset", [0.0, 0.13, 0.5, 0.97])
def test_planes_may_cut_spheres_anywhere(offset: float) -> None:
    """Between planes ten lattice spacings apart lies the mass of exactly ten layers."""
    bed = lattice()
    bottom = (2 + offset) * 0.8 * DIAMETER
    height = 10 * 0.8 * DIAMETER
    measured = bulk_density(bed, RADIUS, bottom, bottom + height)
    mass = bed.masses.sum() / 25 * 10
    assert measured.value == pytest.approx(mass / (math.pi * RADIUS**2 * height), rel=1e-12)


def test_half_a_layer_of_spheres_is_half_their_mass() -> None:
    bed = lattice()
    middle = 0.5 * 0.8 * DIAMETER
    measured = bulk_density(bed, RADIUS, middle, middle + 0.8 * DIAMETER)
    layer = bed.masses.sum() / 25
    volume = math.pi * RADIUS**2 * 0.8 * DIAMETER
    assert measured.value == pytest.approx(layer / volume, rel=1e-12)


def test_particles_outside_the_cylinder_do_not_count() -> None:
    inner = bulk_density(lattice(), RADIUS, 2 * DIAMETER, 9 * DIAMETER)
    wide = lattice(radius=9.0)
    distance = np.hypot(wide.positions[:, 0], wide.positions[:, 1])
    assert (distance > RADIUS).any()
    assert bulk_density(wide, RADIUS, 2 * DIAMETER, 9 * DIAMETER).value == pytest.approx(
        inner.value
    )


def random_bed(seed: int) -> Particles:
    return particles_of(*packing(8.0, 12.0, seed, "polydisperse"))


def test_standard_error_is_about_the_scatter_between_beds() -> None:
    measured = [bulk_density(random_bed(s), RADIUS, 2 * DIAMETER, 10 * DIAMETER) for s in range(12)]
    scatter = np.std([m.value for m in measured], ddof=1)
    stated = math.sqrt(np.mean([m.standard_error**2 for m in measured]))
    assert np.mean([m.value for m in measured]) == pytest.approx(0.6 * 2500, rel=0.02)
    assert 0.5 < stated / scatter < 3.0


@pytest.mark.parametrize("power", [1, 2])
def test_denser_foot_of_a_bed_is_no_error(power: int) -> None:
    """A smooth trend over height, as the bed's own weight makes, leaves the error alone."""
    bed = random_bed(1)
    heights = bed.positions[:, 2] / 0.12
    pressed = Particles(bed.positions, bed.radii, bed.masses * (1.1 - 0.2 * heights**power))
    plain = bulk_density(bed, RADIUS, 0.02, 0.10).standard_error
    assert bulk_density(pressed, RADIUS, 0.02, 0.10).standard_error == pytest.approx(plain, rel=0.3)


def test_standard_error_of_independent_layers_is_that_of_their_mean() -> None:
    """Layers of equal spheres scatter in mass, each on its own, about a curve."""
    random = np.random.default_rng(1)
    places = lattice(layers=14, spacing=1.0).positions
    layer = (places[:, 2] / DIAMETER).astype(int)
    radii = np.full(len(places), DIAMETER / 2)
    measured = []
    for _ in range(200):
        masses = 1 + 0.02 * random.standard_normal(14) - 0.08 * np.linspace(0, 1, 14) ** 2
        bed = Particles(places, radii, masses[layer])
        measured.append(bulk_density(bed, RADIUS, 2 * DIAMETER, 12 * DIAMETER))
    scatter = np.std([m.value for m in measured])
    stated = math.sqrt(np.mean([m.standard_error**2 for m in measured]))
    assert stated == pytest.approx(scatter, rel=0.15)


def tilted(bed: Particles) -> Particles:
    surface = 0.09 + 0.5 * bed.positions[:, 0]
    return bed.select(bed.positions[:, 2] < surface)


@pytest.mark.parametrize(
    "bed",
    [
        lattice(layers=11),
        lattice(layers=3),
        tilted(random_bed(1)),
        random_bed(1).select(random_bed(1).positions[:, 2] > 0.2),
        lattice().select(lattice().positions[:, 0] > 0),
    ],
    ids=["ends below the top", "ends far below", "tilted", "no particle", "half the cylinder"],
)
def test_bed_that_does_not_fill_the_cylinder_is_not_measurable(bed: Particles) -> None:
    with pytest.raises(NotMeasurableError, match=r"^bulk density: "):
        bulk_density(bed, RADIUS, 0.01, 0.09)


def test_lone_particle_above_the_bed_does_not_make_it_reach() -> None:
    bed = lattice(layers=11)
    lone = np.array([[0.0, 0.0, 0.2]])
    more = Particles(
        np.concatenate([bed.positions, lone]),
        np.append(bed.radii, 0.005),
        np.append(bed.masses, 0.001),
    )
    with pytest.raises(NotMeasurableError, match=messages.NOT_FULL.pattern):
        bulk_density(more, RADIUS, 0.01, 0.10)


@pytest.mark.parametrize(("radius", "bottom", "top"), [(0.06, 0.05, 0.05), (0.0, 0.01, 0.05)])
def test_empty_volume_is_an_input_error(radius: float, bottom: float, top: float) -> None:
    with pytest.raises(InputError, match=messages.NO_VOLUME.pattern):
        bulk_density(lattice(), radius, bottom, top)


def box(width: int = 12, depth: int = 8) -> Particles:
    """A lattice of unit spheres between walls, periodic along y."""
    points = np.mgrid[0:width, 0:depth, 0:14].reshape(3, -1).T + 0.5
    points[:, 0] -= width / 2
    return particles_of(points, np.full(len(points), 0.5))


def test_box_has_the_bulk_density_of_its_lattice() -> None:
    measured = bulk_density_in_box(box(), 12 * DIAMETER, 8 * DIAMETER, 0.02, 0.11)

    assert measured.value == pytest.approx(2500 * math.pi / 6, rel=1e-9)
    assert measured.standard_error == pytest.approx(0, abs=1e-6)


@pytest.mark.parametrize("surface", [lambda x: 0.09 + 0.5 * x, lambda x: np.where(x < 0, 1.0, 0.0)])
def test_box_that_is_not_full_is_not_measurable(surface: object) -> None:
    assert callable(surface)
    bed = box(24, 12)
    bed = bed.select(bed.positions[:, 2] < surface(bed.positions[:, 0]))

    with pytest.raises(NotMeasurableError, match=messages.NOT_FULL.pattern):
        bulk_density_in_box(bed, 24 * DIAMETER, 12 * DIAMETER, 0.02, 0.11)


def test_box_without_a_volume_is_an_input_error() -> None:
    with pytest.raises(InputError, match=messages.NO_VOLUME.pattern):
        bulk_density_in_box(box(), 0.0, 8 * DIAMETER, 0.02, 0.11)
