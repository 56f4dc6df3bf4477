"""Decks for LAMMPS that write restart files, and decks that continue from them.

Saving changes no number of a run: the deck looks between two runs, and within a run at points where
it goes on without a new setup (``pre no``). A particle that has left the box, and that LAMMPS has
not removed yet, could not be read again: then the deck saves at its next look.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from tempfile import TemporaryDirectory

from grainfit.scenes.conditions import Loaded
from grainfit.scenes.scene import Scene, Stage, Wall
from grainfit.solvers.dem.lammps.scene_deck import LammpsSceneDeck
from grainfit.solvers.dem.restarts import IS_READ, Saved, cut_output, state_line
from grainfit.solvers.dem.script import PARTICLES
from grainfit.solvers.dem.script_syntax import command, continued, heading

#: Looks within a long run between two restart files.
_LOOKS = 4


class RestartingDeck(LammpsSceneDeck):
    """A scene as a deck for LAMMPS that writes restart files.

    Parameters
    ----------
    scene : Scene
        The scene to translate, without glued sets and clumps.
    folder : Path
        Folder of the run; everything that the solver reads is written there.
    every : int
        Time steps between two restart files.
    saved : Saved, optional
        State of the restart file that a run continues from.
    """

    def __init__(self, scene: Scene, folder: Path, every: int, saved: Saved | None = None) -> None:
        super().__init__(scene, folder)
        self._every = every
        self._saved = saved
        #: Walls that are there in the stage that is being written.
        self._there: dict[str, Wall] = {}

    @staticmethod
    def refusal(scene: Scene) -> str:
        """Return what of a scene keeps its runs from being continued; empty if nothing does."""
        if scene.clumps is not None:
            return "clumps"
        return "glued particles" if scene.glued else ""

    @property
    def saved(self) -> Saved:
        """State of the restart file."""
        assert self._saved is not None, "a deck that continues has a restart file"
        return self._saved

    def is_written(self) -> bool:
        """Return whether the deck and the particles of the folder are those of the scene."""
        names = self.file_name, PARTICLES
        with TemporaryDirectory() as other:
            RestartingDeck(self.scene, Path(other), self._every).write()
            try:
                return all(
                    (self.folder / name).read_bytes() == (Path(other) / name).read_bytes()
                    for name in names
                )
            except OSError:
                return False

    def write_continuation(self) -> Path:
        """Cut the output at the restart file, and write the deck that continues; return it."""
        cut_output(self.folder, self.scene, self.saved)
        deck = self.folder / "in.continue"
        deck.write_text("\n".join(self.continuation()) + "\n", encoding="utf-8")
        return deck

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
        save, piece = f"include {_save_file(stage)}", max(1, self._every // _LOOKS)
        yield command("variable", f"upto equal ${{now}}+{number}")
        yield save
        pieces = f'pre no {without} every {piece} "{save}"' if number > piece else without
        yield command("run", f"{number} {pieces}")

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
            "write_restart restart.${slot} noinit",
            f"print '{state}' file restart.${{slot}}.state",
            f"variable due equal ${{now}}+{self._every}",
        ]
        line = continued(
            command("if", '"(${now} >= ${due}) && (${outside} == 0)" then'),
            [f'"{one}"' for one in commands],
        )
        (self.folder / _save_file(stage)).write_text(line + "\n", encoding="ascii")

    def _moving(self) -> list[str]:
        """Return the walls that are there and move in some stage."""
        return [name for name in self.moving_walls() if name in self._there]

    def _travel(self, wall: str, stage: Stage) -> str:
        """Return the variable of the travel from which a wall's motion goes on."""
        follows = wall in stage.motions and not self.is_loaded(wall)
        return f"{wall}_{'from' if follows else 'travel'}"

    # --- continuing ----------------------------------------------------------------------------

    def read_particles(self) -> str:
        """Return the command that reads the particles."""
        if self._saved is None:
            return super().read_particles()
        return command("read_restart", f"{self._saved.file} remap")

    def continuation(self) -> Iterator[str]:
        """Iterate over the lines of the deck that continues from the restart file."""
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
        for name, wall in self._there.items():
            yield from self.put(name, wall)
        yield heading("motion, and what is looked at")
        yield from self.motion()
        yield command("if", f'"${{now}} != {saved.step}" then "quit 1"')
        yield command("variable", "spheres equal count(all)")
        yield command("if", f'"${{spheres}} != {saved.particles}" then "quit 1"')
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


def _save_file(stage: Stage) -> str:
    """Return the name of the file with the commands that save in a stage."""
    return f"save_{stage.name}.lammps"
