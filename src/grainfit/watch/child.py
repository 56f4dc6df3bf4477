"""The page of a running command, served by a process of its own that ends with the command.

A process, not a thread: reading, metamodels and whoever reaches the port can neither slow down the
calibration nor take it with them.
"""

from __future__ import annotations

import json
import os
import signal
import socket
import subprocess
import sys
import time
from contextlib import suppress
from pathlib import Path

from grainfit import platforms
from grainfit.local_pages.server import HOST, listen
from grainfit.watch.server import WatchServer

_LOOK_SECONDS = 0.5
#: Longest time to wait for the page where the process has to open its port itself, s.
_START_SECONDS = 60.0
#: Time for browsers to receive the last state, s.
_FAREWELL_SECONDS = 2.0


class WatchProcess:
    """The process that serves the page, as its command sees it.

    Parameters
    ----------
    folder : Path
        The work folder.
    listening : socket
        From `grainfit.local_pages.server.listen`; it is handed over.
    token : str
        Secret part of the address.
    ticket : str
        Secret part of an address that leads to the page once.
    """

    def __init__(self, folder: Path, listening: socket.socket, token: str, ticket: str) -> None:
        port = listening.getsockname()[1]
        # Windows passes no sockets: the process listens on the port as soon as it is free.
        passed = [listening.fileno()] if platforms.HAS_FORK else []
        with listening:
            self._process = subprocess.Popen(
                [sys.executable, "-P", "-m", "grainfit.watch.child", *map(str, passed)],
                stdin=subprocess.PIPE,
                stdout=subprocess.DEVNULL,
                stderr=subprocess.DEVNULL,
                pass_fds=passed,
                # Ctrl-C is for the calibration; the page shows how it ends.
                **platforms.apart(),
            )
        # Other users can read the arguments of a process, but not this.
        given = {"folder": str(folder.absolute()), "token": token, "ticket": ticket, "port": port}
        self._say(json.dumps(given | {"parent": os.getpid()}))
        if not passed:
            self._wait_until_it_listens(port)

    def end(self) -> None:
        """Let the process show the last state, and end on its own."""
        if self._process.stdin is not None:
            with suppress(OSError):
                self._process.stdin.close()

    def _wait_until_it_listens(self, port: int) -> None:
        deadline = time.monotonic() + _START_SECONDS
        while time.monotonic() < deadline and self._process.poll() is None:
            with suppress(OSError):
                socket.create_connection((HOST, port), _LOOK_SECONDS).close()
                return

    def _say(self, line: str) -> None:
        assert self._process.stdin is not None, "it has a pipe"
        with suppress(OSError):
            self._process.stdin.write(f"{line}\n".encode())
            self._process.stdin.flush()


def main() -> None:
    """Serve the page until the command has ended."""
    for number in platforms.signals("SIGINT", "SIGHUP"):
        signal.signal(number, signal.SIG_IGN)
    given = json.loads(sys.stdin.readline())
    folder = Path(given["folder"])
    passed = sys.argv[1:]
    listening = socket.socket(fileno=int(passed[0])) if passed else listen(given["port"])
    server = WatchServer(folder, listening, given["token"])
    server.add_ticket(given["ticket"])
    server.serve()
    _wait_for_end(int(given["parent"]))
    server.follower.end()
    deadline = time.monotonic() + _FAREWELL_SECONDS
    while server.follower.watchers and time.monotonic() < deadline:
        time.sleep(0.05)
    # Threads that still answer would delay the end.
    os._exit(0)


def _wait_for_end(parent: int) -> None:
    """Wait until the command closes its pipe, or is gone while a worker keeps it open."""
    if not platforms.HAS_FORK:
        # No worker can have the pipe, and pipes of Windows are read only by waiting.
        while os.read(0, 1024):
            pass
        return
    platforms.make_nonblocking(0)
    while os.getppid() == parent:
        try:
            if os.read(0, 1024) == b"":
                return
        except BlockingIOError:
            time.sleep(_LOOK_SECONDS)


if __name__ == "__main__":
    main()
