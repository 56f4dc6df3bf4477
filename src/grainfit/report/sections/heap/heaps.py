"""Heaps that runs left behind, as far as they are still there and whole."""

from __future__ import annotations

import base64
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from grainfit.bulk_tests.heap import HeapTest
from grainfit.campaign.store.records import RunRecord
from grainfit.campaign.work_folder import run_folder
from grainfit.errors import NotMeasurableError
from grainfit.evaluation import Evaluation, response_name
from grainfit.measurement.angle_of_repose import (
    AngleOfRepose,
    View,
    angle_of_repose,
    heap_silhouette,
    on_plate,
)
from grainfit.measurement.drawing import Drawing, draw
from grainfit.measurement.particles import Particles, read_dump
from grainfit.work_folder.remeasure import heap_test

#: More than that many particles are not all shown: those deep inside are left out.
_MOST_PARTICLES = 20_000
#: How deep below the surface a particle is seen, in diameters.
_SEEN_DEPTH = 3.0
#: A picture larger than that is none of ours.
_LARGEST_PICTURE = 2_000_000
_PNG = b"\x89PNG\r\n"


@dataclass(frozen=True)
class HeapRun:
    """A finished run of a heap test.

    Parameters
    ----------
    number : int
        Of its parameter set, as in the table of runs.
    evaluation : Evaluation
        What it was asked for.
    record : RunRecord
        The run.
    response, angle : str, float
        Its angle of repose: as it is called among the responses, and its value, degrees.
    folder : Path
        Where its files are, if they are.
    """

    number: int
    evaluation: Evaluation
    record: RunRecord
    response: str
    angle: float
    folder: Path

    @property
    def has_particles(self) -> bool:
        """Whether the particles were kept."""
        return (self.folder / "heap.dump").is_file()


@dataclass(frozen=True)
class Heap:
    """A heap that was read."""

    test: HeapTest
    particles: Particles

    def drawing(self) -> Drawing:
        """Its silhouette from one side."""
        return draw(heap_silhouette(self.particles, 0.0, self.test.setup.plate_radius))

    def measured(self) -> AngleOfRepose | None:
        """Its angle of repose; None when it has none."""
        setup = self.test.setup
        try:
            return angle_of_repose(
                self.particles, self.test.ground, setup.plate_radius, self.test.views
            )
        except NotMeasurableError:
            return None

    def fitted_drawing(self, angle: AngleOfRepose, target: float | None) -> Drawing:
        """Its silhouette with its flanks, from the side where these are as they are on average."""
        view = min(angle.views, key=lambda view: _unlike(view, angle.value))
        silhouette = heap_silhouette(self.particles, view.azimuth, self.test.setup.plate_radius)
        return draw(silhouette, view, target)

    def visible(self) -> Particles:
        """The particles that can be seen from above and from the sides."""
        particles = self.particles
        if len(particles) <= _MOST_PARTICLES:
            return particles
        cells = np.floor(particles.positions[:, :2] / particles.diameter).astype(np.int64)
        _, column = np.unique(cells, axis=0, return_inverse=True)
        tops = np.full(column.max() + 1, -np.inf)
        np.maximum.at(tops, column.ravel(), particles.positions[:, 2])
        depth = tops[column.ravel()] - particles.positions[:, 2]
        shown = particles.select(depth < _SEEN_DEPTH * particles.diameter)
        return shown.select(np.argsort(np.argsort(-shown.positions[:, 2])) < _MOST_PARTICLES)


def heap_runs(
    evaluations: Iterable[Evaluation], runs: Mapping[str, RunRecord], folder: Path
) -> dict[str, list[HeapRun]]:
    """Find the finished runs of every heap test, by name of the test."""
    found: dict[str, list[HeapRun]] = {}
    for number, evaluation in enumerate(evaluations, 1):
        for test, identity in evaluation.runs.items():
            record = runs.get(identity)
            if record is None or not _is_heap(record):
                continue
            known = found.setdefault(test, [])
            name = response_name(test, "angle_of_repose", len(evaluation.runs))
            if name in evaluation.responses:
                angle = evaluation.responses[name].value
                where = run_folder(folder, identity)
                known.append(HeapRun(number, evaluation, record, name, angle, where))
    return found


def read_heap(run: HeapRun) -> Heap | None:
    """Read a heap; None when it is not there any more, or damaged."""
    try:
        test = heap_test(run.record.definition.model["test"])
        heap = on_plate(read_dump(run.folder / "heap.dump"), test.setup.plate_radius)
    except (NotMeasurableError, OSError, KeyError, TypeError, ValueError, AttributeError):
        return None
    return Heap(test, heap) if len(heap) else None


def first_readable(runs: Iterable[HeapRun], tries: int = 5) -> tuple[HeapRun, Heap] | None:
    """Return the first run whose heap can be read."""
    return next(_readable(runs, tries), None)


def _readable(runs: Iterable[HeapRun], tries: int) -> Iterator[tuple[HeapRun, Heap]]:
    kept = (run for run in runs if run.has_particles)
    for run, _ in zip(kept, range(tries), strict=False):
        heap = read_heap(run)
        if heap is not None:
            yield run, heap


def spread(runs: Iterable[HeapRun], count: int) -> list[tuple[HeapRun, Heap]]:
    """Read heaps of different parameters, spread from the lowest angle of repose to the highest."""
    one_each = {
        tuple(run.evaluation.proposal.parameters.values()): run for run in runs if run.has_particles
    }
    kept = sorted(one_each.values(), key=lambda run: run.angle)
    if not kept:
        return []
    angles = np.array([run.angle for run in kept])
    wanted = np.linspace(angles[0], angles[-1], count)
    chosen = np.unique(np.abs(angles - wanted[:, None]).argmin(axis=1))
    return list(_readable((kept[i] for i in chosen), count))


def picture(run: HeapRun) -> str | None:
    """Return the picture that was kept of a heap, as the address of an image in a page."""
    path = run.folder / "heap.png"
    try:
        if path.stat().st_size > _LARGEST_PICTURE:
            return None
        content = path.read_bytes()
    except OSError:
        return None
    if not content.startswith(_PNG):
        return None
    return f"data:image/png;base64,{base64.b64encode(content).decode('ascii')}"


def _is_heap(record: RunRecord) -> bool:
    test = record.definition.model.get("test")
    return isinstance(test, Mapping) and test.get("type") == HeapTest.type


def _unlike(view: View, angle: float) -> float:
    """How far the flanks of a view are from an angle; one that lacks a flank is no example."""
    if view.left is None or view.right is None:
        return np.inf
    return abs(view.left.angle - angle) + abs(view.right.angle - angle)
