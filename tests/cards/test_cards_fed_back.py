"""A card in place of grainfit's own contact law: the same heap, to the last digit.

The deck of a small heap is run twice: as grainfit writes it, and with the lines that the card tells
its reader to write, whose numbers come from the card. All else of the deck is the same.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pytest

import needs
from grainfit.bulk_tests.heap import Heap
from grainfit.cards import MaterialCard, render
from grainfit.materials.sizes import ParticleSizes
from grainfit.scenes.run_output import RunOutput
from grainfit.solvers.base import Workspace
from grainfit.solvers.registry import DEM_PROGRAMS

SIZES = ParticleSizes((0.008, 0.010), (0.4, 0.6))
#: A small heap; its plate is of the wall, as a card knows no plate.
HEAP = Heap(
    SIZES,
    cylinder_radius=0.035,
    strike_off_height=0.06,
    bulk_density_top=0.05,
    plate_radius=0.12,
    time_step_fraction=0.1,
)
SEED = 3
#: Walls that hold a heap, with values of their own.
ON_WALL = {"sliding_friction": 0.45, "rolling_friction": 0.3, "restitution": 0.7}
BETWEEN = {"sliding_friction": 0.4, "rolling_damping": 0.0}


def with_lammps_card(deck: str) -> str:
    """Return a deck that takes contacts, density and time step from the card."""
    names = r"(?: &\n +)?(hertz.*?|jkr.*?|dmt.*?)"
    deck, pairs = re.subn(
        rf"pair_coeff +(\d) (\d){names}(?=\ngroup|\npair_coeff)",
        r"pair_coeff \1 \2 ${particle_particle_contact_\1_\2}",
        deck,
        flags=re.DOTALL,
    )
    deck, walls = re.subn(
        rf"(fix +\w+?(\d) size\d wall/gran/region granular){names} (region \w+\n)",
        r"\1 ${particle_wall_contact_\2} \4",
        deck,
        flags=re.DOTALL,
    )
    assert (pairs, walls) == (3, 4)
    deck = replaced(deck, "pair_style ", "include card.inc\npair_style ")
    density = "set group all density ${particle_density}\ntimestep ${recommended_time_step}"
    return replaced(deck, r"timestep +\S+", density)


def with_liggghts_card(deck: str) -> str:
    """Return a deck that takes properties, model, density and time step from the card."""
    deck, properties = re.subn(
        r"fix +\w+ all property/global(?:.*&\n)*.*\n", "", deck, flags=re.MULTILINE
    )
    assert properties == 6
    deck = replaced(deck, r"(soft|hard)_particles .*\n(soft|hard)_particles .*\n", "")
    deck = replaced(
        deck, "pair_style .*", "include card.inc\npair_style gran model ${contact_model}"
    )
    deck = replaced(deck, r"(wall/gran model) .* &", r"\1 ${contact_model} &")
    density = "set group all density ${particle_density}\ntimestep ${recommended_time_step}"
    return replaced(deck, r"timestep +\S+", density)


def with_yade_card(deck: str) -> str:
    """Return a script that takes materials, functors, contacts with walls and time step from it."""
    names = "contact_law, contact_physics, particle, wall, set_contacts_on_walls"
    begin, rest = deck.split("def material(label")
    rest = rest.partition("contact_law = ")[2].partition("\n")[2]
    card = f"sys.path.insert(0, '.')\nfrom card import {names}, RECOMMENDED_TIME_STEP\n"
    own = 'O.dt = RECOMMENDED_TIME_STEP\nWALL_MATERIALS = {"wall": wall}\n'
    deck = replaced(begin, "O.dt = .*", "") + card + own + rest
    deck = replaced(deck, r"# krot and eta(?:.*\n)*?    LAST_CHECK = O.iter\n", "")
    return replaced(deck, r"        set_rolling_friction\(\)", "        set_contacts_on_walls()")


def replaced(text: str, pattern: str, by: str) -> str:
    """Return a text in which a pattern that it has once is replaced."""
    found, count = re.subn(pattern, by, text)
    assert count == 1, pattern
    return found


@dataclass(frozen=True)
class Fed:
    """How a deck of a solver is fed with a card: name of the card's file, and the changed deck."""

    card: str
    deck: Callable[[str], str]


FED = {
    "lammps": Fed("card.inc", with_lammps_card),
    "liggghts": Fed("card.inc", with_liggghts_card),
    "yade": Fed("card.py", with_yade_card),
}


@pytest.fixture(scope="session")
def heap_card(card: MaterialCard) -> MaterialCard:
    """Card of a mixture with walls of its own, in a heap test."""

    def value(name: str, now: float) -> float:
        section, _, key = name.rpartition(".")
        changes: Mapping[str, float] = ON_WALL if section == "particle_wall" else {}
        return (BETWEEN | dict(changes)).get(key, now) if section.startswith("particle_") else now

    parameters = tuple(replace(p, value=value(p.name, p.value)) for p in card.parameters)
    values = {parameter.name: parameter.value for parameter in parameters}
    step = HEAP.time_step(values)
    return replace(
        card,
        parameters=parameters,
        sizes=SIZES,
        recommended_time_step=step,
        rayleigh_time_step=step / HEAP.time_step_fraction,
    )


def heap(
    name: str, card: MaterialCard, folder: Path, change: Callable[[str], str] = str
) -> RunOutput:
    """Run the deck of the heap, which may be changed; return what it leaves."""
    folder.mkdir()
    solver_type = DEM_PROGRAMS[name]
    solver = solver_type(HEAP, card.values)
    scene = HEAP.scene(card.values, SEED)
    deck = solver_type.deck(scene, folder).write()
    deck.write_text(change(deck.read_text(encoding="utf-8")), encoding="utf-8")
    solver._simulate(deck, Workspace(folder, 600.0))
    struck = [stage.name for stage in scene.stages if stage.strike_off is not None]
    return RunOutput(folder, len(scene.particles.size_indices), struck)


@pytest.mark.slow
@pytest.mark.parametrize(
    "name",
    [
        "lammps",
        pytest.param("liggghts", marks=needs.LIGGGHTS),
        pytest.param("yade", marks=needs.YADE),
    ],
)
def test_a_solver_builds_the_same_heap_from_its_card(
    heap_card: MaterialCard, tmp_path: Path, name: str
) -> None:
    fed = FED[name]

    def feed(deck: str) -> str:
        text = render(heap_card, name)
        (tmp_path / "card" / fed.card).write_text(text, encoding="utf-8")
        return fed.deck(deck)

    own = heap(name, heap_card, tmp_path / "own")
    found = heap(name, heap_card, tmp_path / "card", feed)

    assert [stage.time for stage in found.stages] == [stage.time for stage in own.stages]
    snapshots = [p.name for p in (tmp_path / "own" / "snapshots").iterdir()]
    assert snapshots
    for snapshot in snapshots:
        texts = [(tmp_path / f / "snapshots" / snapshot).read_text() for f in ("own", "card")]
        assert texts[0] == texts[1], snapshot
    assert HEAP.measure(found) == HEAP.measure(own)
    assert np.isfinite(HEAP.measure(own)["angle_of_repose"].value)
