"""The command that shows the result of a calibration."""

from __future__ import annotations

from grainfit.cli import console as show
from grainfit.cli.consoles import out
from grainfit.cli.documents import AsJson, print_document, result_document
from grainfit.cli.options import WorkFolder


def result(workdir: WorkFolder, as_json: AsJson = False) -> None:
    """Show the result of a calibration, as 'grainfit run' showed it at its end."""
    from grainfit.work_folder.open_folder import open_folder

    with open_folder(workdir) as opened:
        found = opened.require_result()
    if as_json:
        print_document("result", result_document(workdir, found))
    else:
        show.print_result(out, found, workdir)
