"""A forwarder of TCP connections that can cut them, and swallow what they carry."""

from __future__ import annotations

import selectors
import socket
import struct
import threading
from collections.abc import Iterator
from contextlib import contextmanager, suppress

_HOST = "127.0.0.1"
_LOOK_SECONDS = 0.02
_PIECE = 65536
#: Closing a socket with this option sends RST instead of FIN.
_RESET = struct.pack("ii", 1, 0)


class TcpForwarder:
    """A listening port whose connections are passed on to another port of this machine.

    Parameters
    ----------
    port : int
        Port to which connections are passed on.

    Attributes
    ----------
    port : int
        Port that listens.
    swallows : bool
        Whether nothing that arrives is passed on, as behind a tunnel whose far end is lost: the
        operating system of either end notices nothing.
    """

    def __init__(self, port: int) -> None:
        self._target = port
        self._listening = socket.create_server((_HOST, 0))
        self.port = int(self._listening.getsockname()[1])
        self.swallows = False
        self._to_cut = threading.Event()
        self._cut = threading.Event()
        self._ended = False
        self._others: dict[socket.socket, socket.socket] = {}
        self._selector = selectors.DefaultSelector()
        self._selector.register(self._listening, selectors.EVENT_READ)
        self._thread = threading.Thread(target=self._forward, daemon=True)
        self._thread.start()

    def cut(self) -> int:
        """Reset all connections, and return their number; new ones are accepted."""
        count = len(self._others) // 2
        self._cut.clear()
        self._to_cut.set()
        self._cut.wait()
        return count

    def close(self) -> None:
        """Reset all connections, and listen no longer."""
        self._ended = True
        self._thread.join()

    def _forward(self) -> None:
        while not self._ended:
            if self._to_cut.is_set():
                self._to_cut.clear()
                self._reset_all()
                self._cut.set()
            for key, _ in self._selector.select(_LOOK_SECONDS):
                if self._to_cut.is_set():
                    break
                if key.fileobj is self._listening:
                    self._accept()
                elif not self.swallows and isinstance(key.fileobj, socket.socket):
                    self._pass_on(key.fileobj)
            if self.swallows:
                # What is not read stays ready, and would keep this thread busy.
                self._to_cut.wait(_LOOK_SECONDS)
        self._reset_all()
        self._listening.close()
        self._selector.close()

    def _accept(self) -> None:
        accepted, _ = self._listening.accept()
        try:
            target = socket.create_connection((_HOST, self._target))
        except OSError:
            _reset(accepted)
            return
        for one, other in ((accepted, target), (target, accepted)):
            self._others[one] = other
            self._selector.register(one, selectors.EVENT_READ)

    def _pass_on(self, source: socket.socket) -> None:
        other = self._others.get(source)
        if other is None:
            return
        try:
            received = source.recv(_PIECE)
            if received:
                other.sendall(received)
                return
        except OSError:
            pass
        self._drop(source)

    def _drop(self, one: socket.socket) -> None:
        for end in (one, self._others.pop(one)):
            self._others.pop(end, None)
            with suppress(KeyError):
                self._selector.unregister(end)
            _reset(end)

    def _reset_all(self) -> None:
        while self._others:
            self._drop(next(iter(self._others)))


def _reset(end: socket.socket) -> None:
    with suppress(OSError):
        end.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, _RESET)
    end.close()


@contextmanager
def tcp_forwarder(port: int) -> Iterator[TcpForwarder]:
    """Forward connections to a port of this machine, and end them at the end."""
    forwarder = TcpForwarder(port)
    try:
        yield forwarder
    finally:
        forwarder.close()
