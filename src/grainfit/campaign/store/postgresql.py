"""Connections to PostgreSQL that wait for no server forever, and let no other process wait so."""

from __future__ import annotations

import time
from collections.abc import Generator
from typing import Any

import psycopg
from psycopg import waiting

from grainfit.campaign import messages

#: Longest wait for a connection, and for the next bytes of an answer, s.
CONNECT_SECONDS = 10
SILENCE_SECONDS = 10.0
#: Both for a user who has interrupted the calibration, s; the driver waits no less to connect.
_HURRY_SECONDS = 2
#: Time after which the server ends a transaction whose process does nothing: it may have been
#: suspended, or its host lost, and keeps rows locked. Shorter than the patience of those that wait.
_IDLE_SECONDS = 5
_LOOK_SECONDS = 0.1


class Connector:
    """Maker of the connections of one store.

    Attributes
    ----------
    silence_seconds : float
        Longest wait for the next bytes of an answer.
    """

    def __init__(self) -> None:
        self.silence_seconds = SILENCE_SECONDS
        self._hurries = False

    def hurry(self) -> None:
        """Wait hardly any longer, also for answers that are being waited for."""
        self.silence_seconds = _HURRY_SECONDS
        self._hurries = True

    def connect(
        self, _dialect: Any, _record: Any, arguments: list[str], options: dict[str, Any]
    ) -> ImpatientConnection:
        """Connect; called by SQLAlchemy in place of the driver's own function."""
        # The driver gives bytes, not text, for a database without an encoding (SQL_ASCII).
        own = {"connect_timeout": CONNECT_SECONDS, "client_encoding": "utf8"}
        given = {**own, **options, "autocommit": True}
        if self._hurries:
            given["connect_timeout"] = _HURRY_SECONDS
        connection = ImpatientConnection.connect(*arguments, **given)
        connection.connector = self
        try:
            connection.execute(f"SET idle_in_transaction_session_timeout = '{_IDLE_SECONDS}s'")
            connection.autocommit = False
        except BaseException:
            connection.close()
            raise
        return connection


class ImpatientConnection(psycopg.Connection[Any]):
    """A connection that is closed when the server is silent for too long, or at an interrupt.

    The operating system notices neither a server that hangs nor one behind a proxy or a tunnel
    whose far end is lost, and takes many minutes to notice a broken network.
    """

    connector: Connector | None = None

    def wait(self, gen: Any, interval: float = _LOOK_SECONDS, timeout: float | None = None) -> Any:
        """Wait for an answer; psycopg calls this for every exchange with the server."""
        # Psycopg 3.2 knows no time-out, and its later versions use it for notifications alone.
        more: dict[str, Any] = {} if timeout is None else {"timeout": timeout}
        try:
            return waiting.wait(
                self._unless_silent(gen), self.pgconn.socket, interval=interval, **more
            )
        except (KeyboardInterrupt, SystemExit):
            # psycopg would ask the server to stop, and wait until it has.
            self.close()
            raise

    def _unless_silent(self, gen: Any) -> Generator[Any, Any, Any]:
        heard = time.monotonic()
        try:
            wanted = next(gen)
            while True:
                ready = yield wanted
                now = time.monotonic()
                if ready:
                    heard = now
                limit = self.connector.silence_seconds if self.connector else SILENCE_SECONDS
                if now - heard > limit:
                    self.close()
                    raise psycopg.OperationalError(messages.NO_REPLY(seconds=limit))
                wanted = gen.send(ready)
        except StopIteration as end:
            return end.value
