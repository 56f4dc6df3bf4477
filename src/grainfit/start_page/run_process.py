"""The calibration that the page starts: ``grainfit run FILE`` in a process of its own."""

from __future__ import annotations

import subprocess
import sys
import tempfile
from pathlib import Path

from grainfit import platforms
from grainfit.files import end_of_file

#: Last part of what the process said that is shown, characters.
_TAIL = 4000


class RunProcess:
    """A calibration that goes on when the page ends.

    Parameters
    ----------
    file : Path
        The calibration file.
    *options : str
        Further ones of the command.

    Raises
    ------
    OSError
        No process can be started.
    """

    def __init__(self, file: Path, *options: str) -> None:
        self._said = tempfile.TemporaryFile()  # noqa: SIM115  # as long as the page
        self._process = subprocess.Popen(
            [sys.executable, "-P", "-m", "grainfit", "run", str(file), *options],
            stdin=subprocess.DEVNULL,
            stdout=self._said,
            stderr=subprocess.STDOUT,
            # Ctrl-C ends the page, not the calibration.
            **platforms.apart(),
        )

    @property
    def code(self) -> int | None:
        """Exit code; None while it runs."""
        return self._process.poll()

    def tail(self) -> str:
        """Return the end of what it printed."""
        return end_of_file(self._said.fileno())[-_TAIL:].strip()
