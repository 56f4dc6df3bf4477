"""Show grainfit what Python has on another system; Python runs this file at its start.

Modules of grainfit get copies of standard modules without the names that are missing there,
according to the type stubs of the standard library. Other packages see Linux: they have code of
their own for every system. A lock of a range of bytes stands for that of Windows: it belongs to the
opened file, and ends with it or with the process.
"""

from __future__ import annotations

import builtins
import errno
import fcntl
import os
import signal
import struct
import subprocess
import sys
import time
from contextlib import suppress
from pathlib import Path
from types import FrameType, ModuleType
from typing import Any

from names_of_systems import folder_of, missing_on

#: As `sys.platform` has it there: win32 or darwin.
SYSTEM = os.environ["SYSTEM_OF_THE_TESTS"]


PACKAGE = folder_of("grainfit")
POSIX_ONLY = ("fcntl", "grp", "posix", "pty", "pwd", "readline", "resource", "syslog", "termios")
#: Modules of the standard library that read or find files for others.
_BETWEEN = tuple(os.sep + name for name in ("pathlib.py", "os.py", "glob.py", "tempfile.py"))


def copy_of(module: ModuleType) -> ModuleType:
    """Return a copy of a module without the names that it lacks there."""
    name = module.__name__
    missing = missing_on(SYSTEM, name)
    copy = ModuleType(name)
    vars(copy).update({key: one for key, one in vars(module).items() if key not in missing})
    return copy


copies: dict[str, Any] = {module.__name__: copy_of(module) for module in (os, signal, time)}


def _as_on_windows() -> None:
    def locking(file: int, mode: int, length: int) -> None:
        start = os.lseek(file, 0, os.SEEK_CUR)
        # Windows locks files that are open for reading, too.
        reads = fcntl.fcntl(file, fcntl.F_GETFL) & os.O_ACCMODE == os.O_RDONLY
        kind = fcntl.F_RDLCK if reads else fcntl.F_WRLCK
        try:
            fcntl.fcntl(
                file, fcntl.F_OFD_SETLK, struct.pack("hhqqi", kind, os.SEEK_SET, start, length, 0)
            )
        except BlockingIOError as error:
            raise PermissionError(errno.EACCES, "Permission denied") from error

    def open_file(path: Any, flags: int, mode: int = 0o777) -> int:
        if Path(path).is_dir():
            raise PermissionError(errno.EACCES, "Permission denied", os.fspath(path))
        return os.open(path, flags, mode)

    def fsync(file: int) -> None:
        if fcntl.fcntl(file, fcntl.F_GETFL) & os.O_ACCMODE == os.O_RDONLY:
            raise OSError(errno.EBADF, "Bad file descriptor")
        os.fsync(file)

    def kill(process: int, number: int) -> None:
        raise AssertionError("os.kill ends processes on Windows")

    class Popen(subprocess.Popen):  # type: ignore[type-arg]
        def __init__(self, *given: Any, creationflags: int = 0, **options: Any) -> None:
            assert not options.get("pass_fds"), "pass_fds not supported on Windows."
            assert not {"preexec_fn", "start_new_session"} & options.keys()
            super().__init__(*given, **options)

    windows = ModuleType("msvcrt")
    vars(windows).update(LK_NBLCK=2, locking=locking)
    copies["msvcrt"] = windows
    vars(copies["os"]).update(open=open_file, fsync=fsync, kill=kill, supports_fd=set())
    copies["subprocess"] = ModuleType("subprocess")
    vars(copies["subprocess"]).update(vars(subprocess))
    vars(copies["subprocess"]).update(Popen=Popen, CREATE_NEW_PROCESS_GROUP=0x200)


if SYSTEM == "win32":
    _as_on_windows()

_import = builtins.__import__


def find(name: str, *given: Any, **others: Any) -> Any:
    """Import a module, for grainfit one of the other system."""
    asking = ""
    # The interpreter itself has no frame.
    with suppress(ValueError):
        asking = sys._getframe(1).f_globals.get("__file__") or ""
    if asking.startswith(PACKAGE):
        if SYSTEM == "win32" and name in POSIX_ONLY:
            raise ModuleNotFoundError(f"No module named {name!r}", name=name)
        if name in copies:
            return copies[name]
    return _import(name, *given, **others)


def refuse_devices(event: str, given: tuple[Any, ...]) -> None:
    """Let grainfit open nothing below /proc and /dev, but the null device."""
    path = given[0] if event in ("open", "os.listdir", "os.scandir") and given else None
    if not isinstance(path, str) or not path.startswith(("/proc/", "/dev/")) or path == os.devnull:
        return
    frame: FrameType | None = sys._getframe(1)
    while frame is not None and frame.f_code.co_filename.endswith(_BETWEEN):
        frame = frame.f_back
    if frame is not None and frame.f_code.co_filename.startswith(PACKAGE):
        raise FileNotFoundError(errno.ENOENT, "No such file or directory", path)


builtins.__import__ = find
sys.addaudithook(refuse_devices)
