"""A real PostgreSQL server for the tests, in a temporary folder, without root's rights."""

from __future__ import annotations

import os
import pwd
import shutil
import subprocess
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

_PROGRAMS = sorted(Path("/usr/lib/postgresql").glob("*/bin"))


def program(name: str) -> str | None:
    """Return the path of one of the server's programs, or None where it is not installed."""
    found = shutil.which(name)
    return found or (str(_PROGRAMS[-1] / name) if _PROGRAMS else None)


@contextmanager
def postgresql_server(folder: Path) -> Iterator[str]:
    """Start a server that listens on a socket in the folder only; yield the URL of a database."""
    user = "postgres" if os.getuid() == 0 else pwd.getpwuid(os.getuid()).pw_name
    data = folder / "data"
    folder.mkdir(parents=True, exist_ok=True)
    if os.getuid() == 0:
        shutil.chown(folder, user)
    run = {"check": True, "capture_output": True, "cwd": folder}
    if os.getuid() == 0:
        # The server refuses to be run by root.
        run |= {"user": user, "group": user, "extra_groups": []}
    subprocess.run([program("initdb"), "-D", data, "-U", user, "-A", "trust", "--no-sync"], **run)
    options = f"-k '{folder}' -c listen_addresses='' -c max_connections=60 -c fsync=off"
    control = [program("pg_ctl"), "-D", data, "-w", "-l", folder / "server.log"]
    subprocess.run([*control, "-o", options, "start"], **(run | {"capture_output": False}))
    try:
        yield f"postgresql+psycopg://{user}@/postgres?host={folder}"
    finally:
        subprocess.run([*control, "-m", "immediate", "stop"], **run)
