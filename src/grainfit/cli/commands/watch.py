"""The page that follows a calibration: for a work folder, and for a run."""

from __future__ import annotations

import os
import socket
import threading
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console

from grainfit.cli import console as show
from grainfit.cli import messages
from grainfit.cli.consoles import err, out
from grainfit.cli.help_texts import shown_default
from grainfit.cli.options import WorkFolder
from grainfit.errors import StoreError

Port = Annotated[
    int,
    typer.Option(
        "--port",
        metavar="N",
        min=0,
        max=65535,
        help=f"Port of the page that follows the calibration. {shown_default('any that is free')}",
        show_default=False,
    ),
]
OpenPage = Annotated[
    bool, typer.Option("--open/--no-open", help="Show that page in the web browser.")
]
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
    from grainfit.watch.server import WatchServer, address_of, listen, new_token, serve

    if not (workdir / STORE_NAME).exists():
        raise StoreError(str(not_a_work_folder(workdir)))
    server, ticket = WatchServer(workdir, listen(port)), new_token()
    with suppress(KeyboardInterrupt):
        serve(server)
        _print_address(out, server.address)
        if open_page:
            server.add_ticket(ticket)
            _open(address_of(server.socket, ticket))
        threading.Event().wait()


@contextmanager
def watching(folder: Path, port: int, open_page: bool) -> Iterator[None]:
    """Serve the page of a run in a process of its own until the end of the block.

    Raises
    ------
    InputError
        The port cannot be used.
    """
    from grainfit.watch.child import WatchProcess
    from grainfit.watch.server import address_of, listen, new_token

    listening, token, ticket = listen(port), new_token(), new_token()
    address, opened = address_of(listening, token), address_of(listening, ticket)
    try:
        process = WatchProcess(folder, listening, token, ticket)
    except OSError as error:
        show.print_warning(err, messages.NO_PAGE(reason=error.strerror))
        yield
        return
    try:
        _print_address(err, address)
        if open_page:
            _open(opened)
        yield
    finally:
        process.end()


def _print_address(console: Console, address: str) -> None:
    console.print(f"Watch: {address}", highlight=False, markup=False, soft_wrap=True)
    if "SSH_CONNECTION" in os.environ:
        port = address.split(":")[2].partition("/")[0]
        tunnel = f"ssh -L {port}:127.0.0.1:{port} {socket.gethostname()}"
        console.print(
            f"First, on your own machine: {tunnel}", highlight=False, markup=False, soft_wrap=True
        )


def _open(address: str) -> None:
    import webbrowser

    webbrowser.open(address)
