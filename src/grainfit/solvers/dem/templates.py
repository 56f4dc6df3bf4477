"""Fill in templates in the folders of solvers: of their decks and of their cards."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from jinja2 import Environment, PackageLoader, StrictUndefined


def fill(solver: str, values: Mapping[str, Any], template: str = "card.j2") -> str:
    """Fill in a template in the folder of a solver; numbers keep all digits."""
    environment = Environment(
        loader=PackageLoader("grainfit.solvers.dem", solver),
        undefined=StrictUndefined,
        keep_trailing_newline=True,
        trim_blocks=True,
        lstrip_blocks=True,
        autoescape=False,
    )
    return environment.get_template(template).render(values)
