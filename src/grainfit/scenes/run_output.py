"""Output of a run of a scene: the same files from every solver.

==========================  =====================================================================
``snapshots/NAME.dump``     particles at the end of a stage, or at intervals during it: a text
                            dump, for OVITO, too
``series_STAGE.csv``        recorded quantities of a stage over time, s
``stages.csv``              how, when and with how many particles every stage ended
==========================  =====================================================================
"""

from __future__ import annotations

import csv
import io
import math
from collections.abc import Callable, Collection, Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from grainfit.errors import NotMeasurableError, RunFailedError
from grainfit.files import LARGEST_SERIES, LARGEST_TABLE, log_tail, read_within
from grainfit.measurement.particles import Frame, Particles, read_dump, read_frames
from grainfit.one_line import shortened
from grainfit.scenes import messages

SNAPSHOTS = "snapshots"
STAGES = "stages.csv"
STAGES_HEADER = "stage,end,step,time,particles,kinetic_energy"
_LOGS = ("log.lammps", "log.liggghts", "solver.log")


def series_file(stage: str) -> str:
    """Return the name of the file with the series of a stage."""
    return f"series_{stage}.csv"


def snapshot_file(name: str) -> str:
    """Return the name of the file of a snapshot."""
    return f"{SNAPSHOTS}/{name}.dump"


@dataclass(frozen=True)
class StageEnd:
    """End of one stage.

    Parameters
    ----------
    name : str
        As in the scene, such as ``"fill"``.
    end : str
        ``"at_rest"``, ``"done"``, ``"restless"``, ``"unloaded"``, ``"unstable"`` or ``"broken"``.
    step : int
        Time step at its end.
    time : float
        Simulated time at its end, s.
    particles : int
        Particles then in the box.
    kinetic_energy : float
        J.
    """

    name: str
    end: str
    step: int
    time: float
    particles: int
    kinetic_energy: float


class RunOutput:
    """Output of one run.

    Parameters
    ----------
    folder : Path
        Folder of the run.
    begun : int, optional
        Number of particles at the beginning, where it is known.
    struck : collection of str
        Stages that begin by striking particles off, where `begun` is known.
    """

    def __init__(
        self, folder: Path, begun: int | None = None, struck: Collection[str] = ()
    ) -> None:
        self.folder = Path(folder)
        self._begun, self._struck = begun, struck

    def __repr__(self) -> str:
        return f"RunOutput({shortened(str(self.folder))})"

    @cached_property
    def stages(self) -> tuple[StageEnd, ...]:
        """Ends of the stages, in order.

        Raises
        ------
        NotMeasurableError
            The file is missing or damaged.
        """
        path = self.folder / STAGES
        if not path.exists():
            raise NotMeasurableError(messages.NO_STAGES_FILE(path=path))
        try:
            content = read_within(path, LARGEST_TABLE).decode("utf-8")
            rows = list(csv.reader(io.StringIO(content, newline="")))
        except (OSError, UnicodeDecodeError, csv.Error) as error:
            raise NotMeasurableError(messages.UNREADABLE(path=path, error=error)) from error
        if not rows or ",".join(rows[0]) != STAGES_HEADER:
            raise NotMeasurableError(messages.OTHER_HEADER(path=path, header=STAGES_HEADER))
        try:
            return tuple(_stage_end(row) for row in rows[1:])
        except (ValueError, IndexError) as error:
            raise NotMeasurableError(messages.DAMAGED(path=path, error=error)) from error

    @property
    def ends(self) -> tuple[StageEnd, ...]:
        """Ends of the stages, in order; none when they cannot be read."""
        try:
            return self.stages
        except NotMeasurableError:
            return ()

    def snapshot(self, name: str, glued: int = 0) -> Particles:
        """Read the particles of a snapshot.

        Parameters
        ----------
        name : str
            As in the scene.
        glued : int
            Number of a glued set in the order of the scene, from 1; 0 are the loose particles.

        Raises
        ------
        NotMeasurableError
            There is no such snapshot, or see `read_dump`.
        """
        self._require("snapshot", name, snapshot_file)
        return read_dump(self.path_of(snapshot_file(name)), glued)

    def frames(self, name: str) -> Iterator[Frame]:
        """Read the snapshots that were taken at intervals during a stage.

        Raises
        ------
        NotMeasurableError
            There are none of this name, or see `read_frames`.
        """
        self._require("snapshot", name, snapshot_file)
        return read_frames(self.path_of(snapshot_file(name)))

    def _require(self, kind: str, name: str, file_of: Callable[[str], str]) -> None:
        """Name what there is of a kind of output in place of what is missing."""
        if self.path_of(file_of(name)).exists():
            return
        before, after = file_of("*").split("*")
        found = (str(path.relative_to(self.folder)) for path in self.folder.glob(file_of("*")))
        known = sorted(file.removeprefix(before).removesuffix(after) for file in found)
        if known:
            raise NotMeasurableError(
                messages.NO_OUTPUT(kind=kind, name=name, known=", ".join(known))
            )

    def path_of(self, file: str) -> Path:
        """Return the path of a file such as ``"snapshots/heap.dump"``, whether it exists or not.

        Runs of version 0.1.0 have their dumps beside the deck.
        """
        path = self.folder / file
        older = self.folder / path.name
        return older if older.exists() and not path.exists() else path

    def series(
        self, stage: str, columns: Collection[str] | None = None
    ) -> dict[str, NDArray[np.float64]]:
        """Read the series of a stage: arrays by name of the column, ``"time"`` first.

        Parameters
        ----------
        stage : str
            Name of the stage.
        columns : collection of str, optional
            Columns that are needed beside the time.

        Raises
        ------
        NotMeasurableError
            The file is missing or damaged, or a column is missing.
        """
        self._require("series of a stage", stage, series_file)
        path = self.folder / series_file(stage)
        try:
            text = read_within(path, LARGEST_SERIES).decode("utf-8")
            header, *lines = text.splitlines()
            if not text.endswith("\n"):
                raise ValueError(messages.NO_LINE_END())
            names = header.split(",")
            table = np.array([[float(v) for v in line.split(",")] for line in lines])
            table = table.reshape(len(lines), len(names))
        except (OSError, ValueError) as error:
            raise NotMeasurableError(messages.UNREADABLE(path=path, error=error)) from error
        if not np.isfinite(table).all():
            raise NotMeasurableError(messages.NOT_FINITE(path=path))
        missing = [name for name in ("time", *(columns or ())) if name not in names]
        if missing:
            names_of_missing = " and no column ".join(missing)
            raise NotMeasurableError(f"{path}: {messages.NO_COLUMN(names=names_of_missing)}.")
        # A solver that pauses at a step that it records there records it twice.
        table = table[np.append(True, np.diff(table[:, 0]) > 0)[: len(table)]]
        return dict(zip(names, table.T, strict=True))

    def require_good(self, container: str = "") -> tuple[StageEnd, ...]:
        """Raise `RunFailedError` if a stage that was reached went wrong; return the stages.

        Parameters
        ----------
        container : str
            Container that only an unstable simulation lets particles break out of; ``""`` where
            the walls are the user's.
        """
        before = self._begun
        for stage in self.stages:
            known = None if stage.name in self._struck else before
            reason = _what_went_wrong(stage, container, _left(known, stage.particles))
            before = None if self._begun is None else stage.particles
            if reason:
                raise RunFailedError(reason, self.log_tail())
        return self.stages

    def require_complete(self, names: Sequence[str], container: str) -> tuple[StageEnd, ...]:
        """Raise `RunFailedError` unless every stage went well; return the stages.

        Parameters
        ----------
        names : sequence of str
            The stages of the scene, in order.
        container : str
            Container that particles may break out of.
        """
        done = [stage.name for stage in self.require_good(container)]
        if done != list(names):
            stages = ", ".join(done) or "none"
            raise RunFailedError(messages.ENDED_EARLY(stages=stages), self.log_tail())
        return self.stages

    def log_tail(self) -> str:
        """Return the last lines of the solver's log."""
        found = (self.folder / name for name in _LOGS if (self.folder / name).is_file())
        log = next(found, None)
        return "" if log is None else log_tail(log)


def _stage_end(row: Sequence[str]) -> StageEnd:
    name, end, step, time, particles, energy = row
    return StageEnd(name, end, int(step), float(time), int(particles), float(energy))


def _left(before: int | None, after: int) -> str:
    """Return how many particles left the box in a stage, in words."""
    if after == 0:
        return "all particles" if before is None else f"all {before} particles"
    return "particles" if before is None else f"{before - after} of {before} particles"


def _what_went_wrong(stage: StageEnd, container: str, left: str) -> str:
    """Return why a stage did not end as it should, with what may help; empty if it did."""
    name, energy, time = stage.name, stage.kinetic_energy, stage.time
    if not math.isfinite(energy):
        return messages.NOT_FINITE_ENERGY(stage=name, energy=energy)
    if stage.end == "restless":
        return messages.RESTLESS(stage=name, time=time, energy=energy)
    if stage.end == "unloaded":
        return messages.UNLOADED(stage=name, time=time)
    if stage.end == "unstable":
        return messages.UNSTABLE(stage=name, energy=energy)
    if stage.end != "broken":
        return ""
    if container:
        return messages.BROKEN(stage=name, left=left, container=container)
    return messages.LEFT(stage=name, left=left)
