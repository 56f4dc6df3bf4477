"""Scripts for YADE that write restart files.

YADE saves bodies and contacts; what the script itself knows of a run is saved beside them.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any, ClassVar

from grainfit.solvers.dem.restarting_deck import RestartingDeck
from grainfit.solvers.dem.restarts import IS_READ
from grainfit.solvers.dem.yade.scene_deck import YadeSceneDeck


class YadeRestartingDeck(RestartingDeck, YadeSceneDeck):
    """A scene as a script for YADE that writes restart files; see `RestartingDeck`."""

    continued_name: ClassVar[str] = "in.continue.py"
    repeats_rows: ClassVar[bool] = False
    repeats_frames: ClassVar[bool] = False

    @property
    def particle_files(self) -> tuple[str, ...]:
        """Files of the particles of the beginning."""
        clumps = ("clumps.txt",) if self.scene.clumps is not None else ()
        return ("particles.txt", *clumps, *(("glued.txt",) if self.scene.glued else ()))

    def values(self) -> Mapping[str, Any]:
        """Return the values of the template."""
        found = {**super().values(), "every": self._every, "is_read": IS_READ}
        if self._saved is None:
            return found
        stages = self.scene.stages
        now = next(n for n, stage in enumerate(stages) if stage.name == self._saved.stage)
        goes_on = replace(stages[now], take_away=(), put={}, strike_off=None)
        lines = [line for stage in (goes_on, *stages[now + 1 :]) for line in self.stage(stage)]
        return {**found, "saved": self._saved, "first_walls": [], "stages": lines}

    def continuation(self) -> str:
        """Return the script that continues from the restart file."""
        return self.text()
