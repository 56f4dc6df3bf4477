"""The page that follows a work folder, served on this machine alone.

There are five addresses below the token, and no name of a file is ever taken from one.
"""

from __future__ import annotations

import socket
import threading
from contextlib import suppress
from functools import partial
from http import HTTPStatus
from pathlib import Path
from typing import ClassVar

from typing_extensions import override

from grainfit.files import LARGEST_RESULT, read_within
from grainfit.local_pages.server import HTML, JSON, LocalHandler, LocalServer
from grainfit.report.page import REPORT_NAME
from grainfit.report.rendering import script_json
from grainfit.watch.follower import Follower
from grainfit.watch.page import watch_page
from grainfit.watch.stopping import CannotStopError, stop_calibration

#: Interval of the signs of life in a stream of events, s.
_ALIVE_SECONDS = 15.0
#: The report is a page of its own, which must not use the address that it was reached by.
_REPORT_POLICY = (
    "sandbox allow-scripts allow-downloads; default-src 'none'; style-src 'unsafe-inline'; "
    "script-src 'unsafe-inline'; img-src data: blob:"
)


class WatchServer(LocalServer):
    """Server of the page of one work folder.

    Parameters
    ----------
    folder : Path
        The work folder.
    listening : socket
        From `listen`.
    token : str, optional
        Secret part of the address; a random one by default.
    """

    def __init__(self, folder: Path, listening: socket.socket, token: str = "") -> None:
        super().__init__(_Handler, listening, token)
        self.folder = folder
        self.follower = Follower(folder)

    @override
    def serve(self) -> threading.Thread:
        """Follow the folder and answer requests, in threads of their own."""
        self.follower.start()
        return super().serve()


class _Handler(LocalHandler):
    server: WatchServer
    #: Stopping the calibration is the only thing that can be changed from here.
    posts: ClassVar[tuple[str, ...]] = ("stop",)

    @override
    def answer(self, rest: str) -> None:
        if not rest:
            self.send_page(partial(watch_page, self.server.folder), "data:")
        elif rest == "events":
            self._send_events()
        elif rest == "report":
            self._send_report()
        elif rest.startswith("drawing/"):
            self._send_drawing(rest.removeprefix("drawing/"))
        else:
            self.refuse_page()

    @override
    def change(self, rest: str) -> None:
        try:
            stop_calibration(self.server.folder)
        except CannotStopError as error:
            self.send(HTTPStatus.CONFLICT, JSON, script_json({"why": str(error)}))
            return
        self.send(HTTPStatus.OK, JSON, "{}")

    def _send_report(self) -> None:
        try:
            page = read_within(self.server.folder / REPORT_NAME, LARGEST_RESULT)
        except OSError:
            self.refuse(HTTPStatus.NOT_FOUND, "There is no report yet.")
            return
        policy = {"Content-Security-Policy": _REPORT_POLICY}
        self.send(HTTPStatus.OK, HTML, page, policy)

    def _send_drawing(self, key: str) -> None:
        found = self.server.follower.drawing(key)
        if found is None:
            self.refuse(HTTPStatus.NOT_FOUND, "There is no such drawing.")
        else:
            self.send(HTTPStatus.OK, JSON, found)

    def _send_events(self) -> None:
        follower, seen = self.server.follower, 0
        self.begin(HTTPStatus.OK, "text/event-stream", {})
        with follower.watching(), suppress(OSError):
            while True:
                has_ended = follower.has_ended
                number, state = follower.wait(seen, _ALIVE_SECONDS)
                self.wfile.write(b": alive\n\n" if number == seen else _event(state))
                self.wfile.flush()
                if has_ended:
                    return
                seen = number


def _event(state: str) -> bytes:
    return f"data: {state}\n\n".encode()
