"""The command that lists the instruments that a test can name."""

from __future__ import annotations

from typing import Annotated

import typer

from grainfit.cli import console as show
from grainfit.cli.completion import complete_instrument
from grainfit.cli.consoles import out

_Name = Annotated[
    str | None,
    typer.Argument(
        metavar="[NAME]",
        help="An instrument, to see its dimensions with their sources.",
        show_default=False,
        autocompletion=complete_instrument,
    ),
]


def apparatus(name: _Name = None) -> None:
    """List the instruments whose dimensions a test can take by name, or show one of them.

    In the calibration file:  apparatus = "granudrum"  in a [[test]] of its type.

    Example:  grainfit apparatus granudrum
    """
    from grainfit.bulk_tests.instrument import instrument_table, read_instrument

    show.print_parts(out, [instrument_table()] if name is None else read_instrument(name).parts())
