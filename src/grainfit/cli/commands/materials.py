"""The command that lists the starting materials and searches among them."""

from __future__ import annotations

from typing import Annotated

import typer

from grainfit.cli import console as show
from grainfit.cli.completion import complete_material
from grainfit.cli.consoles import out

_Words = Annotated[
    list[str] | None,
    typer.Argument(
        metavar="[WORD]...",
        help="Words of a name, a synonym or a class; one material is shown with its sources.",
        show_default=False,
        autocompletion=complete_material,
    ),
]
_Class = Annotated[
    str,
    typer.Option(
        "--class",
        metavar="NAME",
        help="One class alone, such as seeds, ores or powders.",
        show_default=False,
    ),
]


def materials(words: _Words = None, of_class: _Class = "") -> None:
    """List the starting materials of 'grainfit new', or search among them.

    What is published of each has its public source; nothing is calibrated.

    Example:  grainfit materials rape seed
    """
    from grainfit.materials.material_tables import material_parts

    show.print_parts(out, material_parts(" ".join(words or []), of_class))
