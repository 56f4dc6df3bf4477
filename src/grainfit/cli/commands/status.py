"""The command that shows the progress of a calibration."""

from __future__ import annotations

from grainfit.cli import console as show
from grainfit.cli.consoles import out
from grainfit.cli.documents import AsJson, print_document, status_document
from grainfit.cli.options import WorkFolder


def status(workdir: WorkFolder, as_json: AsJson = False) -> None:
    """Show the progress of a calibration and the values that it found, also while it is running."""
    from grainfit.work_folder.status import read_status

    found = read_status(workdir)
    if as_json:
        print_document("status", status_document(workdir, found))
    else:
        show.print_status(out, found)
