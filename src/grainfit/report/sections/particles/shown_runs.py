"""Runs whose particles a report shows, if their files still exist and are intact."""

from __future__ import annotations

import base64
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import product
from pathlib import Path
from statistics import fmean

import numpy as np
from scipy.spatial.distance import cdist

from grainfit.bulk_tests.base import BulkTest
from grainfit.bulk_tests.registry import class_of_test, recreate_test
from grainfit.bulk_tests.view import CanBeShown, RunView, Shown, shown
from grainfit.campaign.store.records import RunRecord
from grainfit.campaign.work_folder import run_folder
from grainfit.errors import InputError, NotMeasurableError
from grainfit.evaluation import (
    Evaluation,
    name_of_test,
    names_of_tests,
    response_name,
    scalars,
)
from grainfit.files import read_within
from grainfit.formatting import number, plain, rounded, with_unit
from grainfit.measurement.particles import Particles
from grainfit.problem import Problem, Target
from grainfit.report import messages
from grainfit.scenes.run_output import RunOutput
from grainfit.work_folder.saved_calibration import SavedCalibration

#: Above this number of particles, those deep inside are not shown.
_MOST_PARTICLES = 20_000
#: Depth below the surface to which particles are shown, in diameters.
_SEEN_DEPTH = 3.0
#: A larger picture is not one of grainfit.
_LARGEST_PICTURE = 2_000_000
_PNG = b"\x89PNG\r\n"


@dataclass(frozen=True)
class ShownRun:
    """A finished run of a bulk test.

    Parameters
    ----------
    number : int
        Of its parameter set, as in the table of runs.
    evaluation : Evaluation
        The evaluation that asked for it.
    record : RunRecord
        The run.
    shown : Shown
        Files and response that its test shows.
    response, value : str, float
        The response shown: its name and its value.
    folder : Path
        Folder of its files, if there is one.
    """

    number: int
    evaluation: Evaluation
    record: RunRecord
    shown: Shown
    response: str
    value: float
    folder: Path

    @property
    def has_particles(self) -> bool:
        """True if the particles were kept."""
        return RunOutput(self.folder).path_of(self.shown.particles).is_file()


def visible(particles: Particles, most: int = _MOST_PARTICLES) -> Particles:
    """Return the particles that can be seen from above and from the sides; of few, all."""
    if len(particles) <= most:
        return particles
    cells = np.floor(particles.positions[:, :2] / particles.diameter).astype(np.int64)
    _, column = np.unique(cells, axis=0, return_inverse=True)
    tops = np.full(column.max() + 1, -np.inf)
    np.maximum.at(tops, column.ravel(), particles.positions[:, 2])
    depth = tops[column.ravel()] - particles.positions[:, 2]
    shown = particles.select(depth < _SEEN_DEPTH * particles.diameter)
    return shown.select(np.argsort(np.argsort(-shown.positions[:, 2])) < most)


def shown_runs(
    evaluations: Iterable[Evaluation], runs: Mapping[str, RunRecord], folder: Path
) -> dict[str, list[ShownRun]]:
    """Find the finished runs of every bulk test that shows something, by name of the test."""
    found: dict[str, list[ShownRun]] = {}
    evaluations = list(evaluations)
    tests = len(names_of_tests(run for evaluation in evaluations for run in evaluation.runs))
    for position, evaluation in enumerate(evaluations, 1):
        for run, identity in evaluation.runs.items():
            record = runs.get(identity)
            shown = None if record is None else _shown(record)
            if record is None or shown is None:
                continue
            test = name_of_test(run)
            known = found.setdefault(test, [])
            name = response_name(test, shown.response, tests)
            if name in evaluation.responses and record.status == "finished":
                # With several seeds, the evaluation has the mean of the runs.
                own = scalars(record.responses).get(shown.response)
                value = (own or evaluation.responses[name]).value
                where = run_folder(folder, identity)
                known.append(ShownRun(position, evaluation, record, shown, name, value, where))
    return found


def _shown(record: RunRecord) -> Shown | None:
    test = class_of_test(record.definition)
    found = shown(test)
    return None if found is None else found.of(record.responses)


def shown_response(runs: Sequence[ShownRun]) -> str:
    """Return the response shown of runs of one test, in words."""
    return plain(runs[0].shown.response.replace("_", " ")) if runs else ""


def shown_target(reading: SavedCalibration, runs: Iterable[ShownRun]) -> Target | None:
    """Return the target of the response shown, at the size that was simulated; None without one."""
    names = {run.response for run in runs}
    found = next((target for target in reading.problem.targets if target.name in names), None)
    return None if found is None else at_simulated_size(found, reading.problem)


def at_simulated_size(target: Target, problem: Problem) -> Target:
    """Return a target as a smaller apparatus would give it, where such a one is simulated."""
    ratio = problem.ratios.get(target.name)
    if ratio is None:
        return target
    uncertainty = None if target.uncertainty is None else target.uncertainty / ratio
    tolerance = target.tolerance / ratio
    return replace(target, value=target.value / ratio, uncertainty=uncertainty, tolerance=tolerance)


def measured(target: Target, problem: Problem, unit: str) -> str:
    """Return a measured value in words; of a smaller apparatus also what it means there.

    Parameters
    ----------
    target : Target
        As of `at_simulated_size`.
    problem : Problem
        With the ratios of the sizes.
    unit : str
        For people.
    """
    ratio = problem.ratios.get(target.name)
    if ratio is None:
        return with_unit(rounded(target.value, target.tolerance), unit)
    real = rounded(ratio * target.value, ratio * target.tolerance)
    return messages.AT_THIS_SIZE(
        here=with_unit(number(target.value, 3), unit), real=with_unit(real, unit)
    )


def runs_to_show(
    reading: SavedCalibration, runs: Sequence[ShownRun], target: Target | None
) -> tuple[list[ShownRun], str]:
    """Return the runs of one test, the best to show first, and a description of that one.

    Parameters
    ----------
    reading : SavedCalibration
        The calibration.
    runs : sequence of ShownRun
        Runs of one test, the oldest first.
    target : Target or None
        Of the response shown.
    """
    answer = reading.result.parameters if reading.result else {}
    response = shown_response(runs)
    verified = [
        run
        for run in runs
        if run.evaluation.proposal.stage == "verification"
        and run.evaluation.proposal.parameters == answer
    ]
    if verified:
        mean = fmean(run.value for run in verified)
        words = f"Of the verification runs, the one whose {response} is nearest to their mean"
        return sorted(verified, key=lambda run: abs(run.value - mean)), words
    if answer:
        point = reading.problem.to_unit(answer)

        def distance(run: ShownRun) -> float:
            at = reading.problem.to_unit(run.evaluation.proposal.parameters)
            return float(np.linalg.norm(at - point))

        return sorted(runs, key=distance), "The run whose parameters are nearest to the answer"
    if target is not None:
        value = target.value
        words = f"The run whose {response} is nearest to the measured one so far"
        return sorted(runs, key=lambda run: abs(run.value - value)), words
    return list(runs[::-1]), "The last run"


def read_view(run: ShownRun) -> RunView | None:
    """Read the end of a run; None when it is missing or damaged."""
    test = recreated(run)
    try:
        return test.view(RunOutput(run.folder)) if isinstance(test, CanBeShown) else None
    except (InputError, NotMeasurableError, OSError):
        return None


def recreated(run: ShownRun) -> BulkTest | None:
    """Return the bulk test of a run; None when its definition is damaged."""
    try:
        return recreate_test(run.record.definition)
    except InputError:
        return None


def first_readable(runs: Iterable[ShownRun], tries: int = 5) -> tuple[ShownRun, RunView] | None:
    """Return the first run whose end can be read."""
    return next(_readable(runs, tries), None)


def _readable(runs: Iterable[ShownRun], tries: int) -> Iterator[tuple[ShownRun, RunView]]:
    kept = (run for run in runs if run.has_particles)
    for run, _ in zip(kept, range(tries), strict=False):
        view = read_view(run)
        if view is not None:
            yield run, view


def at_corners(
    runs: Iterable[ShownRun], problem: Problem, names: Sequence[str]
) -> list[tuple[ShownRun, RunView]]:
    """Read the runs nearest to the corners of the intervals of some parameters.

    Of a single parameter the middle of its interval is a corner, too.
    """
    one_each = {
        tuple(run.evaluation.proposal.parameters.values()): run for run in runs if run.has_particles
    }
    kept = list(one_each.values())
    if not kept:
        return []
    chosen = [parameter for parameter in problem.parameters if parameter.name in names]
    points = np.array(
        [[p.to_unit(run.evaluation.proposal.parameters[p.name]) for p in chosen] for run in kept]
    )
    ends = (0.0, 0.5, 1.0) if len(chosen) == 1 else (0.0, 1.0)
    corners = np.array(list(product(ends, repeat=len(chosen))))
    nearest = dict.fromkeys(cdist(corners, points).argmin(axis=1).tolist())
    return list(_readable((kept[index] for index in nearest), len(nearest)))


def picture(run: ShownRun) -> str | None:
    """Return the kept picture of a run, as the address of an image in a page."""
    path = run.folder / run.shown.picture
    try:
        content = read_within(path, _LARGEST_PICTURE)
    except OSError:
        return None
    if not content.startswith(_PNG):
        return None
    return f"data:image/png;base64,{base64.b64encode(content).decode('ascii')}"
