"""A card in place of grainfit's own contact law: the same bed, to the last digit.

The deck of a small test is run twice: as grainfit writes it, and with the lines that the card tells
its reader to write, whose numbers come from the card. All else of the deck is the same.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import needs
from grainfit.bulk_tests.base import BulkTest
from grainfit.bulk_tests.heap import Heap
from grainfit.bulk_tests.packing import Packing
from grainfit.cards import CardParameter, MaterialCard, render
from grainfit.contact_models.registry import CONTACT_MODELS
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
PACKING = Packing(SIZES, cylinder_radius=0.03, fill_height=0.05, time_step_fraction=0.05)
SEED = 3
#: Walls that hold a heap, with values of their own.
VALUES = {
    "particle_particle.sliding_friction": 0.4,
    "particle_particle.rolling_damping": 0.0,
    "particle_wall.sliding_friction": 0.45,
    "particle_wall.rolling_friction": 0.3,
    "particle_wall.rolling_damping": 0.1,
    "particle_wall.restitution": 0.7,
}
GAMMA = {"particle_particle.surface_energy": 0.3, "particle_wall.surface_energy": 0.2}
OMEGA = {
    "particle_particle.cohesion_energy_density": 5e3,
    "particle_wall.cohesion_energy_density": 3e3,
}
#: Springs that are given between particles, and those of Young's modulus on walls.
SPRINGS = {
    "particle_particle.normal_stiffness": 900.0,
    "particle_particle.tangential_stiffness": 300.0,
}
#: Solvers that have them for one diameter only, and YADE without rolling friction.
ONE_SIZE = ("liggghts", "yade")
#: Test, contact models, and values of their own.
LAWS: dict[str, tuple[BulkTest, tuple[str, ...], dict[str, float]]] = {
    "epsd": (HEAP, (), {}),
    "epsd2": (PACKING, ("epsd2",), {}),
    "jkr": (PACKING, (), GAMMA),
    "dmt": (PACKING, ("dmt",), GAMMA),
    "sjkr": (PACKING, (), OMEGA),
    "sjkr2": (PACKING, ("sjkr2",), OMEGA),
    "linear": (PACKING, ("linear",), SPRINGS),
}


def with_lammps_card(deck: str) -> str:
    """Return a deck that takes contacts, density and time step from the card."""
    names = r"(?: &\n +)?(hertz.*?|hooke.*?|jkr.*?|dmt.*?)"
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
    assert (pairs, walls) == (3, deck.count("wall/gran"))
    deck = replaced(deck, "pair_style ", "include card.inc\npair_style ")
    density = "set group all density ${particle_density}\ntimestep ${recommended_time_step}"
    return replaced(deck, r"timestep +\S+", density)


def with_liggghts_card(deck: str) -> str:
    """Return a deck that takes properties, model, density and time step from the card."""
    deck = re.sub(r"fix +\w+ all property/global(?:.*&\n)*.*\n", "", deck)
    assert "property/global" not in deck
    deck = replaced(deck, r"(soft|hard)_particles .*\n(soft|hard)_particles .*\n", "")
    deck = replaced(
        deck, "pair_style .*", "include card.inc\npair_style gran model ${contact_model}"
    )
    deck = replaced(deck, r"(wall/gran model) .* &", r"\1 ${contact_model} &")
    density = "set group all density ${particle_density}\ntimestep ${recommended_time_step}"
    return replaced(deck, r"timestep +\S+", density)


def with_yade_card(deck: str) -> str:
    """Return a script that takes materials, functors, contacts with walls and time step from it."""
    rolls = "def set_rolling_friction()" in deck
    names = "contact_law, contact_physics, particle, wall"
    names += ", set_contacts_on_walls" if rolls else ""
    begin, rest = deck.split("def material(label")
    rest = rest.partition("contact_law = ")[2].partition("\n")[2]
    card = f"sys.path.insert(0, '.')\nfrom card import {names}, RECOMMENDED_TIME_STEP\n"
    own = 'O.dt = RECOMMENDED_TIME_STEP\nWALL_MATERIALS = {"wall": wall}\n'
    deck = replaced(begin, "O.dt = .*", "") + card + own + rest
    if not rolls:
        return deck
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


def bulk_test_of(name: str, law: str) -> BulkTest:
    """Return the test of a law; of one diameter where the solver has no other."""
    test = LAWS[law][0]
    one = ParticleSizes((0.010,))
    return test.with_sizes(one) if law == "linear" and name in ONE_SIZE else test


def card_of(card: MaterialCard, name: str, law: str) -> MaterialCard:
    """Return the card of a mixture with walls of its own, in a bulk test and a contact law."""
    _, models, changes = LAWS[law]
    test = bulk_test_of(name, law)
    changes = VALUES | changes
    idle = {"epsd2": "rolling_damping"}.get(law, "none")
    if name == "yade":
        # It has no rolling dashpot.
        changes["particle_wall.rolling_damping"] = 0.0
    if (name, law) == ("yade", "linear"):
        changes |= {f"particle_{body}.rolling_friction": 0.0 for body in ("particle", "wall")}
    values = {n: v for n, v in {**card.values, **changes}.items() if not n.endswith(idle)}
    step = test.time_step(values)
    return replace(
        card,
        parameters=tuple(CardParameter(n, "", "", "", v, "given") for n, v in values.items()),
        sizes=test.sizes,
        recommended_time_step=step,
        rayleigh_time_step=step / test.time_step_fraction,
        contact_models=models,
    )


def simulated(
    name: str, test: BulkTest, card: MaterialCard, folder: Path, change: Callable[[str], str] = str
) -> RunOutput:
    """Run the deck of a test, which may be changed; return what it leaves."""
    folder.mkdir()
    solver = DEM_PROGRAMS[name](test, card.values, contact_models=card.contact_models)
    scene = replace(test.scene(solver.run_parameters({}), SEED), contact_models=card.contact_models)
    deck = solver.deck(scene, folder).write()
    deck.write_text(change(deck.read_text(encoding="utf-8")), encoding="utf-8")
    solver._simulate(deck, Workspace(folder, 600.0))
    struck = [stage.name for stage in scene.stages if stage.strike_off is not None]
    return RunOutput(folder, len(scene.particles.size_indices), struck)


def cases() -> Iterator[Any]:
    marks = {"liggghts": needs.LIGGGHTS, "yade": needs.YADE}
    for name in FED:
        for law in LAWS:
            if all(name in m.solvers for m in CONTACT_MODELS if m.name == law):
                found = [marks[name]] if name in marks else []
                # A bed takes YADE five times as long.
                if name == "yade" and law in {"epsd", "dmt", "linear"}:
                    found.append(pytest.mark.thorough)
                yield pytest.param(name, law, marks=[pytest.mark.slow, *found], id=f"{name}-{law}")


@pytest.mark.parametrize(("name", "law"), [*cases()])
def test_a_bed_from_the_card_is_that_of_the_own_deck(
    card: MaterialCard, tmp_path: Path, name: str, law: str
) -> None:
    fed, test, fed_card = FED[name], bulk_test_of(name, law), card_of(card, name, law)

    def feed(deck: str) -> str:
        text = render(fed_card, name)
        (tmp_path / "card" / fed.card).write_text(text, encoding="utf-8")
        return fed.deck(deck)

    own = simulated(name, test, fed_card, tmp_path / "own")
    found = simulated(name, test, fed_card, tmp_path / "card", feed)

    assert [stage.time for stage in found.stages] == [stage.time for stage in own.stages]
    snapshots = [p.name for p in (tmp_path / "own" / "snapshots").iterdir()]
    assert snapshots
    for snapshot in snapshots:
        texts = [(tmp_path / f / "snapshots" / snapshot).read_text() for f in ("own", "card")]
        assert texts[0] == texts[1], snapshot
    responses = test.measure(own)
    assert test.measure(found) == responses
    assert np.isfinite(responses[test.response_names[0]].value)
