"""Serve a page on this machine alone, to whoever has its address.

Every address begins with a random token, because other users of the machine can reach the port. It
is a part of the path, not a cookie, which a browser would send to every port of the host. No name
of a file is ever taken from an address.
"""

from __future__ import annotations

import hmac
import json
import secrets
import socket
import threading
import time
from collections.abc import Callable
from contextlib import suppress
from functools import partial
from http import HTTPStatus
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from typing import Any, ClassVar, TypeVar
from urllib.parse import urlsplit

from typing_extensions import override

from grainfit.errors import InputError
from grainfit.local_pages import messages

Found = TypeVar("Found")
HOST = "127.0.0.1"
#: Names by which a browser on this machine, or at the end of a tunnel, calls it. A page of another
#: site reaches the port under its own name only (DNS rebinding).
_NAMES = ("127.0.0.1", "localhost")
JSON, HTML = "application/json", "text/html; charset=utf-8"
#: Time in which a client has to send its request, and after which one that has not gives its place
#: to another when there is no free one.
_REQUEST_SECONDS, _PATIENT_SECONDS = 10.0, 1.0
#: Connections of those who have the token, and of those who have not sent it yet.
_MOST_CONNECTIONS = 64
#: Time for which the address of `LocalServer.add_ticket` holds, s.
_TICKET_SECONDS = 60.0
#: Longest body of a request, bytes.
_LONGEST_BODY = 200_000
_HEADERS = {
    "Cache-Control": "no-store",
    "Referrer-Policy": "no-referrer",
    "X-Content-Type-Options": "nosniff",
    "X-Frame-Options": "DENY",
    "Cross-Origin-Resource-Policy": "same-origin",
    "Cross-Origin-Opener-Policy": "same-origin",
}
_NOTHING = "default-src 'none'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'"


def listen(port: int) -> socket.socket:
    """Return a socket that listens on this machine alone; port 0 is any that is free.

    Raises
    ------
    InputError
        The port cannot be used.
    """
    listening = socket.socket()
    # On Windows, SO_REUSEADDR would let another process listen on the same port.
    alone = getattr(socket, "SO_EXCLUSIVEADDRUSE", socket.SO_REUSEADDR)
    listening.setsockopt(socket.SOL_SOCKET, alone, 1)
    try:
        listening.bind((HOST, port))
        listening.listen()
    except OSError as error:
        listening.close()
        fault = messages.PORT_TAKEN.fault("port", port=port, reason=error.strerror)
        raise InputError(fault) from error
    return listening


class LocalServer(ThreadingHTTPServer):
    """Server of one page.

    Parameters
    ----------
    handler : type of LocalHandler
        Answers requests.
    listening : socket
        From `listen`.
    token : str, optional
        Secret part of the address; a random one by default.
    """

    daemon_threads = True
    block_on_close = False

    def __init__(
        self, handler: type[LocalHandler], listening: socket.socket, token: str = ""
    ) -> None:
        super().__init__((HOST, 0), handler, bind_and_activate=False)
        self.socket.close()
        self.socket = listening
        self.server_address = listening.getsockname()
        self.token = token or new_token()
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

    def serve(self) -> threading.Thread:
        """Answer requests in a thread of their own."""
        thread = threading.Thread(
            target=partial(self.serve_forever, poll_interval=0.2), name="page", daemon=True
        )
        thread.start()
        return thread


def new_token() -> str:
    """Return a secret that cannot be guessed."""
    return secrets.token_urlsafe(24)


def address_of(listening: socket.socket, token: str) -> str:
    """Return the address of a page."""
    return f"http://{HOST}:{listening.getsockname()[1]}/{token}/"


class LocalHandler(BaseHTTPRequestHandler):
    """Answers those who have the token; a page of its own says what is below it."""

    server: LocalServer
    timeout = _REQUEST_SECONDS
    server_version, sys_version = "grainfit", ""
    #: What may be changed from the page: the addresses that it may post to.
    posts: ClassVar[tuple[str, ...]] = ()

    def answer(self, rest: str) -> None:
        """Answer what only reads: the address below the token."""
        raise NotImplementedError

    def change(self, rest: str) -> None:
        """Answer what changes something: one of `posts`."""
        raise NotImplementedError

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
            self.refuse(HTTPStatus.NOT_FOUND, "There is no such page. Copy the whole address.")
        elif not self.server.welcome(self.connection):
            self._refuse_crowd()
        elif not slash:
            self._redirect(f"/{self.server.token}/")
        else:
            self.answer(rest)

    def do_POST(self) -> None:
        """Change what can be changed from here."""
        if not self._has_own_host():
            return
        token, _, rest = self.path.removeprefix("/").partition("/")
        if not self._is_token(token) or rest not in self.posts:
            self.refuse_page()
        elif self.headers.get("Origin") != f"http://{self.headers.get('Host')}":
            self.refuse(HTTPStatus.FORBIDDEN, "Only the page itself can do this.")
        elif not self.server.welcome(self.connection):
            self._refuse_crowd()
        else:
            self.change(rest)

    def body(self, longest: int = _LONGEST_BODY) -> bytes | None:
        """Return the body of a request, or refuse it if it has more bytes than the longest."""
        length = self.headers.get("Content-Length", "")
        if length.isdecimal() and int(length) <= longest:
            return self.rfile.read(int(length))
        self.refuse(HTTPStatus.REQUEST_ENTITY_TOO_LARGE, "This is too much.")
        return None

    def json_body(self, read: Callable[[Any], Found], longest: int = _LONGEST_BODY) -> Found | None:
        """Return what JSON in the body of a request is read as, or refuse it.

        Parameters
        ----------
        read : callable
            Raises `ValueError` for what it cannot read.
        longest : int
            Longest body, bytes.
        """
        body = self.body(longest)
        if body is None:
            return None
        try:
            return read(json.loads(body))
        except (ValueError, RecursionError) as error:
            self.refuse(HTTPStatus.BAD_REQUEST, str(error))
            return None

    def send_page(self, page: Callable[[str], str], images: str) -> None:
        """Send a page with a nonce of its own, by which alone its scripts and styles are used."""
        nonce = new_token()
        policy = (
            f"{_NOTHING}; script-src 'nonce-{nonce}'; style-src 'nonce-{nonce}'; "
            f"img-src {images}; connect-src 'self'"
        )
        self.send(HTTPStatus.OK, HTML, page(nonce), {"Content-Security-Policy": policy})

    def refuse_page(self) -> None:
        """Say that there is nothing at an address."""
        self.refuse(HTTPStatus.NOT_FOUND, "There is no such page.")

    def _has_own_host(self) -> bool:
        """Refuse a request that was made under another name."""
        name, _, port = (self.headers.get("Host") or "").partition(":")
        if name in _NAMES and (not port or port.isdecimal()):
            return True
        self.refuse(HTTPStatus.FORBIDDEN, f"This page is at http://{HOST} only.")
        return False

    def _is_token(self, given: str) -> bool:
        return hmac.compare_digest(
            given.encode("utf-8", "surrogateescape"), self.server.token.encode()
        )

    def _redirect(self, to: str) -> None:
        self.begin(HTTPStatus.SEE_OTHER, HTML, {"Location": to})

    def _refuse_crowd(self) -> None:
        self.refuse(HTTPStatus.SERVICE_UNAVAILABLE, "The page is open too many times.")

    def refuse(self, status: HTTPStatus, words: str) -> None:
        """Answer in words."""
        self.send(status, "text/plain; charset=utf-8", f"{words}\n")

    def send(
        self,
        status: HTTPStatus,
        kind: str,
        content: str | bytes,
        headers: dict[str, str] | None = None,
    ) -> None:
        """Send an answer."""
        body = content if isinstance(content, bytes) else content.encode(errors="replace")
        self.begin(status, kind, {"Content-Length": str(len(body)), **(headers or {})})
        self.wfile.write(body)

    def begin(self, status: HTTPStatus, kind: str, headers: dict[str, str]) -> None:
        """Send the head of an answer."""
        self.send_response(status)
        policy = {"Content-Security-Policy": _NOTHING}
        for name, value in {"Content-Type": kind, **_HEADERS, **policy, **headers}.items():
            self.send_header(name, value)
        self.end_headers()
