"""Names that Windows or macOS lacks are in one module."""

from __future__ import annotations

import re
import sys
from pathlib import Path

import pytest

from tests.portability.elsewhere.names_of_systems import missing_on

PACKAGE = Path(__file__).parents[2] / "src" / "grainfit"
MODULES = ("os", "signal", "time")
#: A name of one of these modules, or the import of a module that only POSIX has.
NAME = re.compile(
    r"\b((?:os|signal|time)\.\w+)|^\s*(?:import|from) (fcntl|grp|pwd|pty|resource|termios)\b",
    re.MULTILINE,
)
#: The program has no package beside it. Jobs of clusters are for Linux.
APART = {"platforms.py", "solvers/own_model/fill_templates.py"}


@pytest.mark.skipif(sys.platform != "linux", reason="the names are those that Linux has more")
def test_no_other_module_has_names_that_a_system_lacks() -> None:
    missing = {
        f"{module}.{name}"
        for system in ("win32", "darwin")
        for module in MODULES
        for name in missing_on(system, module)
    }
    assert {"os.fork", "os.sched_getaffinity", "signal.SIGKILL"} <= missing
    found = {
        f"{path.relative_to(PACKAGE)}: {name or imported}"
        for path in PACKAGE.rglob("*.py")
        if path.relative_to(PACKAGE).as_posix() not in APART and "cluster" not in path.parts
        for name, imported in NAME.findall(path.read_text(encoding="utf-8"))
        if imported or name in missing
    }
    assert found == set()
