"""A real PostgreSQL server for the tests, in a temporary folder, without root's rights."""

from __future__ import annotations

import os
import pwd
import shutil
import subprocess
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

_PROGRAMS = sorted(Path("/usr/lib/postgresql").glob("*/bin"))


def program(name: str) -> str | None:
    """Return the path of one of the server's programs, or None where it is not installed."""
    found = shutil.which(name)
    return found or (str(_PROGRAMS[-1] / name) if _PROGRAMS else None)


class PostgresqlServer:
    """A server that listens on a socket in a folder only.

    Parameters
    ----------
    folder : Path
        Made anew; its path must be short.
    """

    def __init__(self, folder: Path) -> None:
        user = "postgres" if os.getuid() == 0 else pwd.getpwuid(os.getuid()).pw_name
        folder.mkdir()
        self.url = f"postgresql+psycopg://{user}@/postgres?host={folder}"
        self._given: dict[str, Any] = {"check": True, "cwd": folder, "stdout": subprocess.DEVNULL}
        if os.getuid() == 0:
            # The server refuses to be run by root.
            shutil.chown(folder, user)
            self._given |= {"user": user, "group": user, "extra_groups": []}
        data = folder / "data"
        self._control = [program("pg_ctl"), "-D", data, "-w", "-l", folder / "server.log"]
        self._options = f"-k '{folder}' -c listen_addresses='' -c max_connections=60 -c fsync=off"
        command = [program("initdb"), "-D", data, "-U", user, "-A", "trust", "--no-sync"]
        subprocess.run(command, **self._given)

    def start(self) -> None:
        """Start it, and wait until it answers."""
        subprocess.run([*self._control, "-o", self._options, "start"], **self._given)

    def stop(self) -> None:
        """Stop it as a crash does."""
        subprocess.run([*self._control, "-m", "immediate", "stop"], **self._given)


@contextmanager
def postgresql_server() -> Iterator[PostgresqlServer]:
    """Start a server, and stop it at the end."""
    # The path of a socket must be short.
    with tempfile.TemporaryDirectory(prefix="pg") as folder:
        Path(folder).chmod(0o755)
        server = PostgresqlServer(Path(folder) / "server")
        server.start()
        try:
            yield server
        finally:
            server.stop()
