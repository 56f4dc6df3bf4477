"""The command that measures photographs."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Literal

import typer

from grainfit.cli import console as show
from grainfit.cli.consoles import err_remarks, out


def photo(
    pictures: Annotated[
        list[Path],
        typer.Argument(
            metavar="PICTURE...",
            help="Pictures, each of a heap of its own; a folder has pictures of one heap.",
            show_default=False,
        ),
    ],
    test: Annotated[
        Literal["heap", "funnel"], typer.Option(help="Test whose heap is photographed.")
    ] = "heap",
    diameter: Annotated[
        str | None,
        typer.Option(metavar="LENGTH", help='Of the particles, such as "3 mm"; needs --plate.'),
    ] = None,
    plate: Annotated[
        str | None,
        typer.Option(metavar="LENGTH", help='Diameter of the round plate, such as "200 mm".'),
    ] = None,
    elevation: Annotated[
        str | None,
        typer.Option(
            metavar="ANGLE",
            help='Of the camera above the horizontal, such as "5 deg", where neither plate nor '
            "foot tell it.",
        ),
    ] = None,
    overlays: Annotated[
        Path, typer.Option(metavar="DIR", help="Where pictures with what was found are written.")
    ] = Path("overlays"),
) -> None:
    """Measure the angle of repose of heaps on photographs, as of simulated heaps.

    Look at the overlays: they show outline, plate and flanks as they were found.
    A picture that cannot be measured is refused with the reason.

    Example:  grainfit photo heap_*.jpg --plate "200 mm" --diameter "3 mm"
    """
    with err_remarks.status("photographs"):
        from grainfit.photographs.photo import photo as measured

        known = {"diameter": diameter, "plate": plate, "elevation": elevation}
        found = measured(pictures, test, **known, overlays=overlays)
    show.print_parts(out, found.summary())
