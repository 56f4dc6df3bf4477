"""Line-buffered output of programs, so that an abort does not lose the reason for it."""

from __future__ import annotations

import shutil
import subprocess
from collections.abc import Mapping
from functools import cache
from types import MappingProxyType

#: Variables by which ``stdbuf`` of GNU coreutils, or of its relatives, controls a program.
_PREFIX = "_STDBUF_"
_LIBRARY = "LD_PRELOAD"
_SECONDS = 10.0


@cache
def line_buffering() -> Mapping[str, str]:
    """Return environment variables that make programs write every line of output at once.

    The C library collects the output to a file in blocks, and a program that aborts, such as
    LIGGGHTS with an error, loses the last block: the one with the reason. The variables are those
    of ``stdbuf -oL``; the program itself is started without it, so that messages and exit codes
    remain its own. Python does not use the C library for its output, and has its own variable.
    """
    return MappingProxyType({"PYTHONUNBUFFERED": "1", **_of_stdbuf()})


def _of_stdbuf() -> dict[str, str]:
    stdbuf, env = shutil.which("stdbuf"), shutil.which("env")
    if stdbuf is None or env is None:
        return {}
    try:
        done = subprocess.run(
            [stdbuf, "-oL", env, "-0"], capture_output=True, check=True, timeout=_SECONDS
        )
    except (OSError, subprocess.SubprocessError):
        return {}
    pairs = (entry.partition("=") for entry in done.stdout.decode(errors="replace").split("\0"))
    return {name: value for name, _, value in pairs if name == _LIBRARY or name.startswith(_PREFIX)}
