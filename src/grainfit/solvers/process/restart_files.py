"""Restart files in the folder of a run: the solver's own, and what is known of each.

A solver writes ``restart.0`` and ``restart.1`` in turn, and after each of them ``restart.N.state``,
which says where in the run it was written. So one of the two is complete at any moment.
"""

from __future__ import annotations

from contextlib import suppress
from pathlib import Path

_FILES, _STATES = "restart.*", "restart.*.state"


def restart_states(folder: Path) -> list[Path]:
    """Return the files that say where restart files were written."""
    return sorted(folder.glob(_STATES))


def remove_restart_files(folder: Path) -> None:
    """Remove the restart files of a run that has ended."""
    for path in folder.glob(_FILES):
        with suppress(OSError):
            path.unlink()
