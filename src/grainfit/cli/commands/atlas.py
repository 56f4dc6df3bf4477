"""The command that shows what the atlas has."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from grainfit.cli import console as show
from grainfit.cli import messages
from grainfit.cli.consoles import out
from grainfit.cli.help_texts import shown_default
from grainfit.cli.options import Force, OpenAfterwards, open_in_browser, output_option, require_free

_OUTPUT = "The page. " + shown_default("grainfit-atlas.html, here")


def atlas(
    output: Annotated[Path | None, output_option("FILE.html", _OUTPUT)] = None,
    open_afterwards: OpenAfterwards = False,
    force: Force = False,
) -> None:
    """Write a page with sliders: what every parameter does to every response of a bulk test.

    The curves come from the atlas, simulated runs that ship with grainfit. The page is one file
    that works offline.

    Example:  grainfit atlas --open
    """
    path = output or Path("grainfit-atlas.html")
    require_free(path, force=force)
    from grainfit.atlas.shelf import shipped_atlas
    from grainfit.atlas_page.page import atlas_page
    from grainfit.files import write_atomically, writing

    with writing(path):
        write_atomically(path, atlas_page(shipped_atlas()))
    counts = shipped_atlas().counts
    rows = ", ".join(f"{name} {count}" for name, count in counts.items())
    damaged = [
        messages.DAMAGED_ATLAS(test=name, folder=shipped_atlas().folder)
        for name in shipped_atlas().faults()
    ]
    show.print_parts(out, (f"Runs of the atlas: {rows}.", *damaged, f"Page: {path}"))
    if open_afterwards:
        open_in_browser(path)
