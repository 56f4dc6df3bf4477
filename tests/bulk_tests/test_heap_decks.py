"""The heap decks, letter by letter: a changed deck would be another run of the same identity."""

import hashlib

import pytest

from grainfit.bulk_tests.heap import Heap
from grainfit.materials.sizes import ParticleSizes
from grainfit.testing.materials import GLASS_BEADS

ONE = ParticleSizes((0.010,))
TWO = ParticleSizes((0.008, 0.010), (0.3, 0.7))
SOFT_WALL = {
    **GLASS_BEADS,
    "wall.youngs_modulus": 2.0e5,
    "wall.poissons_ratio": 0.40,
    "particle_wall.restitution": 0.55,
}
PLATE = {"plate_sliding_friction": 0.123, "plate_rolling_friction": 0.05, "gravity": 1.62}
#: Rendered before contact models wrote the coefficients. A deck that is changed on
#: purpose is another revision of the test.
DECKS = {
    "lammps, one size": "bfa51b7cbe8f0685",
    "lammps, two sizes": "e5e53c6add6db629",
    "lammps, one size, rim": "47c7675c3197c840",
    "lammps, two sizes, rim, plate": "a433d419cf111012",
    "liggghts, one size": "ae70c81dbe0750a2",
    "liggghts, two sizes": "d2f46036315f338d",
    "liggghts, one size, rim": "86e1cf3a8b051663",
    "liggghts, two sizes, rim, plate": "88348bc3d220d586",
}


@pytest.mark.parametrize("solver", ["lammps", "liggghts"])
@pytest.mark.parametrize(
    ("name", "sizes", "material", "options"),
    [
        ("one size", ONE, GLASS_BEADS, {}),
        ("two sizes", TWO, GLASS_BEADS, {}),
        ("one size, rim", ONE, SOFT_WALL, {"rim_height": 0.006}),
        ("two sizes, rim, plate", TWO, SOFT_WALL, {"rim_height": 0.006, **PLATE}),
    ],
)
def test_decks_are_unchanged(solver, name, sizes, material, options, tmp_path):
    deck = Heap(sizes, **options).write_deck(tmp_path, solver, material, seed=3)
    assert hashlib.sha256(deck.read_bytes()).hexdigest()[:16] == DECKS[f"{solver}, {name}"]
