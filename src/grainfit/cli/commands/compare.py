"""The command that puts calibrations side by side."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from grainfit.cli import console as show
from grainfit.cli.consoles import out, out_remarks
from grainfit.cli.documents import AsJson, print_document
from grainfit.cli.options import (
    Force,
    OpenAfterwards,
    open_in_browser,
    output_option,
    require_free,
)

Folders = typer.Argument(metavar="DIR", help="Work folders of calibrations.")

_PAGE = Path("compared.html")
_OUTPUT = f"Write a page. With --open, {_PAGE} in this folder by default."


def compare(
    folders: Annotated[list[Path], Folders],
    output: Annotated[Path | None, output_option("FILE.html", _OUTPUT)] = None,
    open_it: OpenAfterwards = False,
    as_json: AsJson = False,
    force: Force = False,
) -> None:
    """Put calibrations side by side: two materials, or one with other tests, solvers or seeds.

    Parameters and responses whose 95 % intervals are apart differ; the others agree. Fixed
    parameters are shown where they are not the same.
    """
    path = output or (_PAGE if open_it else None)
    require_free(path, force=force)
    from grainfit.work_folder.comparison import compare as compared
    from grainfit.work_folder.saved_calibration import SavedCalibration

    saved = [SavedCalibration.open(folder) for folder in folders]
    found = compared(saved)
    if path:
        from grainfit.report.compared.page import write_compared_page

        write_compared_page(found, saved, path)
        if not as_json:
            out_remarks.print(f"Page: {path}", highlight=False, markup=False, soft_wrap=True)
        if open_it:
            open_in_browser(path)
    if as_json:
        print_document("comparison", found.document())
    elif not path:
        show.print_parts(out, found.parts())
