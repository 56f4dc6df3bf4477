"""Continue a long run where its restart file was written: its state, and output from then on."""

from __future__ import annotations

import math
import os
import shutil
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path

from grainfit.scenes.film import FILM
from grainfit.scenes.run_output import STAGES, series_file, snapshot_file
from grainfit.scenes.scene import Scene, Stage
from grainfit.solvers.process.restart_files import restart_states
from grainfit.solvers.run_cost import RunCost

#: Estimated wall time above which a run writes restart files, and time between two of them, s.
LONG_RUN, INTERVAL = 1200.0, 600.0
#: File that a continued run writes as soon as it has read its restart file.
IS_READ = "restart.read"
#: Log of a run that was continued, or could not be.
LOG = "continued.log"
_END = "complete"
_DUMP_FRAME = b"ITEM: TIMESTEP"


def steps_between(cost: RunCost) -> int | None:
    """Return the time steps between two restart files of a run; None if it is short."""
    if cost.wall_seconds <= LONG_RUN:
        return None
    return max(1, round(cost.steps * INTERVAL / cost.wall_seconds))


@dataclass(frozen=True)
class Saved:
    """State of a run when a restart file was written.

    Parameters
    ----------
    file : str
        Name of the restart file.
    stage : str
        Stage of the scene.
    step, start, upto : int
        Time step of the file, first one of the stage, and the one up to which the program was
        simulating.
    particles : int
        Spheres in the file.
    values : mapping of str to str
        Further values of the deck's variables, as the program wrote them.
    travels : mapping of str to str
        Travel of each moving wall, m or rad, at the beginning of its motion in this stage.
    """

    file: str
    stage: str
    step: int
    start: int
    upto: int
    particles: int
    values: Mapping[str, str]
    travels: Mapping[str, str]


def state_line(numbers: Mapping[str, str], travels: Mapping[str, str]) -> str:
    """Return the line of a state, of names and values; see `Saved`."""
    moved = {f"travel.{name}": value for name, value in travels.items()}
    return " ".join([*(f"{key}={value}" for key, value in {**numbers, **moved}.items()), _END])


def saved_states(folder: Path, scene: Scene) -> list[Saved]:
    """Return the states of a run's restart files that are whole, the latest first."""
    closed = {stage.name: stage.is_closed for stage in scene.stages}
    found = [state for path in restart_states(folder) if (state := _read(path)) is not None]
    known = (one for one in found if one.stage in closed)
    whole = (one for one in known if "expected" in one.values or not closed[one.stage])
    return sorted(whole, key=lambda one: -one.step)


def _read(path: Path) -> Saved | None:
    try:
        *words, end = path.read_text(encoding="utf-8").split()
        values = dict(word.split("=", 1) for word in words)
        if end != _END:
            return None
        travels = {
            key.removeprefix("travel."): values.pop(key)
            for key in list(values)
            if key.startswith("travel.")
        }
        for value in travels.values():
            float(value)
        stage = values.pop("stage")
        step, start, upto, count = (int(values.pop(k)) for k in ("step", "start", "upto", "count"))
    except (OSError, ValueError, KeyError):
        return None
    return Saved(path.stem, stage, step, start, upto, count, values, travels)


def note(folder: Path, what: str) -> None:
    """Note in the run's folder that a run is continued, or why it is not."""
    with (folder / LOG).open("a", encoding="utf-8") as file:
        file.write(what + "\n")


def clear(folder: Path) -> None:
    """Remove what an earlier try left in the folder of a run that starts anew, except its notes."""
    for path in folder.iterdir():
        if path.is_dir():
            shutil.rmtree(path)
        elif path.name != LOG:
            path.unlink()


def cut_output(folder: Path, scene: Scene, saved: Saved, first_row: int, first_frame: int) -> None:
    """Remove from the output of a run what it wrote after a restart file.

    Of series and frames, that is from these time steps on.
    """
    names = [stage.name for stage in scene.stages]
    now = names.index(saved.stage)
    header, *rows = (folder / STAGES).read_text(encoding="utf-8").splitlines(keepends=True)
    kept = [row for row in rows if row.partition(",")[0] in names[:now]]
    (folder / STAGES).write_text("".join([header, *kept]), encoding="utf-8")
    for path in _output_after(folder, scene.stages[now:]):
        path.unlink(missing_ok=True)
    _cut_series(folder / series_file(saved.stage), (first_row - 0.5) * scene.time_step)
    frames = scene.stages[now].frames
    for file in (FILM, *([snapshot_file(frames.name)] if frames else [])):
        _cut_frames(folder / file, first_frame)


def _output_after(folder: Path, stages: tuple[Stage, ...]) -> Iterator[Path]:
    """Iterate over the files that stages write, except those of the first while it goes on."""
    for number, stage in enumerate(stages):
        if stage.snapshot:
            yield folder / snapshot_file(stage.snapshot)
        if number:
            yield folder / series_file(stage.name)
            if stage.frames is not None:
                yield folder / snapshot_file(stage.frames.name)


def join_series(folder: Path, saved: Saved) -> None:
    """Remove the empty line with which a continued program begins to append to a series."""
    _cut_series(folder / series_file(saved.stage), math.inf)


def _cut_series(path: Path, end: float) -> None:
    """Remove the rows of a series from a time on, s, and empty ones."""
    if not path.exists():
        return
    header, *rows = path.read_text(encoding="utf-8").splitlines(keepends=True)
    whole = (row for row in rows if row.strip() and row.endswith("\n"))
    kept = [row for row in whole if float(row.partition(",")[0]) < end]
    path.write_text("".join([header, *kept]), encoding="utf-8")


def _cut_frames(path: Path, step: int) -> None:
    """Remove the frames of a dump from a time step on."""
    if not path.exists():
        return
    with path.open("rb") as file:
        place = 0
        while line := file.readline():
            if line.startswith(_DUMP_FRAME):
                number = file.readline().strip()
                if not number.isdigit() or int(number) >= step:
                    os.truncate(path, place)
                    return
            place = file.tell()
