"""Decks for LIGGGHTS that write restart files.

Its restart files have the contact history, and the meshes of the walls at their places.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import ClassVar

from grainfit.scenes.scene import Rotation, Scene, Stage, Wall
from grainfit.solvers.dem.liggghts.scene_deck import LiggghtsSceneDeck
from grainfit.solvers.dem.restarting_script import RestartingScript
from grainfit.solvers.dem.restarts import Saved
from grainfit.solvers.dem.script_syntax import command


class LiggghtsRestartingDeck(RestartingScript, LiggghtsSceneDeck):
    """A scene as a deck for LIGGGHTS that writes restart files; see `RestartingDeck`."""

    repeats_rows: ClassVar[bool] = False
    repeats_frames: ClassVar[bool] = True
    #: No command: its ``quit`` ends as a good run does.
    give_up: ClassVar[str] = "restart_file_is_of_another_step"

    def __init__(self, scene: Scene, folder: Path, every: int, saved: Saved | None = None) -> None:
        super().__init__(scene, folder, every, saved)
        #: Speeds of the tubes that turn where the run goes on, rad/s.
        self._turning: dict[str, float] = {}

    def follows(self, wall: str) -> bool:
        """Return whether a variable of the deck alone knows where a moving wall is."""
        return not self.is_loaded(wall)

    def in_pieces(self, number: int, piece: int, save: str, without: str) -> Iterator[str]:
        """Simulate time steps in runs of their own: within a run, LIGGGHTS includes no file."""
        for first in range(0, max(number, 1), piece):
            yield save
            yield command("run", f"{min(piece, number - first)} {without}")

    def put_again(self, walls: dict[str, Wall], stage: Stage) -> Iterator[str]:
        """Put the walls that are there in a stage, which goes on."""
        self._turning = {
            name: motion.speed
            for name in walls
            for motion in stage.motions_of(name)
            if isinstance(motion, Rotation)
        }
        for name, wall in walls.items():
            yield from self.put(name, wall)
            if self.is_loaded(name):
                yield self.travel_of_servo(name, self.moving_walls()[name].along)
        yield from self.all_walls()

    def put_tube(self, name: str, wall: Wall, speed: float = 0.0) -> Iterator[str]:
        """Put a tube; one that turns goes on with it."""
        return super().put_tube(name, wall, speed or self._turning.get(name, 0.0))

    def put_tube_again(self, name: str, speed: float) -> Iterator[str]:
        """Put a tube with another speed; one that goes on keeps the history of its contacts."""
        if self._turning.pop(name, None) is None:
            yield from super().put_tube_again(name, speed)
