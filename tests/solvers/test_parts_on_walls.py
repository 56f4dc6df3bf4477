"""Parts of bulk tests on walls with names, in the programs themselves."""

from __future__ import annotations

import shutil
from collections.abc import Mapping
from pathlib import Path

import numpy as np
import pytest

import grainfit as gf
from grainfit.bulk_tests.heap import Heap
from grainfit.bulk_tests.natural_units import natural_run
from grainfit.errors import InputError
from grainfit.solvers.base import Workspace
from grainfit.solvers.dem import messages as dem_messages
from grainfit.solvers.dem.program import DeckSolver
from grainfit.solvers.registry import DEM_PROGRAMS

PARTICLES = {
    "particle.youngs_modulus": 1e6,
    "particle.poissons_ratio": 0.22,
    "particle.density": 2100.0,
    "particle_particle.sliding_friction": 0.2,
    "particle_particle.rolling_friction": 0.3,
    "particle_particle.restitution": 0.4,
    "particle_particle.rolling_damping": 0.0,
}
WALLS = {"cylinder": "steel", "plate": "acrylic"}


def wall(name: str, friction: float) -> dict[str, float]:
    """Return a wall whose sliding and rolling friction are the same."""
    dot = f".{name}." if name else "."
    contact = {"sliding_friction": friction, "rolling_friction": friction}
    contact |= {"restitution": 0.4, "rolling_damping": 0.0}
    body = {"youngs_modulus": 1e9, "poissons_ratio": 0.3, "density": 7000.0}
    return {f"particle_wall{dot}{key}": value for key, value in contact.items()} | {
        f"wall{dot}{key}": value for key, value in body.items()
    }


def heap(scale: float = 1.0) -> Heap:
    """Return a heap of 150 particles, at any size of them."""
    lengths = {
        "diameter": 0.01,
        "cylinder_radius": 0.03,
        "plate_radius": 0.1,
        "strike_off_height": 0.035,
        "bulk_density_bottom": 0.005,
        "bulk_density_top": 0.02,
        "lift_height": 0.07,
    }
    scaled = {name: scale * length for name, length in lengths.items()}
    speed = 0.2 * scale**0.5
    return Heap(particle_count=150, lift_speed=speed, time_step_fraction=0.15, **scaled)


def solver(
    program: str, steel: float, acrylic: float, walls: Mapping[str, str] = WALLS
) -> DeckSolver:
    material = {**PARTICLES, **wall("steel", steel), **wall("acrylic", acrylic)}
    return DEM_PROGRAMS[program](heap(), material, walls=walls)


@pytest.mark.parametrize("program", ["lammps", "liggghts"])
def test_the_heap_stays_on_a_rough_plate_and_slides_off_a_smooth_one(
    program: str, tmp_path: Path
) -> None:
    if program == "liggghts" and shutil.which("liggghts") is None:
        pytest.skip("LIGGGHTS is not installed: apt-get install liggghts")
    left = {}
    for plate, (steel, acrylic) in {"rough": (0.02, 0.8), "smooth": (0.8, 0.02)}.items():
        made = solver(program, steel, acrylic)
        (tmp_path / plate).mkdir()
        run = made.simulate(made.scene({}, 1), Workspace(tmp_path / plate, 300.0))
        run.require_complete(["fill", "lift", "heap"], "cylinder")
        left[plate] = run.snapshot("heap")

    assert len(left["rough"]) > 2 * len(left["smooth"]) > 0
    assert left["rough"].positions[:, 2].max() > 2 * left["smooth"].positions[:, 2].max()
    assert np.hypot(*left["smooth"].positions[:, :2].T).mean() > 0.04


def test_a_file_with_one_wall_makes_the_same_deck_as_with_a_name(tmp_path: Path) -> None:
    """The plate has the friction of the wall in both."""
    named = solver("lammps", 0.4, 0.8, dict.fromkeys(WALLS, "steel"))
    plain = DEM_PROGRAMS["lammps"](
        Heap(**{key.name: getattr(heap(), key.name) for key in Heap.option_keys()}, diameter=0.01),
        {**PARTICLES, **wall("", 0.4)},
    )
    texts = []
    for name, made in {"named": named, "plain": plain}.items():
        (tmp_path / name).mkdir()
        deck = made.deck(made.scene({}, 1), tmp_path / name).write()
        texts.append(deck.read_text(encoding="utf-8"))

    assert texts[0] == texts[1]


def test_every_program_gets_the_elasticity_and_friction_of_each_part(tmp_path: Path) -> None:
    values = solver("yade", 0.1, 0.7).walls
    assert values == WALLS
    texts = {}
    for program in DEM_PROGRAMS:
        made = solver(program, 0.111, 0.777)
        (tmp_path / program).mkdir()
        texts[program] = (
            made.deck(made.scene({}, 1), tmp_path / program).write().read_text(encoding="utf-8")
        )

    assert "1 particles, 2 steel, 3 acrylic" in texts["liggghts"]
    assert "0.2 0.111 0.777" in texts["liggghts"]
    rows = texts["lammps"].replace(" &\n", " ").splitlines()
    (cylinder,) = [row for row in rows if row.startswith("fix") and "region cylinder" in row]
    (plate,) = [row for row in rows if row.startswith("fix") and "region plate" in row]
    assert "0.111" in cylinder
    assert "0.777" in plate
    assert "tube('cylinder', 'steel'" in texts["yade"]
    assert "disc('plate', 'acrylic'" in texts["yade"]


def test_a_run_names_its_walls_and_nothing_of_others() -> None:
    material = {**PARTICLES, **wall("steel", 0.1), **wall("brass", 0.3)}
    run = DEM_PROGRAMS["lammps"](heap(), material, walls={"cylinder": "steel", "plate": "steel"})
    definition = run.definition({}, 1)

    assert definition.model["walls"] == {"cylinder": "steel", "plate": "steel"}
    assert not any("brass" in name for name in definition.parameters)
    assert run.depends_on(
        ["particle_wall.brass.restitution", "particle_wall.steel.restitution"]
    ) == ("particle_wall.steel.restitution",)


def test_runs_on_walls_with_names_hold_at_every_size() -> None:
    runs = []
    for scale in (1.0, 0.2):
        moduli = {"particle.youngs_modulus": scale * 1e6}
        walls = {**wall("steel", 0.1), **wall("acrylic", 0.7)}
        walls |= {f"wall.{name}.youngs_modulus": scale * 1e9 for name in ("steel", "acrylic")}
        made = DEM_PROGRAMS["lammps"](heap(scale), {**PARTICLES, **walls, **moduli}, walls=WALLS)
        runs.append(natural_run(made.definition({}, 1)))
        softer = {**PARTICLES, **walls, **moduli, "wall.acrylic.youngs_modulus": scale * 1e6}
        other = natural_run(
            DEM_PROGRAMS["lammps"](heap(scale), softer, walls=WALLS).definition({}, 1)
        )
        assert runs[-1] is not None
        assert other is not None
        assert not runs[-1].is_same(other)

    first, second = runs
    assert first is not None
    assert second is not None
    assert first.is_same(second)


@pytest.mark.parametrize(
    ("walls", "options", "key"),
    [
        ({"floor": "steel"}, {}, "walls.floor"),
        ({"plate": "steel"}, {"plate_sliding_friction": 0.3}, "plate_sliding_friction"),
        ({"plate": "brass", "cylinder": "brass"}, {}, "wall.brass.youngs_modulus"),
    ],
)
def test_impossible_walls_are_named(
    walls: dict[str, str], options: dict[str, float], key: str
) -> None:
    material = {**PARTICLES, **wall("", 0.1), **wall("steel", 0.4)}
    with pytest.raises(InputError) as caught:
        DEM_PROGRAMS["lammps"](
            Heap(diameter="10 mm", **options), material, walls=walls
        ).run_parameters({})

    assert key in {fault.key for fault in caught.value.faults}


def test_damping_on_a_wall_is_refused_by_a_program_without_it() -> None:
    material = {**PARTICLES, **wall("steel", 0.1), "particle_wall.steel.rolling_damping": 0.3}
    with pytest.raises(InputError, match=r"particle_wall\.steel\.rolling_damping: 0\.3"):
        DEM_PROGRAMS["yade"](heap(), material, walls=dict.fromkeys(WALLS, "steel"))


SCENE = """
import numpy as np
from grainfit.scenes import *

def scene(material, sizes, gravity, time_step):
    return Scene(
        title="a ball between two floors", material=material, sizes=sizes, gravity=gravity,
        particles=Column(np.array([[0.0, 0.0, 0.02]]), np.array([0]), 0.05),
        box=Box((-0.1, -0.1, -0.01), (0.1, 0.1, 0.1)),
        walls={"floor": Wall(Plane("z", 0.0)), "side": Wall(Plane("x", -0.05))},
        stages=(Stage("fall", Elapsed(0.01)),),
        time_step=time_step, quiet_speed=0.01, check_interval=0.01,
    )

def measure(run):
    return {"height": 0.0}
"""


def own_scene(folder: Path, walls: Mapping[str, str], *plain: float) -> DeckSolver:
    (folder / "own.py").write_text(SCENE, encoding="utf-8")
    test = gf.tests.OwnScene(
        diameter="10 mm",
        scene=str(folder / "own.py:scene"),
        measure=str(folder / "own.py:measure"),
    )
    material = {**PARTICLES, **wall("steel", 0.1)}
    for friction in plain:
        material |= wall("", friction)
    return DEM_PROGRAMS["lammps"](test, material, walls=walls)


def test_walls_of_a_scene_of_the_user_are_its_parts(tmp_path: Path) -> None:
    made = own_scene(tmp_path, {"side": "steel"}, 0.6).scene({}, 1)

    friction = {
        name: made.material_on(wall.surface)["particle_wall.sliding_friction"]
        for name, wall in made.walls.items()
    }
    assert friction == {"floor": 0.6, "side": 0.1}


def test_a_wall_of_the_users_scene_that_is_made_of_nothing_is_named(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=dem_messages.WALL_OF_NOTHING.pattern):
        own_scene(tmp_path, {"side": "steel"}).scene({}, 1)
    with pytest.raises(InputError, match=dem_messages.NO_PART.pattern):
        own_scene(tmp_path, {"sides": "steel"}, 0.6).estimate_cost({})
