"""Base class of the translators of scenes into decks."""

from __future__ import annotations

from abc import ABC, abstractmethod
from pathlib import Path
from typing import ClassVar

from grainfit.contact_models.base import ContactLaw
from grainfit.scenes.run_output import SNAPSHOTS
from grainfit.scenes.scene import Scene


class SceneDeck(ABC):
    """A scene as input of a DEM program.

    Parameters
    ----------
    scene : Scene
        The scene to translate.
    folder : Path
        Folder of the run; everything that the program reads is written there.
    """

    #: File that the program is started with.
    file_name: ClassVar[str]

    def __init__(self, scene: Scene, folder: Path) -> None:
        self.scene = scene
        self.folder = folder
        self.law: ContactLaw = scene.law

    def write(self) -> Path:
        """Write everything that the program reads; return the deck.

        Raises
        ------
        InputError
            The program cannot simulate the scene.
        """
        (self.folder / SNAPSHOTS).mkdir(exist_ok=True)
        self.write_particles()
        deck = self.folder / self.file_name
        deck.write_text(self.text(), encoding="utf-8")
        return deck

    @abstractmethod
    def write_particles(self) -> None:
        """Write the particles of the beginning."""

    @abstractmethod
    def text(self) -> str:
        """Return the deck; write other files that it reads."""
