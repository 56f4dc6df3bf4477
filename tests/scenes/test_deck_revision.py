"""Packing and decks of scenes, letter by letter: others would be other runs of one identity."""

from __future__ import annotations

import hashlib
from collections.abc import Iterable
from pathlib import Path

import pytest

from grainfit.bulk_tests.base import BulkTest
from grainfit.bulk_tests.heap import Heap
from grainfit.bulk_tests.outline import concepts
from grainfit.bulk_tests.registry import BUILT_IN, bulk_tests
from grainfit.materials.particle_shape import CLUMPS_REVISION, ParticleShape
from grainfit.materials.sizes import ParticleSizes
from grainfit.scenes.packing import Round, random_column
from grainfit.scenes.scene import SCENES_REVISION, time_step
from grainfit.solvers.registry import DEM_PROGRAMS
from grainfit.testing.decks import write_deck
from grainfit.testing.materials import GLASS_BEADS, ROUGH_PLATE

BEADS, MIXTURE = ParticleSizes((0.010,)), ParticleSizes((0.012, 0.008), (0.5, 0.5))
SOFT_WALL = {**GLASS_BEADS, "wall.youngs_modulus": 2e5, "particle_wall.sliding_friction": 0.6}
#: Revision, and decks of it: beads, and a mixture on a plate with a rim.
DECKS = {"lammps": (1, "41ba9408b19bb4a1"), "liggghts": (1, "f447515809efd14c")}
#: Every test with its defaults, and one with another geometry: its own revision, that of scenes,
#: and the decks of beads and of a mixture in all solvers that have its shapes.
DEFAULT_DECKS: dict[tuple[str, str], tuple[int, int, str]] = {
    ("heap", ""): (2, 1, "a05dc8870c3b49f7"),
    ("packing", ""): (1, 1, "693b512048690ff6"),
    ("compression", ""): (2, 1, "8264f66227d16ddb"),
    ("discharge", "slot"): (1, 1, "b3c178d31a18c6e6"),
    ("discharge", "round"): (1, 1, "1e4521dd4b909841"),
    ("draw_down", ""): (1, 1, "d7bcacd59223199c"),
    ("drum", ""): (1, 1, "f8c26efa526d5f0c"),
    ("funnel", ""): (1, 1, "97afec6bf8d9d20a"),
    ("hopper", "round"): (1, 1, "9c6f9af9f094671c"),
    ("hopper", "slot"): (1, 1, "0072ad8aee35b12b"),
    ("shear", ""): (2, 1, "c4332ec0561127e1"),
    ("shear_cell", ""): (2, 1, "163606185230cb8d"),
    ("tapped", ""): (1, 1, "271d275fba2c76ca"),
    ("triaxial", ""): (1, 1, "91412400658800fd"),
}
#: A discharge whose flow goes on until all is at rest, with both orifices: the only one before.
DISCHARGES_TO_REST = {"slot": "3e20fd7fb0dad1c4", "round": "4f9adc92f3ea3306"}
#: Revision of clumps, and of some of them time step, s, outer and smallest radius, and moments of
#: inertia over their mass, at a diameter of 1.
CLUMPS: dict[tuple[str, float], tuple[int, str]] = {
    ("grain", 1.1): (2, "9.176e-05 0.5333 0.4408 0.09384 0.1037 0.1037"),
    ("two_spheres", 1.5): (2, "0.000207 0.63 0.42 0.07496 0.1301 0.1301"),
}
#: Decks of YADE: a mixture in every test that it has, with its defaults.
YADE_DECKS = {
    "compression": (1, "f2125e389da77d3d"),
    "discharge": (1, "18d2c310c4ea4750"),
    "draw_down": (1, "a58c078724fc0f18"),
    "drum": (1, "41aeb0bff972f2da"),
    "funnel": (1, "7e14927997cfa7d2"),
    "heap": (1, "7590e801e9ff0995"),
    "hopper": (1, "59388f72a98ec492"),
    "packing": (1, "879ba9220532dbe3"),
    "shear": (1, "f0e52e2341489d15"),
    "shear_cell": (1, "77cf5b54c8935b2b"),
    "tapped": (1, "0568a69bd9e3199f"),
    "triaxial": (1, "d0caee3037a81c18"),
}
#: Revision, height of the column and place of the first particle, m.
COLUMN = (1, 0.0684905716, (-0.0441319384, -0.0035668218, 0.0367854215))
CHANGED = "have changed: raise SCENES_REVISION in scenes/scene.py, and pin the new values here"
CHANGED_TEST = (
    "have changed: raise the revision of the test, or SCENES_REVISION in scenes/scene.py when all "
    "tests change, and pin the new values here"
)


@pytest.mark.parametrize("solver", DECKS)
def test_decks_are_those_of_their_revision(tmp_path: Path, solver: str) -> None:
    digest = hashlib.sha256()
    for test, material in (
        (Heap(diameter="10 mm", **ROUGH_PLATE), GLASS_BEADS),
        (
            Heap(MIXTURE, rim_height="6 mm", **{**ROUGH_PLATE, "plate_rolling_friction": 0.1}),
            SOFT_WALL,
        ),
    ):
        digest.update(write_deck(test, tmp_path, solver, material, seed=1).read_bytes())

    assert (SCENES_REVISION, digest.hexdigest()[:16]) == DECKS[solver], f"decks {CHANGED}"


def hashed_decks(tests: Iterable[BulkTest], folder: Path) -> str:
    """Return the hash of the decks of tests, of LAMMPS and LIGGGHTS where they have the shapes."""
    digest = hashlib.sha256()
    for test in tests:
        for solver in ("lammps", "liggghts"):
            if not concepts(test) & set(DEM_PROGRAMS[solver].missing):
                deck = write_deck(test, folder / solver, solver, GLASS_BEADS, seed=1)
                digest.update(deck.read_bytes())
    return digest.hexdigest()[:16]


@pytest.mark.parametrize(("name", "orifice"), DEFAULT_DECKS)
def test_default_decks_are_those_of_their_revision(tmp_path: Path, name: str, orifice: str) -> None:
    kind = bulk_tests()[name]
    options = {"orifice": orifice} if orifice else {}
    tests = [kind(sizes, **options) for sizes in (BEADS, MIXTURE)]
    found = (kind.revision, SCENES_REVISION, hashed_decks(tests, tmp_path))

    assert found == DEFAULT_DECKS[name, orifice], f"decks {CHANGED_TEST}"


@pytest.mark.parametrize(("orifice", "known"), DISCHARGES_TO_REST.items())
def test_a_discharge_to_rest_is_the_run_of_before(tmp_path: Path, orifice: str, known: str) -> None:
    kind = bulk_tests()["discharge"]
    tests = [kind(sizes, orifice=orifice, flow_until="rest") for sizes in (BEADS, MIXTURE)]

    assert hashed_decks(tests, tmp_path) == known
    assert "flow_until" not in tests[0].definition()
    again = kind.from_definition(tests[0].definition())
    assert again.definition() == tests[0].definition()


@pytest.mark.parametrize(("family", "aspect_ratio"), CLUMPS)
def test_clumps_are_those_of_their_revision(family: str, aspect_ratio: float) -> None:
    sizes = ParticleSizes((0.010,), shape=ParticleShape(family, aspect_ratio=aspect_ratio))
    clump = sizes.clump
    assert clump is not None
    step = time_step(sizes, GLASS_BEADS, 0.12)
    numbers = (step, clump.outer_radius, clump.smallest_radius, *clump.moments)

    found = (CLUMPS_REVISION, " ".join(f"{number:.4g}" for number in numbers))
    assert found == CLUMPS[family, aspect_ratio], (
        "clumps have changed: raise CLUMPS_REVISION in materials/particle_shape.py, and pin the "
        "new values here"
    )


def with_yade() -> list[str]:
    """Return the tests that YADE has."""
    tests = (kind(MIXTURE) for kind in BUILT_IN.values())
    missing = set(DEM_PROGRAMS["yade"].missing)
    return [test.type for test in tests if not concepts(test) & missing]


@pytest.mark.parametrize("name", with_yade())
def test_yade_decks_are_those_of_their_revision(tmp_path: Path, name: str) -> None:
    digest = hashlib.sha256()
    test = BUILT_IN[name](MIXTURE, **(ROUGH_PLATE if name == "heap" else {}))
    for path in sorted(write_deck(test, tmp_path, "yade", GLASS_BEADS, seed=1).parent.glob("*.*")):
        digest.update(path.read_bytes())

    assert (SCENES_REVISION, digest.hexdigest()[:16]) == YADE_DECKS[name], f"decks {CHANGED}"


def test_decks_of_every_built_in_test_are_pinned() -> None:
    assert {name for name, _ in DEFAULT_DECKS} == set(BUILT_IN)


def test_packing_is_that_of_its_revision() -> None:
    column = random_column(MIXTURE, 300, Round(0.05), seed=1)
    revision, height, place = COLUMN

    assert revision == SCENES_REVISION, f"the packing may {CHANGED}"
    found = (column.height, *column.positions[0])
    assert found == pytest.approx((height, *place), abs=1e-9), f"packings {CHANGED}"
