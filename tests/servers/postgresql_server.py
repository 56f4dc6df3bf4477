"""A real PostgreSQL server, as one in use: reached by TCP, with passwords, and with fsync."""

from __future__ import annotations

import os
import pwd
import secrets
import shutil
import socket
import subprocess
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Literal
from unittest.mock import patch

_PROGRAMS = sorted(Path("/usr/lib/postgresql").glob("*/bin"))
HOST = "127.0.0.1"


def program(name: str) -> str | None:
    """Return the path of one of the server's programs, or None where it is not installed."""
    found = shutil.which(name)
    return found or (str(_PROGRAMS[-1] / name) if _PROGRAMS else None)


class PostgresqlServer:
    """A server on this machine whose users need a password, which is in a password file.

    Parameters
    ----------
    folder : Path
        Folder to create; its path must be short.

    Attributes
    ----------
    port : int
        Its port on `HOST`.
    password : str
        Of the user.
    password_file : Path
        File for ``PGPASSFILE``, with the password for every port.
    log : Path
        What the server has written.
    """

    def __init__(self, folder: Path) -> None:
        self.user = "postgres" if os.getuid() == 0 else pwd.getpwuid(os.getuid()).pw_name
        self.password = secrets.token_hex(8)
        self.port = _free_port()
        folder.mkdir()
        self.log = folder / "server.log"
        self.password_file = folder.with_name("pgpass")
        self.password_file.touch(mode=0o600)
        self.password_file.write_text(f"{HOST}:*:*:{self.user}:{self.password}\n")
        given = folder / "password"
        given.write_text(self.password)
        self._given: dict[str, Any] = {"check": True, "cwd": folder, "stdout": subprocess.DEVNULL}
        if os.getuid() == 0:
            # The server refuses to be run by root.
            shutil.chown(folder, self.user)
            self._given |= {"user": self.user, "group": self.user, "extra_groups": []}
        data = folder / "data"
        self._control = [str(program("pg_ctl")), "-D", str(data), "-w", "-l", str(self.log)]
        self._options = (
            f"-k '{folder}' -p {self.port} -c listen_addresses={HOST} -c max_connections=60"
        )
        command = [str(program("initdb")), "-D", str(data), "-U", self.user]
        command += ["-A", "scram-sha-256", "--pwfile", str(given), "--no-sync"]
        subprocess.run(command, **self._given)

    @property
    def url(self) -> str:
        """Address of its database, without the password."""
        return self.url_at(self.port)

    def url_at(self, port: int) -> str:
        """Return the address through another port, such as that of a forwarder."""
        return f"postgresql+psycopg://{self.user}@{HOST}:{port}/postgres"

    def start(self) -> None:
        """Start it, and wait until it answers."""
        subprocess.run([*self._control, "-o", self._options, "start"], **self._given)

    def stop(self, mode: Literal["fast", "immediate"] = "immediate") -> None:
        """Stop it: in good order, or as a crash does."""
        subprocess.run([*self._control, "-m", mode, "stop"], **self._given)

    def cut_connections(self) -> int:
        """End all connections of clients; return their number."""
        import psycopg

        others = "pid <> pg_backend_pid() AND backend_type = 'client backend'"
        query = f"SELECT pg_terminate_backend(pid) FROM pg_stat_activity WHERE {others}"
        with psycopg.connect(
            host=HOST, port=self.port, user=self.user, password=self.password, dbname="postgres"
        ) as connection:
            return len(connection.execute(query).fetchall())


def _free_port() -> int:
    with socket.socket() as taken:
        taken.bind((HOST, 0))
        return int(taken.getsockname()[1])


@contextmanager
def postgresql_server() -> Iterator[PostgresqlServer]:
    """Start a server whose password this process and its children find, and stop it at the end."""
    # The path of a socket must be short.
    with tempfile.TemporaryDirectory(prefix="pg") as folder:
        Path(folder).chmod(0o755)
        server = PostgresqlServer(Path(folder) / "server")
        server.start()
        try:
            with patch.dict(os.environ, PGPASSFILE=str(server.password_file)):
                yield server
        finally:
            server.stop()
