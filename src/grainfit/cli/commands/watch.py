"""The page that follows a calibration: for a work folder, and for a run."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Annotated

import typer

from grainfit.cli import console as show
from grainfit.cli import messages
from grainfit.cli.consoles import err
from grainfit.cli.local_page import OpenPage, Port, open_address, print_address, serve_page
from grainfit.cli.options import WorkFolder
from grainfit.errors import StoreError

Watch = Annotated[
    bool,
    typer.Option(
        "--watch",
        help="Serve a page on this machine that follows the run; --port and --open do, too.",
    ),
]


def watch(
    workdir: WorkFolder,
    port: Port = 0,
    open_page: OpenPage = False,
) -> None:
    """Follow a calibration in the web browser, while it runs: verdict so far, runs, time left.

    The page is served on this machine alone, to whoever has its address. It reads the work folder
    and changes nothing, but for its stop button, which does what Ctrl-C in the terminal of the run
    does. Over a network, make a tunnel first: ssh -L PORT:127.0.0.1:PORT MACHINE

    Ctrl-C ends the page; the calibration goes on.
    """
    from grainfit.campaign.store.store import STORE_NAME, not_a_work_folder
    from grainfit.local_pages.server import listen
    from grainfit.watch.server import WatchServer

    if not (workdir / STORE_NAME).exists():
        raise StoreError(str(not_a_work_folder(workdir)))
    serve_page(WatchServer(workdir, listen(port)), "Watch", open_page)


@contextmanager
def watching(folder: Path, port: int, open_page: bool) -> Iterator[None]:
    """Serve the page of a run in a process of its own until the end of the block.

    Raises
    ------
    InputError
        The port cannot be used.
    """
    from grainfit.local_pages.server import address_of, listen, new_token
    from grainfit.watch.child import WatchProcess

    listening, token, ticket = listen(port), new_token(), new_token()
    address, opened = address_of(listening, token), address_of(listening, ticket)
    try:
        process = WatchProcess(folder, listening, token, ticket)
    except OSError as error:
        show.print_warning(err, messages.NO_PAGE(reason=error.strerror))
        yield
        return
    try:
        print_address(err, "Watch", address)
        if open_page:
            open_address(opened)
        yield
    finally:
        process.end()
