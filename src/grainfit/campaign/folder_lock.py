"""The lock of a work folder: one process at a time, on all machines that share the folder.

The file ``lock`` is locked by the kernel, which frees it when its process ends. Some shared file
systems keep the locks of every machine apart, though (NFS with ``nolock``, Lustre with
``localflock``, BeeGFS by default). The file is therefore signed with the process and its machine as
well, and touched every few seconds: a lock that is free, but signed and touched by another machine,
is in use.
"""

from __future__ import annotations

import errno
import os
import socket
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import TextIO

from grainfit import platforms
from grainfit.campaign import messages
from grainfit.errors import StoreError
from grainfit.files import is_irregular

#: `is_held` takes the lock for a moment; `hold` waits that long before it refuses.
_LOCK_SECONDS = 1.0
#: Interval of the heartbeat, and the time without one after which a process elsewhere has died.
_BEAT_SECONDS, _SILENT_SECONDS = 5.0, 20.0
_UNSUPPORTED = {errno.ENOLCK, errno.ENOSYS, errno.EOPNOTSUPP, errno.EINVAL}
_ANOTHER = (
    "Choose a folder on another file system (workdir; for runs on a cluster, one that the nodes "
    "share, such as the home folder)"
)
_MOVE = "Move it to another file system"
_held: set[TextIO] = set()


def _let_go() -> None:
    for file in _held:
        file.close()
    _held.clear()


# Workers of a pool are forked with all open files and outlive a process that is killed. They must
# not keep the lock.
platforms.after_fork_in_child(_let_go)


@contextmanager
def hold(folder: Path, *, is_only: bool = False) -> Iterator[None]:
    """Lock a work folder for this process.

    Parameters
    ----------
    folder : Path
        The work folder; it is created.
    is_only : bool
        Whether the command is for this folder alone, so that no other can be chosen.

    Raises
    ------
    StoreError
        The folder cannot be created, written or locked, or another process uses it.
    """
    path = folder / "lock"
    try:
        (folder / "runs").mkdir(parents=True, exist_ok=True)
        require_files(folder)
        file = path.open("a+", encoding="utf-8")
    except OSError as error:
        remedy = messages.MAKE_WRITABLE() if is_only else messages.ANOTHER_FOLDER()
        text = messages.FOLDER_UNUSABLE(folder=str(folder), reason=error.strerror, remedy=remedy)
        raise StoreError(text) from error
    with file:
        locked = _lock(file, folder, _MOVE if is_only else _ANOTHER)
        signature = Signature.read(path)
        if not locked:
            raise _in_use(folder, signature, is_only)
        if not signature.is_of_this_machine() and _is_touched(path):
            raise _in_use(folder, signature, is_only)
        _held.add(file)
        try:
            with _signed(file):
                yield
        finally:
            _held.discard(file)


def require_files(folder: Path) -> None:
    """Raise `StoreError` where a pipe, a socket or a device stands in place of a file.

    Whoever reads it would wait for somebody to write to it. A folder that cannot be listed is left
    to those who open its files: they say why.
    """
    try:
        paths = sorted(folder.iterdir())
    except OSError:
        return
    for path in filter(is_irregular, paths):
        raise StoreError(messages.NOT_A_FILE(path=str(path)))


def is_held(folder: Path) -> bool:
    """Return True if a process uses the folder now."""
    try:
        with (folder / "lock").open("r", encoding="utf-8") as file:
            platforms.lock(file, shared=True)
    except BlockingIOError:
        return True
    except OSError:
        return False
    return False


def holder(folder: Path) -> Signature:
    """Return the process that signed the lock of a folder last, also when it was killed."""
    return Signature.read(folder / "lock")


def last_heartbeat(folder: Path) -> int | None:
    """Return the time of the last heartbeat by the clock of the file system, ns; None without."""
    return _look(folder / "lock")


@dataclass(frozen=True)
class Signature:
    """Process that uses a folder, and its machine; empty when it has ended."""

    process: str = ""
    host: str = ""
    boot: str = ""

    @classmethod
    def own(cls) -> Signature:
        """Return the signature of this process."""
        return cls(str(os.getpid()), socket.gethostname(), platforms.boot_id())

    @classmethod
    def read(cls, path: Path) -> Signature:
        """Read the signature in a lock file; empty when there is none."""
        try:
            return cls(*path.read_text(encoding="utf-8").split()[:3])
        except (OSError, ValueError):
            return cls()

    def is_of_this_machine(self) -> bool:
        """Return whether the process is one of this machine since it was started."""
        # Versions before 0.2.0 sign without a machine.
        own = Signature.own()
        return not self.host or (self.host, self.boot) == (own.host, own.boot)

    def __str__(self) -> str:
        return self.process if self.is_of_this_machine() else f"{self.process} on {self.host}"


def _in_use(folder: Path, signature: Signature, is_only: bool) -> StoreError:
    remedy = messages.WAIT() if is_only else messages.WAIT_OR_ANOTHER()
    text = messages.FOLDER_IN_USE(folder=str(folder), process=signature, remedy=remedy)
    return StoreError(text)


def _lock(file: TextIO, folder: Path, remedy: str) -> bool:
    deadline = time.monotonic() + _LOCK_SECONDS
    while True:
        try:
            # SQLite would report a lock that is missing as busy. Tried first: NFS makes one kind of
            # lock of both, which is free again before the other one is taken.
            platforms.try_record_lock(file)
            platforms.lock(file)
            return True
        except BlockingIOError:
            if time.monotonic() > deadline:
                return False
            time.sleep(0.02)
        except OSError as error:
            path, reason = str(folder), error.strerror
            if error.errno not in _UNSUPPORTED:
                text = messages.NOT_LOCKED(folder=path, reason=reason, remedy=remedy)
            else:
                text = messages.NO_LOCKS(folder=path, reason=reason, remedy=remedy)
            raise StoreError(text) from error


def _is_touched(path: Path) -> bool:
    """Wait for a heartbeat; return False when there is none."""
    before = _look(path)
    deadline = time.monotonic() + _SILENT_SECONDS
    while time.monotonic() < deadline:
        time.sleep(0.2)
        if _look(path) != before:
            return True
    return False


def _look(path: Path) -> int | None:
    # Network file systems ask their server about a file when it is opened.
    try:
        with path.open("rb") as file:
            return os.fstat(file.fileno()).st_mtime_ns
    except OSError:
        return None


@contextmanager
def _signed(file: TextIO) -> Iterator[None]:
    own = Signature.own()
    _write(file, f"{own.process} {own.host} {own.boot}\n")
    ended = threading.Event()
    beat = threading.Thread(target=_beat, args=(platforms.touchable(file), ended), daemon=True)
    beat.start()
    try:
        yield
    finally:
        ended.set()
        beat.join()
        _write(file, "")


def _write(file: TextIO, text: str) -> None:
    """Replace the signature; errors (a full disk, closed by a fork) do not matter."""
    with suppress(OSError, ValueError):
        os.ftruncate(file.fileno(), 0)
        os.write(file.fileno(), text.encode())


def _beat(file: int | str, ended: threading.Event) -> None:
    while not ended.wait(_BEAT_SECONDS):
        with suppress(OSError):
            os.utime(file)
