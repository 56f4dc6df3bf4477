"""Check during a run that its folder still exists and is writable."""

from __future__ import annotations

import errno
import os
import tempfile
from contextlib import suppress
from pathlib import Path
from types import TracebackType

from grainfit import platforms
from grainfit.solvers.process import messages
from grainfit.solvers.process.faults import machine_error

#: A disk with less free space than this is full.
_ROOM_BYTES = 65536


class RunFolder:
    """A folder, distinguished from any other folder that may later have the same path.

    Use it as a context manager. The folder stays open, because the file system could otherwise give
    its inode number to a new folder at the same path.

    Parameters
    ----------
    path : Path
        Existing folder.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self._opened = platforms.OpenFolder(path)

    def __enter__(self) -> RunFolder:
        """Return the folder."""
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        """Close the folder."""
        self._opened.close()

    def is_gone(self) -> bool:
        """Return True if the folder was removed, renamed, or replaced by another one."""
        # A network file system refreshes a folder when it is opened, not when it is looked up: to
        # notice a renamed folder, its parent must be opened, too.
        with suppress(OSError):
            platforms.OpenFolder(self.path.parent).close()
        try:
            found = platforms.OpenFolder(self.path)
        except OSError as error:
            # A server that does not answer for a while has not lost the folder.
            return error.errno in (errno.ENOENT, errno.ENOTDIR, errno.ESTALE)
        found.close()
        return found.identity != self._opened.identity

    def fault(self) -> str:
        """Return the reason why the folder is not writable, in one line; empty if it is."""
        if self.is_gone():
            return messages.FOLDER_REMOVED()
        try:
            self._write()
        except OSError as error:
            return machine_error(error) or messages.FOLDER_READ_ONLY(reason=error.strerror)
        return ""

    def _write(self) -> None:
        file, name = tempfile.mkstemp(dir=self.path, prefix=".room")
        try:
            platforms.set_space_aside(file, _ROOM_BYTES)
            # Some file systems report a full disk only now.
            os.fsync(file)
        finally:
            os.close(file)
            Path(name).unlink()
