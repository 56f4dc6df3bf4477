"""LIGGGHTS-PUBLIC."""

from __future__ import annotations

import os
import re
import shutil
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import ClassVar

from typing_extensions import override

from grainfit.bulk_tests.base import BulkTest
from grainfit.errors import Fault, InputError, SolverNotFoundError
from grainfit.materials.walls import plain_name
from grainfit.solvers.dem.deck import SceneDeck
from grainfit.solvers.dem.liggghts.scene_deck import MISSING, LiggghtsSceneDeck
from grainfit.solvers.dem.program import DeckSolver, program_help
from grainfit.solvers.speed import Speed

_INSTALL = "Install it with: apt-get install liggghts"
_RESTITUTIONS = ("particle_particle.restitution", "particle_wall.restitution")
_REFUSED_RESTITUTION = 0.05


class Liggghts(DeckSolver):
    """LIGGGHTS-PUBLIC, ``liggghts`` on the PATH; see `DeckSolver`."""

    name = "liggghts"
    title: ClassVar[str] = "LIGGGHTS"
    usual_name: ClassVar[str] = "liggghts"
    install: ClassVar[str] = _INSTALL
    _own_log: ClassVar[str] = "log.liggghts"
    deck: ClassVar[type[SceneDeck]] = LiggghtsSceneDeck
    speed: ClassVar[Speed] = Speed(2.5e6)
    missing: ClassVar[Mapping[str, str]] = MISSING

    def __init__(
        self,
        test: BulkTest,
        material: Mapping[str, float | str],
        ranks: int = 1,
        executable: str | None = None,
        contact_models: Iterable[str] = (),
        walls: Mapping[str, str] | None = None,
    ) -> None:
        if ranks > 1 and test.sizes.shape is not None:
            message = f"LIGGGHTS-PUBLIC moves clumps on one core, not on {ranks}."
            raise InputError(Fault("ranks", message, "Leave it out, or use LAMMPS."))
        super().__init__(test, material, ranks, executable, contact_models, walls)

    @override
    def check(self) -> None:
        """Raise `SolverNotFoundError` unless it is found, `InputError` for values it refuses."""
        super().check()
        faults = [
            Fault(
                name,
                f"{value:g} is refused by LIGGGHTS.",
                f"Use a restitution above {_REFUSED_RESTITUTION:g}, or LAMMPS.",
            )
            for name, value in self.material.items()
            if plain_name(name) in _RESTITUTIONS and value <= _REFUSED_RESTITUTION
        ]
        if faults:
            raise InputError(faults)

    @override
    def version(self) -> str:
        """Return the version that the program reports, such as ``LIGGGHTS-PUBLIC 3.8.0``."""
        program = self._program()
        found = re.search(r"LIGGGHTS \(Version ([^,)]+)", program_help(program, _INSTALL))
        if found is None:
            raise SolverNotFoundError(f"{program} does not run as LIGGGHTS does. {_INSTALL}")
        return found.group(1).strip()

    def _launcher(self) -> str:
        found = shutil.which("mpiexec.openmpi") or shutil.which("mpiexec")
        if found is None:
            raise SolverNotFoundError(
                f"{self.ranks} MPI ranks need mpiexec, which is not found. "
                "Install it with: apt-get install openmpi-bin"
            )
        return found

    def _command(self, deck: Path) -> list[str]:
        # Line buffering: an error message must not be lost when the program aborts.
        command = ["stdbuf", "-oL", self._program(), "-in", deck.name, "-nocite"]
        if self.ranks == 1:
            return command
        # With core binding, several runs would share the first cores; waiting ranks must yield.
        launcher = [self._launcher(), "-n", str(self.ranks), "--bind-to", "none"]
        launcher += ["--mca", "mpi_yield_when_idle", "1"]
        if os.geteuid() == 0:
            launcher.append("--allow-run-as-root")
        return launcher + command
