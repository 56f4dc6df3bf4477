"""LIGGGHTS-PUBLIC."""

from __future__ import annotations

import shutil
from collections.abc import Mapping
from pathlib import Path
from typing import ClassVar

from typing_extensions import override

from grainfit import platforms
from grainfit.bulk_tests.base import BulkTest
from grainfit.errors import InputError, RunFailedError, SolverNotFoundError
from grainfit.materials.walls import plain_name
from grainfit.messages import Message
from grainfit.scenes.scene import Scene
from grainfit.solvers.dem import messages
from grainfit.solvers.dem.deck import SceneDeck
from grainfit.solvers.dem.liggghts.empty_box import REFUSALS, EmptyBox
from grainfit.solvers.dem.liggghts.restarting_deck import LiggghtsRestartingDeck
from grainfit.solvers.dem.liggghts.scene_deck import MISSING, LiggghtsSceneDeck
from grainfit.solvers.dem.program import DeckSolver
from grainfit.solvers.dem.restarting_deck import RestartingDeck
from grainfit.solvers.speed import Speed

_RESTITUTIONS = ("particle_particle.restitution", "particle_wall.restitution")
_REFUSED_RESTITUTION = 0.05


class Liggghts(DeckSolver):
    """LIGGGHTS-PUBLIC, ``liggghts`` on the PATH; see `DeckSolver`."""

    name = "liggghts"
    title: ClassVar[str] = "LIGGGHTS"
    usual_name: ClassVar[str] = "liggghts"
    install: ClassVar[str] = "Install it with: apt-get install liggghts"
    version_pattern: ClassVar[str] = r"LIGGGHTS \(Version ([^,)]+)"
    _own_log: ClassVar[str] = "log.liggghts"
    deck: ClassVar[type[SceneDeck]] = LiggghtsSceneDeck
    restarting: ClassVar[type[RestartingDeck] | None] = LiggghtsRestartingDeck
    speed: ClassVar[Speed] = Speed(2.5e6)
    missing: ClassVar[Mapping[str, str]] = MISSING

    @classmethod
    @override
    def _ranks_refusal(cls, test: BulkTest, ranks: int) -> Message | None:
        if ranks > 1 and test.sizes.shape is not None:
            return messages.CLUMPS_ON_ONE_CORE
        return super()._ranks_refusal(test, ranks)

    @override
    def check(self) -> None:
        """Raise `SolverNotFoundError` unless it is found, `InputError` for values it refuses."""
        super().check()
        InputError.raise_for(
            messages.RESTITUTION_REFUSED.fault(name, value=value, limit=_REFUSED_RESTITUTION)
            for name, value in self.material.items()
            if plain_name(name) in _RESTITUTIONS and value <= _REFUSED_RESTITUTION
        )

    @override
    def _ended_empty(self, error: RunFailedError, scene: Scene, deck: SceneDeck) -> bool:
        assert isinstance(deck, LiggghtsSceneDeck)
        if not any(refusal in error.reason for refusal in REFUSALS):
            return False
        box = EmptyBox(scene, deck.folder, deck.snapshot_columns)
        if not box.is_known:
            return False
        if box.unknown_stage:
            raise RunFailedError(messages.EMPTY_BOX_PRESSED(stage=box.unknown_stage)) from error
        box.end()
        return True

    def _launcher(self) -> str:
        found = shutil.which("mpiexec.openmpi") or shutil.which("mpiexec")
        if found is None:
            raise SolverNotFoundError(messages.NO_LAUNCHER(ranks=self.ranks))
        return found

    def _command(self, deck: Path) -> list[str]:
        # Line buffering: an error message must not be lost when the program aborts.
        command = ["stdbuf", "-oL", self._program(), "-in", deck.name, "-nocite"]
        if self.ranks == 1:
            return command
        # With core binding, several runs would share the first cores; waiting ranks must yield.
        launcher = [self._launcher(), "-n", str(self.ranks), "--bind-to", "none"]
        launcher += ["--mca", "mpi_yield_when_idle", "1"]
        if platforms.is_root():
            launcher.append("--allow-run-as-root")
        return launcher + command
