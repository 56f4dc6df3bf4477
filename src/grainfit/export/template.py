"""Templates of cards, and the names of variables in them."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from jinja2 import Environment, PackageLoader, StrictUndefined

from grainfit.export.card import CardParameter
from grainfit.solvers.model_input import variable_name

_LONGEST_VARIABLE = 60


def variables(
    parameters: Sequence[CardParameter], taken: Sequence[str]
) -> Iterator[tuple[str, CardParameter]]:
    """Return every parameter with a name that a deck can have for it, and no other has.

    Parameters
    ----------
    parameters : sequence of CardParameter
        Whatever they are called.
    taken : sequence of str
        Names that the deck needs for something else.
    """
    used = set(taken)
    for parameter in parameters:
        # Hash signs, quotes and line ends of a name would be commands of the deck.
        name = variable_name(parameter.name)[:_LONGEST_VARIABLE]
        number = 1
        while name in used:
            number += 1
            name = f"{name.removesuffix(f'_{number - 1}')}_{number}"
        used.add(name)
        yield name, parameter


def fill(template: str, values: Mapping[str, Any]) -> str:
    """Fill in the template of a card; numbers are written so that they read back exactly."""
    environment = Environment(
        loader=PackageLoader("grainfit.export", "cards"),
        undefined=StrictUndefined,
        keep_trailing_newline=True,
        trim_blocks=True,
        lstrip_blocks=True,
        autoescape=False,
    )
    return environment.get_template(template).render(values)
