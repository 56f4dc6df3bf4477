"""Serve the page on this machine alone, to whoever has its address.

Every address begins with a random token, because other users of the machine can reach the port. It
is a part of the path, not a cookie, which a browser would send to every port of the host. There are
five addresses, and no name of a file is ever taken from one.
"""

from __future__ import annotations

import hmac
import secrets
import socket
import threading
import time
from contextlib import suppress
from functools import partial
from http import HTTPStatus
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from typing import Any
from urllib.parse import urlsplit

from typing_extensions import override

from grainfit.errors import InputError
from grainfit.files import LARGEST_RESULT, read_within
from grainfit.report.page import REPORT_NAME
from grainfit.report.rendering import script_json
from grainfit.watch import messages
from grainfit.watch.follower import Follower
from grainfit.watch.page import watch_page
from grainfit.watch.stopping import CannotStopError, stop_calibration

HOST = "127.0.0.1"
#: Names by which a browser on this machine, or at the end of a tunnel, calls it. A page of another
#: site reaches the port under its own name only (DNS rebinding).
_NAMES = ("127.0.0.1", "localhost")
_JSON, _HTML = "application/json", "text/html; charset=utf-8"
#: Time in which a client has to send its request, and after which one that has not gives its place
#: to another when there is no free one.
_REQUEST_SECONDS, _PATIENT_SECONDS = 10.0, 1.0
#: Interval of the signs of life in a stream of events, s.
_ALIVE_SECONDS = 15.0
#: Connections of those who have the token, and of those who have not sent it yet.
_MOST_CONNECTIONS = 64
#: Time for which the address of `WatchServer.ticket` holds, s.
_TICKET_SECONDS = 60.0
_HEADERS = {
    "Cache-Control": "no-store",
    "Referrer-Policy": "no-referrer",
    "X-Content-Type-Options": "nosniff",
    "X-Frame-Options": "DENY",
    "Cross-Origin-Resource-Policy": "same-origin",
    "Cross-Origin-Opener-Policy": "same-origin",
}
_NOTHING = "default-src 'none'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'"
_PAGE_POLICY = (
    f"{_NOTHING}; script-src 'nonce-NONCE'; style-src 'nonce-NONCE'; img-src data:; "
    "connect-src 'self'"
)
#: The report is a page of its own, which must not use the address that it was reached by.
_REPORT_POLICY = (
    "sandbox allow-scripts allow-downloads; default-src 'none'; style-src 'unsafe-inline'; "
    "script-src 'unsafe-inline'; img-src data: blob:"
)


def listen(port: int) -> socket.socket:
    """Return a socket that listens on this machine alone; port 0 is any that is free.

    Raises
    ------
    InputError
        The port cannot be used.
    """
    listening = socket.socket()
    listening.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
    try:
        listening.bind((HOST, port))
        listening.listen()
    except OSError as error:
        listening.close()
        fault = messages.PORT_TAKEN.fault("port", port=port, reason=error.strerror)
        raise InputError(fault) from error
    return listening


class WatchServer(ThreadingHTTPServer):
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

    daemon_threads = True
    block_on_close = False

    def __init__(self, folder: Path, listening: socket.socket, token: str = "") -> None:
        super().__init__((HOST, 0), _Handler, bind_and_activate=False)
        self.socket.close()
        self.socket = listening
        self.server_address = listening.getsockname()
        self.folder = folder
        self.token = token or new_token()
        self.follower = Follower(folder)
        self._tickets: dict[str, float] = {}
        self._lock = threading.Lock()
        self._strangers: dict[socket.socket, float] = {}
        self._holders: set[socket.socket] = set()

    @property
    def address(self) -> str:
        """Address of the page."""
        return address_of(self.socket, self.token)

    def add_ticket(self, ticket: str) -> None:
        """Let another secret lead to the page once, within a minute.

        A browser is started with it: other users of the machine can read commands.
        """
        self._tickets[ticket] = time.monotonic() + _TICKET_SECONDS

    def take_ticket(self, given: str) -> bool:
        """Return whether a ticket was good; it is not any more."""
        return self._tickets.pop(given, float("-inf")) > time.monotonic()

    @override
    def process_request(self, request: Any, client_address: Any) -> None:
        if self._has_place(request):
            super().process_request(request, client_address)
        else:
            self.shutdown_request(request)

    def _has_place(self, request: socket.socket) -> bool:
        """Return whether a client may send its request; the slowest one goes for it."""
        now = time.monotonic()
        with self._lock:
            oldest, since = next(iter(self._strangers.items()), (None, now))
            if len(self._strangers) >= _MOST_CONNECTIONS and oldest is not None:
                if now - since < _PATIENT_SECONDS:
                    return False
                self._send_away(oldest)
            self._strangers[request] = now
        return True

    def welcome(self, request: socket.socket) -> bool:
        """Give a client with the token a place that no stranger can take; False if none is free."""
        with self._lock:
            if len(self._holders) >= _MOST_CONNECTIONS:
                return False
            self._strangers.pop(request, None)
            self._holders.add(request)
        return True

    @override
    def service_actions(self) -> None:
        """Send away clients that have not sent their request in time, a few times a second."""
        late = time.monotonic() - _REQUEST_SECONDS
        with self._lock:
            for request in [one for one, since in self._strangers.items() if since < late]:
                self._send_away(request)

    def _send_away(self, request: socket.socket) -> None:
        del self._strangers[request]
        with suppress(OSError):
            request.shutdown(socket.SHUT_RDWR)

    @override
    def process_request_thread(self, request: Any, client_address: Any) -> None:
        try:
            super().process_request_thread(request, client_address)
        finally:
            with self._lock:
                self._strangers.pop(request, None)
                self._holders.discard(request)

    @override
    def handle_error(self, request: Any, client_address: Any) -> None:
        """Say nothing: mostly a browser has closed its connection."""


def new_token() -> str:
    """Return a secret that cannot be guessed."""
    return secrets.token_urlsafe(24)


def address_of(listening: socket.socket, token: str) -> str:
    """Return the address of a page."""
    return f"http://{HOST}:{listening.getsockname()[1]}/{token}/"


class _Handler(BaseHTTPRequestHandler):
    server: WatchServer
    timeout = _REQUEST_SECONDS
    server_version, sys_version = "grainfit", ""

    @override
    def log_message(self, format: str, *args: Any) -> None:
        """Write no log: it would have the token."""

    def do_GET(self) -> None:
        """Answer what only reads."""
        if not self._has_own_host():
            return
        path = urlsplit(self.path).path
        token, slash, rest = path.removeprefix("/").partition("/")
        if self.server.take_ticket(token):
            self._redirect(f"/{self.server.token}/")
        elif not self._is_token(token):
            self._refuse(HTTPStatus.NOT_FOUND, "There is no such page. Copy the whole address.")
        elif not self.server.welcome(self.connection):
            self._refuse_crowd()
        elif not slash:
            self._redirect(f"/{self.server.token}/")
        elif not rest:
            self._send_page()
        elif rest == "events":
            self._send_events()
        elif rest == "report":
            self._send_report()
        elif rest.startswith("drawing/"):
            self._send_drawing(rest.removeprefix("drawing/"))
        else:
            self._refuse(HTTPStatus.NOT_FOUND, "There is no such page.")

    def do_POST(self) -> None:
        """Stop the calibration: the only thing that can be changed from here."""
        if not self._has_own_host():
            return
        token, _, rest = self.path.removeprefix("/").partition("/")
        if not self._is_token(token) or rest != "stop":
            self._refuse(HTTPStatus.NOT_FOUND, "There is no such page.")
        elif self.headers.get("Origin") != f"http://{self.headers.get('Host')}":
            self._refuse(HTTPStatus.FORBIDDEN, "Only the page itself can stop the calibration.")
        elif not self.server.welcome(self.connection):
            self._refuse_crowd()
        else:
            self._stop()

    def _has_own_host(self) -> bool:
        """Refuse a request that was made under another name."""
        name, _, port = (self.headers.get("Host") or "").partition(":")
        if name in _NAMES and (not port or port.isdecimal()):
            return True
        self._refuse(HTTPStatus.FORBIDDEN, f"This page is at http://{HOST} only.")
        return False

    def _is_token(self, given: str) -> bool:
        return hmac.compare_digest(
            given.encode("utf-8", "surrogateescape"), self.server.token.encode()
        )

    def _stop(self) -> None:
        try:
            stop_calibration(self.server.folder)
        except CannotStopError as error:
            self._send(HTTPStatus.CONFLICT, _JSON, script_json({"why": str(error)}))
            return
        self._send(HTTPStatus.OK, _JSON, "{}")

    def _send_page(self) -> None:
        nonce = new_token()
        policy = {"Content-Security-Policy": _PAGE_POLICY.replace("NONCE", nonce)}
        self._send(HTTPStatus.OK, _HTML, watch_page(self.server.folder, nonce), policy)

    def _send_report(self) -> None:
        try:
            page = read_within(self.server.folder / REPORT_NAME, LARGEST_RESULT)
        except OSError:
            self._refuse(HTTPStatus.NOT_FOUND, "There is no report yet.")
            return
        policy = {"Content-Security-Policy": _REPORT_POLICY}
        self._send(HTTPStatus.OK, _HTML, page, policy)

    def _send_drawing(self, key: str) -> None:
        found = self.server.follower.drawing(key)
        if found is None:
            self._refuse(HTTPStatus.NOT_FOUND, "There are no such particles.")
        else:
            self._send(HTTPStatus.OK, _JSON, found)

    def _send_events(self) -> None:
        follower, seen = self.server.follower, 0
        self._begin(HTTPStatus.OK, "text/event-stream", {})
        with follower.watching(), suppress(OSError):
            while True:
                has_ended = follower.has_ended
                number, state = follower.wait(seen, _ALIVE_SECONDS)
                self.wfile.write(b": alive\n\n" if number == seen else _event(state))
                self.wfile.flush()
                if has_ended:
                    return
                seen = number

    def _redirect(self, to: str) -> None:
        self._begin(HTTPStatus.SEE_OTHER, _HTML, {"Location": to})

    def _refuse_crowd(self) -> None:
        self._refuse(HTTPStatus.SERVICE_UNAVAILABLE, "The page is open too many times.")

    def _refuse(self, status: HTTPStatus, words: str) -> None:
        self._send(status, "text/plain; charset=utf-8", f"{words}\n")

    def _send(
        self,
        status: HTTPStatus,
        kind: str,
        content: str | bytes,
        headers: dict[str, str] | None = None,
    ) -> None:
        body = content if isinstance(content, bytes) else content.encode(errors="replace")
        self._begin(status, kind, {"Content-Length": str(len(body)), **(headers or {})})
        self.wfile.write(body)

    def _begin(self, status: HTTPStatus, kind: str, headers: dict[str, str]) -> None:
        self.send_response(status)
        policy = {"Content-Security-Policy": _NOTHING}
        for name, value in {"Content-Type": kind, **_HEADERS, **policy, **headers}.items():
            self.send_header(name, value)
        self.end_headers()


def _event(state: str) -> bytes:
    return f"data: {state}\n\n".encode()


def serve(server: WatchServer) -> threading.Thread:
    """Follow the folder and answer requests, in threads of their own."""
    server.follower.start()
    thread = threading.Thread(
        target=partial(server.serve_forever, poll_interval=0.2), name="watch", daemon=True
    )
    thread.start()
    return thread
