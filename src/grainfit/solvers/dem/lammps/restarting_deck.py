"""Decks for LAMMPS that write restart files: saving changes no number of a run."""

from __future__ import annotations

from collections.abc import Iterator
from typing import ClassVar

from grainfit.scenes.scene import Stage, Wall
from grainfit.solvers.dem.lammps.scene_deck import LammpsSceneDeck
from grainfit.solvers.dem.restarting_script import RestartingScript
from grainfit.solvers.dem.script_syntax import command


class LammpsRestartingDeck(RestartingScript, LammpsSceneDeck):
    """A scene as a deck for LAMMPS that writes restart files; see `RestartingDeck`."""

    repeats_rows: ClassVar[bool] = True
    repeats_frames: ClassVar[bool] = True
    writing: ClassVar[str] = " noinit"
    reading: ClassVar[str] = " remap"
    give_up: ClassVar[str] = "quit 1"

    def in_pieces(self, number: int, piece: int, save: str, without: str) -> Iterator[str]:
        """Simulate time steps; within the run, it goes on without a new setup."""
        yield save
        pieces = f'pre no {without} every {piece} "{save}"' if number > piece else without
        yield command("run", f"{number} {pieces}")

    def put_again(self, walls: dict[str, Wall], stage: Stage) -> Iterator[str]:  # noqa: ARG002
        """Put the walls that are there in a stage, which goes on."""
        for name, wall in walls.items():
            yield from self.put(name, wall)
