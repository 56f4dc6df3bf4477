"""The folder of a run, watched while the run happens: is it still there, and is there room?"""

from __future__ import annotations

import errno
import os
import tempfile
from contextlib import suppress
from pathlib import Path
from types import TracebackType

from grainfit.solvers.process.faults import machine_error

REMOVED = "its folder was removed while it ran"
#: A disk with less room than this is full.
_ROOM_BYTES = 65536
_READ = os.O_RDONLY | os.O_DIRECTORY


class RunFolder:
    """A folder that is told from any other that may later be found at its path.

    It is a context manager: the folder is held open meanwhile, or else the file system could give
    its number to a folder that is made in its place.

    Parameters
    ----------
    path : Path
        Exists.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self._descriptor = os.open(path, _READ)
        self._identity = _identity(self._descriptor)

    def __enter__(self) -> RunFolder:
        """Return the folder."""
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        """Let the folder go."""
        os.close(self._descriptor)

    def is_gone(self) -> bool:
        """Whether the folder was removed or renamed, also if another one has taken its place."""
        # A network file system asks its server anew when a folder is opened, not when it is looked
        # up: for a folder that was renamed the one above must be opened too.
        with suppress(OSError):
            os.close(os.open(self.path.parent, _READ))
        try:
            found = os.open(self.path, _READ)
        except OSError as error:
            # A server that does not answer for a while has not lost the folder.
            return error.errno in (errno.ENOENT, errno.ENOTDIR, errno.ESTALE)
        try:
            return _identity(found) != self._identity
        finally:
            os.close(found)

    def fault(self) -> str:
        """Return why nothing can be written here, in one line; empty when something can."""
        if self.is_gone():
            return REMOVED
        try:
            self._write()
        except OSError as error:
            return machine_error(error) or f"its folder cannot be written: {error.strerror}"
        return ""

    def _write(self) -> None:
        file, name = tempfile.mkstemp(dir=self.path, prefix=".room")
        try:
            os.posix_fallocate(file, 0, _ROOM_BYTES)
            # Some file systems notice only now.
            os.fsync(file)
        finally:
            os.close(file)
            Path(name).unlink()


def _identity(descriptor: int) -> tuple[int, int]:
    found = os.fstat(descriptor)
    return found.st_dev, found.st_ino
