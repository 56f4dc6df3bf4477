"""Names under which processes claim runs in a store that several of them share.

Every start has a random name of its own: host names and paths are the same in many containers. The
work folder keeps the latest one, so that the next start can release what a dead process was making.
A copy of the folder has the name, too, but is another folder, and the original may be in use.
"""

from __future__ import annotations

import json
import socket
import uuid
from contextlib import suppress
from pathlib import Path
from typing import Any

from grainfit import platforms
from grainfit.files import write_atomically

OWNER_NAME = "owner"


def earlier_owner(folder: Path) -> str | None:
    """Return the name of the previous process of a work folder; None in a copy of the folder.

    Parameters
    ----------
    folder : Path
        The work folder, locked by this process: the previous one has ended.
    """
    try:
        found = json.loads((folder / OWNER_NAME).read_text(encoding="utf-8"))
        name, place = found["name"], found["place"]
    except (OSError, ValueError, KeyError, TypeError):
        return None
    here = _place(folder)
    return name if isinstance(name, str) and here is not None and place == here else None


def new_owner(folder: Path | None) -> str:
    """Return a name for a process that uses this work folder."""
    return f"{socket.gethostname()}:{folder or ''} {uuid.uuid4()}"


def note_owner(folder: Path, name: str) -> None:
    """Note the name of the process that uses a work folder, for the next start."""
    # Without the note, the next start waits until the claims of this one have expired.
    with suppress(OSError):
        noted = {"name": name, "place": _place(folder)}
        write_atomically(folder / OWNER_NAME, json.dumps(noted))


def _place(folder: Path) -> list[Any] | None:
    """Return what only this folder has on all machines, until the machine starts again."""
    boot = platforms.boot_id()
    try:
        found = folder.stat()
    except OSError:
        return None
    return [boot, found.st_dev, found.st_ino] if boot else None
