"""The command that answers by the atlas, before any simulation."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from grainfit.cli import console as show
from grainfit.cli import messages
from grainfit.cli.consoles import out
from grainfit.cli.documents import AsJson, estimate_document, print_document
from grainfit.cli.help_texts import shown_default
from grainfit.cli.options import Force, output_option, require_free
from grainfit.errors import InputError

_File = Annotated[
    Path | None,
    typer.Argument(metavar="FILE", help="Calibration file (TOML).", show_default=False),
]
_Diameter = Annotated[
    str, typer.Option(metavar="LENGTH", help="Without a file: diameter of the particles.")
]
_BulkDensity = Annotated[
    str, typer.Option(metavar="DENSITY", help="Without a file: measured bulk density.")
]
_Angle = Annotated[
    str,
    typer.Option(
        metavar="ANGLE", help="Without a file: angle of repose of a heap below a lifted cylinder."
    ),
]
_Density = Annotated[
    str,
    typer.Option(
        metavar="DENSITY",
        help="Without a file: density of the particles. "
        + shown_default("1.5 to 2 times the bulk density"),
    ),
]
_OUTPUT = "A picture of the probabilities. " + shown_default("none")


def estimate(
    file: _File = None,
    diameter: _Diameter = "",
    bulk_density: _BulkDensity = "",
    angle: _Angle = "",
    density: _Density = "",
    output: Annotated[Path | None, output_option("FILE.png", _OUTPUT)] = None,
    as_json: AsJson = False,
    force: Force = False,
) -> None:
    """Say which parameters agree with the measurements, at once, by runs that ship with grainfit.

    The atlas has simulated runs of the bulk tests in natural units: they tell about spheres of any
    size and density. Nothing is simulated now, so an estimate is no calibration: 'grainfit run'
    verifies it. It works without a file for a heap below a lifted cylinder.

    Example:  grainfit estimate --diameter 3mm --bulk-density 540kg/m^3 --angle 34deg
    """
    require_free(output, force=force)
    from grainfit.work_folder.estimate import estimate as of_file
    from grainfit.work_folder.estimate import estimate_of_heap
    from grainfit.work_folder.estimate_picture import draw_estimate

    measured = {
        "--diameter": diameter,
        "--bulk-density": bulk_density,
        "--angle": angle,
        "--density": density,
    }
    if file is not None:
        given = [name for name, text in measured.items() if text]
        InputError.raise_for([messages.BESIDE_FILE.fault(name) for name in given])
        found = of_file(file)
    elif diameter:
        found = estimate_of_heap(diameter, bulk_density, angle, density)
    else:
        raise InputError(messages.NOTHING_TO_ESTIMATE.fault("FILE"))
    parts = list(found.summary())
    if output is not None:
        draw_estimate(found, output)
        parts.append(f"Picture: {output}")
    if as_json:
        print_document("estimate", estimate_document(file, found))
        return
    show.print_parts(out, parts)
