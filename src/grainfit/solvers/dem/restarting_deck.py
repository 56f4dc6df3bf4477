"""Base class of decks that write restart files, and continue from them."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Mapping
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import ClassVar

from grainfit.scenes.scene import Scene
from grainfit.solvers.dem.deck import SceneDeck
from grainfit.solvers.dem.restarts import Saved, cut_output


class RestartingDeck(SceneDeck):
    """A scene as input of a DEM program that writes restart files.

    Parameters
    ----------
    scene : Scene
        The scene to translate, with no concept of `inexact`.
    folder : Path
        Folder of the run; everything that the solver reads is written there.
    every : int
        Time steps between two restart files.
    saved : Saved, optional
        State of the restart file that a run continues from.
    """

    #: Concepts of scenes whose runs it does not continue exactly, in words.
    inexact: ClassVar[Mapping[str, str]] = {}
    #: Deck that continues a run.
    continued_name: ClassVar[str] = "in.continue"
    #: Whether a continued run writes the rows, and the frames, of its first time step again.
    repeats_rows: ClassVar[bool]
    repeats_frames: ClassVar[bool]

    def __init__(self, scene: Scene, folder: Path, every: int, saved: Saved | None = None) -> None:
        super().__init__(scene, folder)
        self._every = every
        self._saved = saved

    @property
    @abstractmethod
    def particle_files(self) -> tuple[str, ...]:
        """Files of the particles of the beginning, which the deck reads."""

    @property
    def saved(self) -> Saved:
        """State of the restart file."""
        assert self._saved is not None, "a deck that continues has a restart file"
        return self._saved

    def is_written(self) -> bool:
        """Return whether the deck and the particles of the folder are those of the scene."""
        with TemporaryDirectory() as other:
            type(self)(self.scene, Path(other), self._every).write()
            try:
                return all(
                    (self.folder / name).read_bytes() == (Path(other) / name).read_bytes()
                    for name in (self.file_name, *self.particle_files)
                )
            except OSError:
                return False

    def write_continuation(self) -> Path:
        """Cut the output at the restart file, and write the deck that continues; return it."""
        first_row, first_frame = (
            self.saved.step + (not repeats) for repeats in (self.repeats_rows, self.repeats_frames)
        )
        cut_output(self.folder, self.scene, self.saved, first_row, first_frame)
        deck = self.folder / self.continued_name
        deck.write_text(self.continuation(), encoding="utf-8")
        return deck

    @abstractmethod
    def continuation(self) -> str:
        """Return the deck that continues from the restart file."""
