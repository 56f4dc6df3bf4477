"""Places of walls over a run: from the motions of its stages, and from what was recorded."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from grainfit.errors import NotMeasurableError
from grainfit.scenes.records import Travel
from grainfit.scenes.run_output import RunOutput, StageEnd
from grainfit.scenes.scene import Load, Motion, Scene, Stage

Travels = NDArray[np.float64]


@dataclass(frozen=True)
class StageSpan:
    """Time of a stage in a run.

    Parameters
    ----------
    stage : Stage
        The stage.
    begin, end : float
        Simulated times, s; the end is infinite if the run stopped in it.
    outcome : str
        How it ended, as `StageEnd.end`; empty if the run stopped in it.
    """

    stage: Stage
    begin: float
    end: float
    outcome: str = ""


@dataclass(frozen=True)
class WallTravel:
    """Places of one wall at some times.

    Parameters
    ----------
    travels : ndarray
        Distance that it has moved along the axis of its motions since it was put, m; of a wall that
        turns, the angle, rad. Not a number where the wall is not there, or its place is unknown.
    motion : Motion, optional
        One of its motions, which all have one axis; None if it never moves.
    unknown : tuple of str
        Stages in which its place is unknown.
    """

    travels: Travels
    motion: Motion | None
    unknown: tuple[str, ...]


def stage_spans(scene: Scene, ends: Sequence[StageEnd]) -> list[StageSpan]:
    """Return the stages that a run has reached, with their times."""
    spans: list[StageSpan] = []
    begin = 0.0
    for number, stage in enumerate(scene.stages):
        if number >= len(ends):
            went_on = not ends or ends[-1].end in ("at_rest", "done")
            return [*spans, StageSpan(stage, begin, np.inf)] if went_on else spans
        end = ends[number]
        spans.append(StageSpan(stage, begin, end.time, end.end))
        begin = end.time
    return spans


def wall_travels(scene: Scene, run: RunOutput, times: Travels) -> dict[str, WallTravel]:
    """Return the places of all walls of a scene, by name.

    Constant velocities follow from the beginning of their stage. Walls under a load are where the
    series of the stage has them, if it records their travel.

    Parameters
    ----------
    scene : Scene
        The scene of the run.
    run : RunOutput
        Its output.
    times : ndarray
        Simulated times, s, ascending. At the end of a stage, the next one has not begun.
    """
    spans = stage_spans(scene, run.ends)
    return {name: _travel(scene, run, spans, name, times) for name in scene.all_walls()}


def _travel(
    scene: Scene, run: RunOutput, spans: Sequence[StageSpan], name: str, times: Travels
) -> WallTravel:
    found = np.full(len(times), np.nan)
    place = 0.0
    unknown = []
    for span in _with_wall(scene, spans, name):
        now = (times > span.begin) & (times <= span.end)
        if span is spans[0]:
            now |= times <= span.begin
        motion = next(iter(span.stage.motions_of(name)), None)
        path, place = _path(run, span, name, motion, place, times[now])
        found[now] = path
        if np.isnan(path).any():
            unknown.append(span.stage.name)
    return WallTravel(found, next(scene.motions_of(name), None), tuple(unknown))


def _with_wall(scene: Scene, spans: Sequence[StageSpan], name: str) -> Iterator[StageSpan]:
    """Iterate over the stages in which a wall is there."""
    is_there = name in scene.walls
    for span in spans:
        is_there = (is_there or name in span.stage.put) and name not in span.stage.take_away
        if is_there:
            yield span


def _path(
    run: RunOutput,
    span: StageSpan,
    name: str,
    motion: Motion | None,
    place: float,
    times: Travels,
) -> tuple[Travels, float]:
    """Return the places of a wall at times of a stage, and the place at its end."""
    if motion is None:
        return np.full(len(times), place), place
    if not isinstance(motion, Load):
        return place + motion.speed * (times - span.begin), (
            place + motion.speed * (span.end - span.begin)
        )
    recorded = _recorded(run, span.stage, name)
    if recorded is None:
        return np.full(len(times), np.nan), np.nan
    at, travel = recorded
    if np.isfinite(place) and at[0] > span.begin:
        at, travel = np.append(span.begin, at), np.append(place, travel)
    return np.interp(times, at, travel), float(travel[-1])


def _recorded(run: RunOutput, stage: Stage, name: str) -> tuple[Travels, Travels] | None:
    """Return times and travels of a wall from the series of a stage; None if it has none."""
    columns = {} if stage.series is None else stage.series.columns
    found = [
        column
        for column, quantity in columns.items()
        if isinstance(quantity, Travel) and quantity.wall == name
    ]
    if not found:
        return None
    try:
        series = run.series(stage.name, found[:1])
    except NotMeasurableError:
        return None
    return (series["time"], series[found[0]]) if len(series["time"]) else None
