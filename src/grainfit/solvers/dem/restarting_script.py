"""Decks for LAMMPS and its relatives that write restart files, and decks that continue from them.

The deck looks whether to save between two runs, and within a long run. A particle that has left the
box, and that the program has not removed yet, could not be read again: then the deck saves at its
next look.
"""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import ClassVar

from grainfit.scenes.conditions import Loaded
from grainfit.scenes.scene import Scene, Stage, Wall
from grainfit.solvers.dem.restarting_deck import RestartingDeck
from grainfit.solvers.dem.restarts import IS_READ, Saved, state_line
from grainfit.solvers.dem.script import PARTICLES, ScriptDeck
from grainfit.solvers.dem.script_syntax import command, continued, heading

#: Looks within a long run between two restart files.
_LOOKS = 4


class RestartingScript(RestartingDeck, ScriptDeck):
    """A scene as a script that writes restart files; see `RestartingDeck`."""

    inexact: ClassVar[Mapping[str, str]] = {"clumps": "clumps", "glued": "glued particles"}
    #: Further arguments of ``write_restart`` and of ``read_restart``.
    writing: ClassVar[str] = ""
    reading: ClassVar[str] = ""
    #: Command that ends the program with an error.
    give_up: ClassVar[str]

    def __init__(self, scene: Scene, folder: Path, every: int, saved: Saved | None = None) -> None:
        super().__init__(scene, folder, every, saved)
        #: Walls that are there in the stage that is being written.
        self._there: dict[str, Wall] = {}

    @property
    def particle_files(self) -> tuple[str, ...]:
        """Files of the particles of the beginning, which the deck reads."""
        return (PARTICLES,)

    # --- saving --------------------------------------------------------------------------------

    def film_run(self, *, more: bool = False) -> Iterator[str]:
        """Write the frames of the whole run, and define what the deck saves by."""
        box = self.scene.box
        sides = " ".join(
            "INF INF" if axis in box.periodic else f"{low} {high}"
            for axis, low, high in zip("xyz", box.low, box.high, strict=True)
        )
        yield command("region", f"beyond block {sides} side out units box")
        yield command("variable", "outside equal count(all,beyond)")
        yield command("variable", "spheres equal count(all)")
        yield command("variable", f"due equal ${{now}}+{self._every}")
        yield command("variable", "slot equal 0")
        yield from super().film_run(more=more)

    def stage(self, stage: Stage) -> Iterator[str]:
        """Iterate over the commands of a stage."""
        if not self._there:
            self._there = dict(self.scene.walls)
        for name in stage.take_away:
            del self._there[name]
        self._there |= stage.put
        self._write_save(stage)
        return super().stage(stage)

    def steps(self, stage: Stage, number: int, without: str = "post no") -> Iterator[str]:
        """Simulate time steps of a stage; save before them, and between them."""
        yield command("variable", f"upto equal ${{now}}+{number}")
        yield from self.in_pieces(
            number, max(1, self._every // _LOOKS), f"include {self._save_file(stage)}", without
        )

    @abstractmethod
    def in_pieces(self, number: int, piece: int, save: str, without: str) -> Iterator[str]:
        """Simulate time steps; include the commands that save before each piece."""

    def _write_save(self, stage: Stage) -> None:
        """Write the commands that save, when it is due, in a stage."""
        numbers = {
            "stage": stage.name,
            **{key: f"${{{key}}}" for key in ("start", "upto")},
            "step": "${now}",
            "count": "${spheres}",
        }
        if stage.is_closed:
            numbers["expected"] = "${expected}"
        if isinstance(stage.until, Loaded):
            numbers["near"] = "${near}"
        state = state_line(
            numbers, {name: f"${{{self._travel(name, stage)}}}" for name in self._moving()}
        )
        commands = [
            "variable slot equal 1-${slot}",
            f"write_restart restart.${{slot}}{self.writing}",
            f"print '{state}' file restart.${{slot}}.state",
            f"variable due equal ${{now}}+{self._every}",
        ]
        line = continued(
            command("if", '"(${now} >= ${due}) && (${outside} == 0)" then'),
            [f'"{one}"' for one in commands],
        )
        (self.folder / self._save_file(stage)).write_text(line + "\n", encoding="ascii")

    def _save_file(self, stage: Stage) -> str:
        """Return the name of the file with the commands that save in a stage."""
        return f"save_{stage.name}.{self.file_name.removeprefix('in.')}"

    def _moving(self) -> list[str]:
        """Return the walls that are there and move in some stage."""
        return [name for name in self.moving_walls() if name in self._there and self.follows(name)]

    def follows(self, wall: str) -> bool:  # noqa: ARG002
        """Return whether a variable of the deck alone knows where a moving wall is."""
        return True

    def _travel(self, wall: str, stage: Stage) -> str:
        """Return the variable of the travel from which a wall's motion goes on."""
        follows = wall in stage.motions and not self.is_loaded(wall)
        return f"{wall}_{'from' if follows else 'travel'}"

    # --- continuing ----------------------------------------------------------------------------

    def read_particles(self) -> str:
        """Return the command that reads the particles."""
        if self._saved is None:
            return super().read_particles()
        return command("read_restart", f"{self._saved.file}{self.reading}")

    @abstractmethod
    def put_again(self, walls: dict[str, Wall], stage: Stage) -> Iterator[str]:
        """Put the walls that are there in a stage, which goes on."""

    def continuation(self) -> str:
        """Return the deck that continues from the restart file."""
        return "\n".join(self._continuation()) + "\n"

    def _continuation(self) -> Iterator[str]:
        saved, scene = self.saved, self.scene
        names = [stage.name for stage in scene.stages]
        now = names.index(saved.stage)
        stage = scene.stages[now]
        self._there = dict(scene.walls)
        for one in scene.stages[: now + 1]:
            for name in one.take_away:
                del self._there[name]
            self._there |= one.put
        self.travels = saved.travels
        yield f"# {scene.title}, continued from {saved.file} in the stage {stage.name}. SI units."
        yield from self.head()
        yield from self.contacts()
        yield heading("walls")
        yield from self.put_again(self._there, stage)
        yield heading("motion, and what is looked at")
        yield from self.motion()
        yield command("if", f'"${{now}} != {saved.step}" then "{self.give_up}"')
        yield command("variable", "spheres equal count(all)")
        yield command("if", f'"${{spheres}} != {saved.particles}" then "{self.give_up}"')
        yield heading(f"{stage.name}, continued")
        yield command("variable", f"stage string {stage.name}")
        if stage.sliding_friction is not None:
            yield from self.between_particles(stage.sliding_friction)
        yield command("variable", f"start equal {saved.start}")
        yield from self.start_motions(stage)
        yield "# Contacts and walls of the restart file are complete if this works."
        yield command("run", "0 post no")
        yield command("print", f'"{saved.file}" file {IS_READ}')
        yield from self.film_run(more=True)
        yield from self.record(stage, more=True)
        if stage.is_closed:
            yield command("variable", f"expected equal {saved.values['expected']}")
        yield from self.looked_at(stage.until, saved.values.get("near", "0"))
        self._write_save(stage)
        yield from self.steps(stage, saved.upto - saved.step)
        yield from self.until(stage)
        for later in scene.stages[now + 1 :]:
            yield from self.stage(later)
        yield command("jump", "SELF end")
        yield from self.ends()
