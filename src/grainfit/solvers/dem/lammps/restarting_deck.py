"""Decks for LAMMPS that write restart files: saving changes no number of a run."""

from __future__ import annotations

from collections.abc import Iterator
from typing import ClassVar

from grainfit.scenes.scene import Stage, Wall
from grainfit.solvers.dem.lammps.scene_deck import LammpsSceneDeck
from grainfit.solvers.dem.restarting_script import RestartingScript


class LammpsRestartingDeck(RestartingScript, LammpsSceneDeck):
    """A scene as a deck for LAMMPS that writes restart files; see `RestartingDeck`."""

    repeats_rows: ClassVar[bool] = True
    repeats_frames: ClassVar[bool] = True
    writing: ClassVar[str] = " noinit"
    #: Within a run, it goes on without a new setup.
    pieces: ClassVar[str] = "pre no "
    reading: ClassVar[str] = " remap"
    give_up: ClassVar[str] = "quit 1"

    def put_again(self, walls: dict[str, Wall], stage: Stage) -> Iterator[str]:  # noqa: ARG002
        """Put the walls that are there in a stage, which goes on."""
        for name, wall in walls.items():
            yield from self.put(name, wall)
