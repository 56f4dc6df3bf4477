"""YADE."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from typing import ClassVar

from typing_extensions import override

from grainfit.bulk_tests.base import BulkTest
from grainfit.errors import Fault, InputError, SolverNotFoundError
from grainfit.materials.walls import plain_name
from grainfit.solvers.dem.deck import SceneDeck
from grainfit.solvers.dem.program import DeckSolver, program_help
from grainfit.solvers.dem.yade.scene_deck import MISSING, YadeSceneDeck
from grainfit.solvers.speed import Speed

_INSTALL = "Install it with: apt-get install yade"


class Yade(DeckSolver):
    """YADE, ``yade`` on the PATH; see `DeckSolver`.

    Raises
    ------
    InputError
        More than one rank, or rolling damping, which YADE does not have.
    """

    name = "yade"
    title: ClassVar[str] = "YADE"
    usual_name: ClassVar[str] = "yade"
    install: ClassVar[str] = _INSTALL
    deck: ClassVar[type[SceneDeck]] = YadeSceneDeck
    speed: ClassVar[Speed] = Speed(0.4e6)
    missing: ClassVar[Mapping[str, str]] = MISSING
    absent_parameters: ClassVar[tuple[str, ...]] = (
        "particle_particle.rolling_damping",
        "particle_wall.rolling_damping",
    )
    #: The last line of a traceback.
    _error: ClassVar[re.Pattern[str]] = re.compile(r"\w*(Error|Exception)\b")

    def __init__(
        self,
        test: BulkTest,
        material: Mapping[str, float | str],
        ranks: int = 1,
        executable: str | None = None,
        contact_models: Iterable[str] = (),
        walls: Mapping[str, str] | None = None,
    ) -> None:
        if ranks > 1:
            message = f"YADE runs on one core here, not on {ranks}: with threads, two runs of one"
            message += " seed differ."
            raise InputError(Fault("ranks", message, "Leave it out; several runs go at a time."))
        super().__init__(test, material, ranks, executable, contact_models, walls)

    @override
    def _require_possible(self, material: Mapping[str, float]) -> None:
        super()._require_possible(material)
        faults = list(_damping_faults(material.items()))
        if faults:
            raise InputError(faults)

    @override
    def interval_faults(self, intervals: Mapping[str, tuple[float, float]]) -> list[Fault]:
        """Return why runs cannot succeed in a part of the intervals."""
        damped = list(_damping_faults((name, ends[1]) for name, ends in intervals.items()))
        # Materials with damping are refused before the test is asked about them.
        return damped or super().interval_faults(intervals)

    @override
    def version(self) -> str:
        """Return the version that the program reports, such as ``2023.02a``."""
        program = self._program()
        found = re.search(r"Yade version: (\S+)", program_help(program, _INSTALL, "--version"))
        if found is None:
            raise SolverNotFoundError(f"{program} does not run as YADE does. {_INSTALL}")
        return found.group(1)

    def _command(self, deck: Path) -> list[str]:
        # No window, one thread, and an end after the script instead of a prompt.
        return [self._program(), "-n", "-x", "-j1", deck.name]


def _damping_faults(values: Iterable[tuple[str, float]]) -> Iterator[Fault]:
    for name, value in values:
        if plain_name(name) in Yade.absent_parameters and value > 0:
            yield Fault(
                name,
                f"{value:g} is above 0, and YADE has no rolling damping.",
                'Set it to 0 for solver = "yade", or use LAMMPS or LIGGGHTS.',
            )
