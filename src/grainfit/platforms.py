"""What differs between operating systems: locks, open files, signals and processes.

Linux has all of it. Windows lacks the locks, signals, sessions and open folders of POSIX; macOS
lacks ``/proc``, descriptors of processes, and the list of cores of a process. Each function asks
what this Python has, not what the system is called, and does without what is missing.
"""

from __future__ import annotations

import errno
import os
import signal
import subprocess
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from functools import cache, partial
from pathlib import Path
from typing import IO, TYPE_CHECKING, Any

if TYPE_CHECKING:
    import psutil


def _module(name: str) -> Any:
    try:
        return __import__(name)
    except ImportError:
        return None


_fcntl, _msvcrt = _module("fcntl"), _module("msvcrt")
#: The same module, for names that only some systems have.
_os: Any = os
#: Whether processes are forked, and a child can be given open files by their numbers.
HAS_FORK = hasattr(os, "fork")
#: Whether a process can be interrupted that is no child of this one.
CAN_INTERRUPT = hasattr(os, "pidfd_open")
#: Windows lets nobody read what is locked; this byte is far behind the end of any signature.
_LOCKED_BYTE = 2**30
#: Time in which somebody who reads a file on Windows has closed it, s.
_READ_SECONDS = 2.0
#: Differs between machines and starts, and is the same in all containers of one. Only on Linux.
BOOT_ID = Path("/proc/sys/kernel/random/boot_id")


# --- files ---------------------------------------------------------------------------------------


def lock(file: IO[Any], *, shared: bool = False) -> None:
    """Lock an open file until it is closed or this process has ended.

    Raises
    ------
    BlockingIOError
        It is locked. On Windows a shared lock is exclusive as well.
    OSError
        It cannot be locked.
    """
    if _fcntl is not None:
        _fcntl.flock(file, (_fcntl.LOCK_SH if shared else _fcntl.LOCK_EX) | _fcntl.LOCK_NB)
        return
    os.lseek(file.fileno(), _LOCKED_BYTE, os.SEEK_SET)
    try:
        _msvcrt.locking(file.fileno(), _msvcrt.LK_NBLCK, 1)
    except PermissionError as error:
        raise BlockingIOError(errno.EAGAIN, "it is locked", file.name) from error


def try_record_lock(file: IO[Any]) -> None:
    """Lock and unlock a file by records, as SQLite does. Windows has one kind of lock only.

    Raises
    ------
    OSError
        It cannot be locked in this way.
    """
    if _fcntl is not None:
        _fcntl.lockf(file, _fcntl.LOCK_EX | _fcntl.LOCK_NB)
        _fcntl.lockf(file, _fcntl.LOCK_UN)


def touchable(file: IO[Any]) -> int | str:
    """Return what `os.utime` touches an open file by: its number, or its name on Windows."""
    return file.fileno() if os.utime in os.supports_fd else str(file.name)


def open_to_read(path: Path) -> int:
    """Open a file for reading, without waiting for the writer of a pipe."""
    names = ("O_NONBLOCK", "O_CLOEXEC", "O_BINARY")
    return os.open(path, os.O_RDONLY | sum(getattr(os, name, 0) for name in names))


def read_at(file: int, size: int, start: int) -> bytes:
    """Read a part of an open file and leave its position, which others may share."""
    if hasattr(os, "pread"):
        found: bytes = _os.pread(file, size, start)
        return found
    # Whoever writes at this moment writes at the wrong place: there is no other way on Windows.
    position = os.lseek(file, 0, os.SEEK_CUR)
    try:
        os.lseek(file, start, os.SEEK_SET)
        return os.read(file, size)
    finally:
        os.lseek(file, position, os.SEEK_SET)


def make_nonblocking(file: int) -> None:
    """Let nobody wait who reads an open pipe; not on Windows."""
    _os.set_blocking(file, False)


def write_to_disk(path: Path) -> None:
    """Wait until the contents of a file are on the disk."""
    # Windows refuses it for a file that is open for reading.
    with path.open("rb" if _msvcrt is None else "r+b") as file:
        os.fsync(file.fileno())


def replace(source: Path, target: Path) -> None:
    """Put a file in place of another one; on Windows, wait until nobody reads that one."""
    deadline = time.monotonic() + _READ_SECONDS
    while True:
        try:
            source.replace(target)
            return
        except PermissionError:
            if _msvcrt is None or time.monotonic() > deadline:
                raise
            time.sleep(0.02)


def set_space_aside(file: int, size: int) -> None:
    """Give an empty open file its space on the disk, bytes."""
    if hasattr(os, "posix_fallocate"):
        _os.posix_fallocate(file, 0, size)
        return
    while size > 0:
        size -= os.write(file, bytes(size))


class OpenFolder:
    """A folder that is kept open, so that no new folder gets its inode.

    On Windows a folder cannot be opened. There, it is only looked at.

    Parameters
    ----------
    path : Path
        The folder.

    Raises
    ------
    OSError
        There is no such folder.
    """

    def __init__(self, path: Path) -> None:
        self._descriptor: int | None = None
        if hasattr(os, "O_DIRECTORY"):
            self._descriptor = os.open(path, os.O_RDONLY | _os.O_DIRECTORY)
        found = path.stat() if self._descriptor is None else os.fstat(self._descriptor)
        #: What no other folder has that exists at the same time.
        self.identity = (found.st_dev, found.st_ino)

    def close(self) -> None:
        """Close the folder."""
        if self._descriptor is not None:
            os.close(self._descriptor)


# --- signals -------------------------------------------------------------------------------------


def signals(*names: str) -> tuple[signal.Signals, ...]:
    """Return the signals of these names that this system has."""
    return tuple(getattr(signal, name) for name in names if hasattr(signal, name))


#: The one that ends a process in any case.
STRONGEST_SIGNAL = signals("SIGTERM", "SIGKILL")[-1]


def send_to_itself(number: signal.Signals) -> None:
    """Send a signal to this process, from any thread."""
    # On Windows, os.kill would end the process.
    if HAS_FORK:
        os.kill(os.getpid(), number)
    else:
        signal.raise_signal(number)


@contextmanager
def pinned(process: int) -> Iterator[Callable[[signal.Signals], None]]:
    """Yield what sends a signal to a process, and not to a later one of the same number.

    Only where processes `CAN_INTERRUPT` each other.
    """
    try:
        descriptor = _os.pidfd_open(process)
    except OSError as error:
        if error.errno != errno.ENOSYS:
            raise
        # Linux before 5.3.
        yield partial(os.kill, process)
        return
    send: Any = signal
    try:
        yield partial(send.pidfd_send_signal, descriptor)
    finally:
        os.close(descriptor)


# --- processes -----------------------------------------------------------------------------------


def cores() -> int:
    """Return the number of cores that this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(_os.sched_getaffinity(0))
    return os.cpu_count() or 1


def is_root() -> bool:
    """Return whether this process has all rights on a POSIX system."""
    return hasattr(os, "geteuid") and _os.geteuid() == 0


def boot_id() -> str:
    """Return what this start of this machine is called; empty where it has no name."""
    with suppress(OSError):
        return BOOT_ID.read_text(encoding="ascii").strip()
    return ""


def after_fork_in_child(function: Callable[[], None]) -> None:
    """Call a function in every child that this process is forked into."""
    if HAS_FORK:
        _os.register_at_fork(after_in_child=function)


def apart() -> dict[str, Any]:
    """Return the options of `subprocess.Popen` for a process that Ctrl-C does not reach."""
    if HAS_FORK:
        return {"start_new_session": True}
    return {"creationflags": getattr(subprocess, "CREATE_NEW_PROCESS_GROUP", 0)}


def signal_group(leader: int, number: signal.Signals) -> None:
    """Send a signal to a process group; on Windows, end its leader and all descendants.

    Raises
    ------
    ProcessLookupError
        It has ended.
    PermissionError
        It belongs to another user.
    """
    if hasattr(os, "killpg"):
        _os.killpg(leader, number)
        return
    import psutil

    try:
        process = psutil.Process(leader)
        family = [process, *process.children(recursive=True)]
    except psutil.Error as error:
        raise ProcessLookupError(errno.ESRCH, "it has ended") from error
    for one in family:
        with suppress(psutil.Error):
            one.kill()


def is_of_this_user(process: psutil.Process) -> bool:
    """Return whether a process belongs to the user of this one.

    Raises
    ------
    psutil.Error
        It has ended, or its user may not be known.
    """
    if hasattr(os, "getuid"):
        return bool(process.uids().real == _os.getuid())
    return bool(process.username() == _user())


@cache
def _user() -> str:
    import psutil

    return str(psutil.Process().username())


def session_of(pid: int) -> int:
    """Return the session of a process; without sessions, each process has its own.

    Raises
    ------
    OSError
        It has ended.
    """
    return int(_os.getsid(pid)) if hasattr(os, "getsid") else pid


def start_of(pid: int) -> str:
    """Return boot and start of a process: in ticks on Linux, where clocks may jump.

    Raises
    ------
    OSError
        It has ended.
    """
    if boot := boot_id():
        after_name = Path(f"/proc/{pid}/stat").read_text(encoding="utf-8").rpartition(")")[2]
        # The fields after the name begin with the third; the start is the 22nd.
        return f"{boot} {after_name.split()[19]}"
    import psutil

    try:
        return f"{psutil.Process(pid).create_time():.2f}"
    except psutil.Error as error:
        raise ProcessLookupError(errno.ESRCH, "it has ended") from error
