"""The rest of a run of LIGGGHTS whose last particle has left the box.

LIGGGHTS refuses to begin a `run` without particles. Nothing happens any more then but time and the
travel of walls, so the files of the stages that are left follow from the scene.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from grainfit.scenes.conditions import AtRest, Drained, Elapsed
from grainfit.scenes.film import FILM
from grainfit.scenes.records import Recorded, Travel
from grainfit.scenes.run_output import STAGES, RunOutput, series_file, snapshot_file
from grainfit.scenes.scene import Load, Scene, Stage

#: What LIGGGHTS says when it is to begin a run without particles.
REFUSALS = ("Atom types must start from 1", "Atom sorting has bin size = 0.0")
_FRAME = "ITEM: TIMESTEP\n{step}\nITEM: NUMBER OF ATOMS\n0\nITEM: BOX BOUNDS {sides}\n{bounds}\n"


class EmptyBox:
    """What an empty box leaves in the stages that LIGGGHTS did not begin.

    Parameters
    ----------
    scene : Scene
        The scene, whose last particle has left the box.
    folder : Path
        Folder of the run.
    columns : str
        Columns of its snapshots.
    """

    def __init__(self, scene: Scene, folder: Path, columns: str) -> None:
        self._scene, self._folder, self._columns = scene, folder, columns
        self._ends = RunOutput(folder).ends
        #: Time step at which each stage begins, and the last one ends.
        self._steps = [0, *(end.step for end in self._ends)]

    @property
    def is_known(self) -> bool:
        """Whether the stages that have ended are known; the snapshot of the last may be left."""
        ended = [end.name for end in self._ends]
        names = [stage.name for stage in self._scene.stages]
        return bool(ended) and ended == names[: len(ended)]

    @property
    def unknown_stage(self) -> str:
        """Name of a stage that does not follow from the scene; "" where all that are left do.

        How far a `Load` goes without particles is left to the solver.
        """
        stages = self._scene.stages
        pressed: set[str] = set()
        for number, stage in enumerate(stages):
            pressed |= {name for name, one in stage.all_motions() if isinstance(one, Load)}
            columns = stage.series.columns.values() if stage.series is not None else ()
            travels = {one.wall for one in columns if isinstance(one, Travel)}
            presses = any(isinstance(one, Load) for _, one in stage.all_motions())
            if number >= len(self._ends) and (presses or travels & pressed):
                return stage.name
        return ""

    def end(self) -> None:
        """Write the snapshot of the last stage that has ended, and all files of those after it."""
        first = step = self._steps[-1]
        self._snapshot(self._scene.stages[len(self._ends) - 1], step)
        for stage in self._scene.stages[len(self._ends) :]:
            last = step + self._duration(stage)
            self._series(stage, step, last)
            if stage.frames is not None:
                every = self._scene.steps(stage.frames.every)
                self._frames(snapshot_file(stage.frames.name), "w", range(step, last + 1), every)
            end = "at_rest" if isinstance(stage.until, AtRest) else "done"
            with (self._folder / STAGES).open("a", encoding="utf-8") as file:
                file.write(f"{stage.name},{end},{last},{self._time(last)},0,0\n")
            self._snapshot(stage, last)
            self._steps.append(last)
            step = last
        if self._scene.film_interval is not None:
            every = self._scene.steps(self._scene.film_interval)
            self._frames(FILM, "a", range(first + 1, step + 1), every)

    def _time(self, step: int) -> float:
        return step * self._scene.time_step

    def _duration(self, stage: Stage) -> int:
        """Return the time steps of a stage without particles: its first look ends it."""
        scene, until = self._scene, stage.until
        if isinstance(until, Elapsed):
            return scene.steps(until.time)
        if isinstance(until, AtRest | Drained):
            return scene.steps(until.at_least) if until.at_least > 0 else 0
        return scene.steps(scene.check_interval)

    def _series(self, stage: Stage, first: int, last: int) -> None:
        if stage.series is None:
            return
        columns, every = stage.series.columns, self._scene.steps(stage.series.every)
        rows = [",".join(("time", *columns))]
        for step in _multiples(range(first + 1, last + 1), every):
            values = (self._value(quantity, stage, step - first) for quantity in columns.values())
            rows.append(",".join(map(repr, (self._time(step), *values))))
        path = self._folder / series_file(stage.name)
        path.write_text("\n".join(rows) + "\n", encoding="utf-8")

    def _value(self, quantity: Recorded, stage: Stage, steps: int) -> float:
        """Return a recorded quantity so many time steps after the beginning of a stage."""
        if not isinstance(quantity, Travel):
            return 0.0
        number = self._scene.stages.index(stage)
        travel = 0.0
        for index, one in enumerate(self._scene.stages[: number + 1]):
            if quantity.wall in one.put:
                travel = 0.0
            ran = steps if index == number else self._steps[index + 1] - self._steps[index]
            for motion in one.motions_of(quantity.wall):
                if quantity.along in ("", motion.along) and not isinstance(motion, Load):
                    travel += motion.speed * self._time(ran)
        return travel

    def _snapshot(self, stage: Stage, step: int) -> None:
        if stage.snapshot:
            self._frames(snapshot_file(stage.snapshot), "w", range(step, step + 1), 1)

    def _frames(self, name: str, mode: str, steps: range, every: int) -> None:
        box = self._scene.box
        sides = " ".join("pp" if axis in box.periodic else "ff" for axis in "xyz")
        bounds = "\n".join(f"{low!r} {high!r}" for low, high in zip(box.low, box.high, strict=True))
        with (self._folder / name).open(mode, encoding="ascii") as file:
            for step in _multiples(steps, every):
                file.write(_FRAME.format(step=step, sides=sides, bounds=bounds))
                file.write(f"ITEM: ATOMS {self._columns}\n")


def _multiples(steps: range, every: int) -> Iterator[int]:
    """Iterate over the steps that are multiples of an interval."""
    yield from range(-(-steps.start // every) * every, steps.stop, every)
