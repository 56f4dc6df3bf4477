"""Pages that a command serves on this machine until Ctrl-C."""

from __future__ import annotations

import os
import socket
import time
from contextlib import suppress
from typing import TYPE_CHECKING, Annotated

import typer
from rich.console import Console

from grainfit.cli.consoles import out
from grainfit.cli.help_texts import shown_default

if TYPE_CHECKING:
    from grainfit.local_pages.server import LocalServer

Port = Annotated[
    int,
    typer.Option(
        "--port",
        metavar="N",
        min=0,
        max=65535,
        help=f"Port of the page. {shown_default('any that is free')}",
        show_default=False,
    ),
]
OpenPage = Annotated[
    bool, typer.Option("--open/--no-open", help="Show that page in the web browser.")
]


def serve_page(server: LocalServer, word: str, open_page: bool) -> None:
    """Serve a page until Ctrl-C; the word stands before its address."""
    from grainfit.local_pages.server import address_of, new_token

    ticket = new_token()
    with suppress(KeyboardInterrupt):
        server.serve()
        print_address(out, word, server.address)
        if open_page:
            server.add_ticket(ticket)
            open_address(address_of(server.socket, ticket))
        # On Windows, Ctrl-C ends a sleep, but not an event that is waited for.
        while True:
            time.sleep(3600)


def print_address(console: Console, word: str, address: str) -> None:
    """Print the address of a page, and how to reach it from another machine."""
    console.print(f"{word}: {address}", highlight=False, markup=False, soft_wrap=True)
    if "SSH_CONNECTION" in os.environ:
        port = address.split(":")[2].partition("/")[0]
        tunnel = f"ssh -L {port}:127.0.0.1:{port} {socket.gethostname()}"
        console.print(
            f"First, on your own machine: {tunnel}", highlight=False, markup=False, soft_wrap=True
        )


def open_address(address: str) -> None:
    """Show a page in the web browser."""
    import webbrowser

    webbrowser.open(address)
