"""The command that writes a material card."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer
from rich.text import Text

from grainfit.cli.consoles import err, err_remarks
from grainfit.cli.help_texts import shown_default
from grainfit.cli.options import Force, WorkFolder, output_option, require_free

_OUTPUT = f"Where to write it. {shown_default('standard output')}"


def export(
    folder: WorkFolder,
    to: Annotated[
        str,
        typer.Option(
            "--to",
            metavar="FORMAT",
            help="liggghts, lammps or yade: to include in a deck; edem, rocky, mercurydpm, pfc, "
            "mfix or aspherix: every conversion beside its value; json or csv: for programs.",
            show_default=False,
        ),
    ],
    output: Annotated[Path | None, output_option("FILE", _OUTPUT)] = None,
    force: Force = False,
) -> None:
    """Write a material card: calibrated and given values, how sure they are, and their origin."""
    from grainfit.cards import material_card, require_format, write_card
    from grainfit.formatting import plain

    render = require_format(to, "--to")
    require_free(output, force=force)
    card = material_card(folder)
    text = render(card)
    if output is None or str(output) == "-":
        # As bytes: the card is UTF-8 on every terminal.
        typer.echo(text.encode(), nl=False)
    else:
        write_card(output, text)
        err_remarks.print(Text(f"Wrote {plain(str(output))}"), soft_wrap=True)
    if not card.calibrated:
        err.print(Text(plain(card.verdict), style="bold red"), soft_wrap=True)
