"""Options of bulk tests in Python: quantities with units, and faults that name key and value."""

from __future__ import annotations

import json

import numpy as np
import pytest

import grainfit as gf
from grainfit.bulk_tests.heap import Heap
from grainfit.bulk_tests.outline import concepts
from grainfit.bulk_tests.shared.part_friction import AS_PARTICLES
from grainfit.errors import InputError
from grainfit.materials.sizes import ParticleSizes


def test_the_test_is_found_under_its_public_name() -> None:
    assert gf.tests.Heap is Heap
    assert "Heap" in dir(gf.tests)
    with pytest.raises(AttributeError, match="Brazilian"):
        gf.tests.Brazilian  # noqa: B018


def test_quantities_and_numbers_are_the_same_test() -> None:
    sizes = ParticleSizes((0.010,))
    written = Heap(diameter="10 mm", lift_speed="5 cm/s", rim_height="1 cm")
    assert written == Heap(sizes, lift_speed=0.05, rim_height=0.01)
    assert written == Heap(sizes, lift_speed=np.float64(0.05), rim_height=np.float64(0.01))
    assert isinstance(written.lift_speed, float)


def test_a_plain_number_stays_as_it_was_given() -> None:
    # Up to version 0.1.0, 0 and 0.0 were written differently into the identity of a run.
    assert '"rim_height": 0,' in json.dumps(Heap(diameter=0.010, rim_height=0).definition())


@pytest.mark.parametrize(
    ("test", "part"), [(Heap, "plate"), (gf.tests.Funnel, "plate"), (gf.tests.DrawDown, "floor")]
)
def test_a_part_may_have_both_frictions_of_the_particles(test: type[Heap], part: str) -> None:
    options = {f"{part}_{kind}_friction": AS_PARTICLES for kind in ("sliding", "rolling")}
    assert concepts(test(diameter="10 mm", **options)) == concepts(test(diameter="10 mm"))


def test_a_distribution_of_diameters() -> None:
    classes = [
        {"value": "12 mm", "mass_fraction": 0.5},
        {"value": "8 mm", "mass_fraction": "50 %"},
    ]
    assert Heap(diameter=classes).sizes == ParticleSizes((0.012, 0.008), (0.5, 0.5))


@pytest.mark.parametrize(
    ("given", "said"),
    [
        ({}, r'diameter: is missing. Give diameter="10 mm"'),
        ({"sizes": ParticleSizes((0.01,)), "diameter": 0.01}, "diameter: is given beside sizes"),
        ({"sizes": "10 mm"}, "sizes: is '10 mm'"),
        ({"diameter": "10"}, "diameter: '10' has no unit"),
        ({"diameter": "10 mm", "lift_speed": "3 mm"}, "lift_speed: '3 mm' has the unit mm"),
        ({"diameter": "10 mm", "views": 400}, "views: is 400. It must be from 1 to 360"),
        (
            {"diameter": "10 mm", "time_step_fraction": 1.5},
            "time_step_fraction: is 1.5. It must be above 0, and at most 1.",
        ),
    ],
)
def test_what_cannot_be_is_named(given: dict[str, object], said: str) -> None:
    with pytest.raises(InputError, match=said):
        Heap(**given)  # type: ignore[arg-type]


def test_an_option_that_does_not_exist_is_a_type_error() -> None:
    with pytest.raises(TypeError, match="lift_sped"):
        Heap(diameter="10 mm", lift_sped=0.05)  # type: ignore[call-arg]


WIDE = ParticleSizes((0.003, 0.012), (0.9, 0.1))


def test_the_default_cylinder_has_room_for_the_largest_particles() -> None:
    heap = Heap(WIDE).setup
    # As of particles of 4 mm, of which the cylinder is twelve wide.
    usual = Heap(diameter="4 mm").setup
    assert heap.cylinder_radius == pytest.approx(0.024)
    for length in ("plate_radius", "strike_off_height", "bulk_density_top", "lift_height"):
        assert getattr(heap, length) == pytest.approx(getattr(usual, length))

    largest = 0.0081201497
    for smallest in np.linspace(0.1, 0.3, 50):
        sizes = ParticleSizes((smallest * largest, largest), (0.95, 0.05))
        assert 2 * Heap(sizes).setup.cylinder_radius >= 4 * largest


def test_defaults_beside_a_cylinder_that_is_given_follow_the_sauter_diameter() -> None:
    d = WIDE.sauter_diameter
    assert 6 * d < 0.024
    heap = Heap(WIDE, cylinder_radius=0.024).setup
    assert (heap.plate_radius, heap.strike_off_height) == pytest.approx((16 * d, 10.5 * d))
    nearly_equal = Heap(
        diameter=[
            {"value": "12 mm", "mass_fraction": 0.5},
            {"value": "8 mm", "mass_fraction": 0.5},
        ]
    )
    assert nearly_equal.setup.cylinder_radius == 6 * nearly_equal.sizes.sauter_diameter
