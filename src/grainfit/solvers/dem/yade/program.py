"""YADE."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from typing import ClassVar

from typing_extensions import override

from grainfit.bulk_tests.base import BulkTest
from grainfit.errors import Fault, InputError
from grainfit.materials.walls import plain_name
from grainfit.messages import Message
from grainfit.solvers.dem import messages
from grainfit.solvers.dem.deck import SceneDeck
from grainfit.solvers.dem.program import DeckSolver
from grainfit.solvers.dem.restarting_deck import RestartingDeck
from grainfit.solvers.dem.yade.restarting_deck import YadeRestartingDeck
from grainfit.solvers.dem.yade.scene_deck import MISSING, YadeSceneDeck
from grainfit.solvers.speed import Speed


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
    install: ClassVar[str] = "Install it with: apt-get install yade"
    version_option: ClassVar[str] = "--version"
    version_pattern: ClassVar[str] = r"Yade version: (\S+)"
    deck: ClassVar[type[SceneDeck]] = YadeSceneDeck
    restarting: ClassVar[type[RestartingDeck] | None] = YadeRestartingDeck
    speed: ClassVar[Speed] = Speed(0.4e6)
    missing: ClassVar[Mapping[str, str]] = MISSING
    absent_parameters: ClassVar[tuple[str, ...]] = (
        "particle_particle.rolling_damping",
        "particle_wall.rolling_damping",
    )
    #: The last line of a traceback.
    _error: ClassVar[re.Pattern[str]] = re.compile(r"\w*(Error|Exception)\b")

    @classmethod
    @override
    def _ranks_refusal(cls, test: BulkTest, ranks: int) -> Message | None:
        return messages.YADE_ON_ONE_CORE if ranks > 1 else super()._ranks_refusal(test, ranks)

    @override
    def _require_possible(self, material: Mapping[str, float]) -> None:
        super()._require_possible(material)
        InputError.raise_for(_damping_faults(material.items()))

    @override
    def interval_faults(self, intervals: Mapping[str, tuple[float, float]]) -> list[Fault]:
        damped = list(_damping_faults((name, ends[1]) for name, ends in intervals.items()))
        # Materials with damping are refused before the test is asked about them.
        return damped or super().interval_faults(intervals)

    def _command(self, deck: Path) -> list[str]:
        # No window, one thread, and an end after the script instead of a prompt.
        return [self._program(), "-n", "-x", "-j1", deck.name]


def _damping_faults(values: Iterable[tuple[str, float]]) -> Iterator[Fault]:
    for name, value in values:
        if plain_name(name) in Yade.absent_parameters and value > 0:
            yield messages.NO_ROLLING_DAMPING.fault(name, value=value)
