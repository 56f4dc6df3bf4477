"""The command that leads from nothing to a running calibration, in the browser."""

from __future__ import annotations

import shlex
from pathlib import Path

from grainfit.cli import messages
from grainfit.cli.consoles import err
from grainfit.cli.local_page import OpenPage, Port, serve_page
from grainfit.cli.options import NewCalibrationPath, TestSolver


def start(
    file: NewCalibrationPath = Path("calibration.toml"),
    solver: TestSolver = "lammps",
    port: Port = 0,
    open_page: OpenPage = True,
) -> None:
    """Open a page that leads from a material to a running calibration.

    The questions of 'grainfit ask', with the estimate of the atlas as values are typed, cost and
    forecast before the start, and the start itself, which is 'grainfit run FILE'. Every answer is
    in FILE at once: reload, come back, or go on with an editor.

    The page is served on this machine alone, to whoever has its address. Ctrl-C ends it; a
    calibration that was started goes on.

    Example:  grainfit start pellets.toml
    """
    from grainfit.interview.interview import Interview
    from grainfit.local_pages.server import listen
    from grainfit.start_page.server import StartServer

    # A file with a fault is told here, before there is a page.
    Interview.open(file, solver)
    server = StartServer(file, listen(port), solver)
    serve_page(server, "Start", open_page)
    if server.is_running:
        err.print(
            messages.GOES_ON(folder=shlex.quote(str(server.work_folder))),
            highlight=False,
            markup=False,
        )
