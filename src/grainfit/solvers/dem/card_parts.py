"""Common parts of the cards of all solvers: required parameters, variable names, comments."""

from __future__ import annotations

import textwrap
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any

from grainfit.contact_models.base import ContactLaw
from grainfit.contact_models.registry import (
    contact_law,
    contact_law_faults,
    material_parameter,
    parameters_of_walls,
    simulated_material,
    size_faults,
    with_defaults,
)
from grainfit.errors import InputError
from grainfit.formatting import in_a_row, variable_name, without_noise
from grainfit.materials.card import CardParameter, MaterialCard
from grainfit.materials.card_text import about, comment, comments, header
from grainfit.materials.equations import SYMBOLS
from grainfit.materials.parameters import BODY_PARAMETERS, MaterialParameter
from grainfit.materials.sizes import ParticleSizes
from grainfit.materials.walls import PLAIN, plain_name, wall_of, walls_among
from grainfit.solvers.dem import messages
from grainfit.solvers.dem.sphere_types import is_one_size
from grainfit.solvers.dem.templates import fill
from grainfit.solvers.registry import DEM_PROGRAMS

#: Parameters of particles and walls that influence contacts.
_BODIES = {parameter.name for parameter in BODY_PARAMETERS} - {"wall.density"}
_LONGEST_VARIABLE = 60
_WIDTH = 96


def origin(card: MaterialCard, solver: str) -> str:
    """Return comments on the validity of the values in this solver."""
    return "\n".join(comment(line) for line in textwrap.wrap(_validity(card, solver), _WIDTH))


def equations(card: MaterialCard, solver: str) -> str:
    """Return comments with the contact law as the solver computes it, and its conventions."""
    law = contact_law(with_defaults(card.values), card.contact_models).in_solver(solver)
    found = law.equations(solver)
    used = {symbol for equation in found for symbol in equation.symbols}
    models = in_a_row([model.name for model in law.models])
    return comments(
        [
            "",
            f"Contact law: {models} in {DEM_PROGRAMS[solver].title}",
            *(f"  {equation.words}" for equation in found),
            *(f"  {c.symbol} ({c.key}): {c.meaning}" for c in law.conventions),
            *(f"  {symbol}: {meaning}" for symbol, meaning in SYMBOLS.items() if symbol in used),
        ]
    )


def _validity(card: MaterialCard, solver: str) -> str:
    found = {program.name for program in card.programs}
    if found == {solver}:
        return messages.CALIBRATED_HERE(solver=DEM_PROGRAMS[solver].title)
    if not found or not found <= DEM_PROGRAMS.keys():
        return messages.CALIBRATED_ELSEWHERE()
    solvers = " and ".join(DEM_PROGRAMS[name].title for name in sorted(found))
    law = contact_law(card.values, card.contact_models)
    if difference := law.solver_difference(card.values, found | {solver}):
        return messages.CALIBRATED_DIFFERENTLY(solvers=solvers, difference=difference)
    return messages.CALIBRATED_ALIKE(solvers=solvers)


def simulated_card(card: MaterialCard) -> MaterialCard:
    """Return a card with the values of the simulated particles, which may be larger than the real.

    Descriptions of values that differ say so.
    """
    factor = 1.0 if card.sizes is None else card.sizes.coarse_graining
    ratios = simulated_material(dict.fromkeys(card.values, 1.0), factor)
    return replace(card, parameters=tuple(_simulated(p, ratios[p.name]) for p in card.parameters))


def _simulated(parameter: CardParameter, ratio: float) -> CardParameter:
    if ratio == 1:
        return parameter
    meaning = parameter.description or parameter.name
    value, low, high = (
        without_noise(ratio * one) for one in (parameter.value, *(parameter.interval or (0.0, 0.0)))
    )
    return replace(
        parameter,
        value=value,
        interval=None if parameter.interval is None else (low, high),
        description=f"{meaning}, {ratio:g} times that of the real particles",
    )


def require_material(card: MaterialCard, solver: str) -> tuple[dict[str, float], ContactLaw]:
    """Return the values of all parameters of a card, and their contact law.

    Parameters
    ----------
    card : MaterialCard
        With the values of the simulated particles.
    solver : str
        Name of the solver.

    Raises
    ------
    InputError
        A parameter that the solver needs is missing or has an impossible value, or the solver does
        not have a contact model that the card needs.
    """
    values = with_defaults(card.values)
    faults = contact_law_faults(values, solver, card.contact_models)
    InputError.raise_for(faults)
    law = contact_law(values, card.contact_models)
    if card.sizes is not None and (
        faults := size_faults(law, solver, is_one_size=is_one_size(card.sizes))
    ):
        raise InputError(faults)
    # Without a plain wall, nothing is made of its defaults.
    walls = walls_of_card(card)
    values = {n: v for n, v in values.items() if wall_of(n) is None or wall_of(n) in walls}
    needs = _BODIES | law.needs(solver)
    needed = [n for n in parameters_of_walls(walls) if plain_name(n) in needs]
    _require_nothing_missing([name for name in needed if name not in values], solver)
    InputError.raise_for(
        messages.NOT_ON_CARD.fault(name, value=values[name], solver=solver, limits=_limits(known))
        for name in needed
        if (known := material_parameter(name)) is not None
        and not known.lowest <= values[name] <= known.highest
    )
    return values, law


def require_sizes(card: MaterialCard, solver: str) -> ParticleSizes:
    """Return the particle sizes of a card.

    Raises
    ------
    InputError
        The sizes are not known.
    """
    if card.sizes is None:
        _require_nothing_missing(["particle.diameter"], solver)
    assert card.sizes is not None
    return card.sizes


def _require_nothing_missing(missing: Sequence[str], solver: str) -> None:
    if missing:
        needed = ", ".join(missing)
        raise InputError(messages.CARD_NEEDS.fault("", solver=solver, missing=needed))


def walls_of_card(card: MaterialCard) -> tuple[str, ...]:
    """Return the walls that a card has parameters of, at least the plain one."""
    return walls_among(card.values) or (PLAIN,)


def _limits(known: MaterialParameter) -> str:
    return f"It must be from {known.lowest:g} to {known.highest:g} {known.unit}".rstrip() + "."


def variables(
    parameters: Sequence[CardParameter], taken: Sequence[str]
) -> Iterator[tuple[str, CardParameter]]:
    """Yield every parameter with a unique name that is valid in a deck.

    Parameters
    ----------
    parameters : sequence of CardParameter
        The parameters, with any names.
    taken : sequence of str
        Names that the deck uses for something else.
    """
    used = set(taken)
    for parameter in parameters:
        # Hash signs, quotes and line ends in a name would be read as commands of the deck.
        name = variable_name(parameter.name)[:_LONGEST_VARIABLE]
        number = 1
        while name in used:
            number += 1
            name = f"{name.removesuffix(f'_{number - 1}')}_{number}"
        used.add(name)
        yield name, parameter


def model_notes(notes: Iterable[str]) -> str:
    """Return the notes of contact models as comments; a model without notes has none."""
    return "\n".join(f"# {line}" for text in notes for line in text.splitlines())


def fill_card(solver: str, card: MaterialCard, values: Mapping[str, Any]) -> str:
    """Fill in the card of a solver: what all cards have, and values of its own."""
    law = equations(card, solver)
    common: dict[str, Any] = {"header": f"{header(card)}\n{law}", "origin": origin(card, solver)}
    common |= {"card": card, "about": about}
    return fill(solver, common | dict(values))
