"""Simulate candidate tests at a few parameter sets, and find the slopes of their responses."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

from grainfit.campaign.batch import ExpectedWork, simulate_batch
from grainfit.campaign.campaign import CampaignOptions
from grainfit.errors import InputError
from grainfit.evaluation import Evaluation, Proposal, response_name
from grainfit.formatting import counted
from grainfit.solvers.base import Solver
from grainfit.validation import as_number, set_plain, whole_number_faults
from grainfit.which_test import messages
from grainfit.which_test.available import AvailableTests
from grainfit.which_test.candidate import AccuracyOf, Candidate, seconds_of
from grainfit.which_test.slopes import Cloud, Run, simulated_response

#: Seeds of each parameter set: by default, and most where the time allows more.
SEEDS, MOST_SEEDS = 2, 4
Points = Sequence[Mapping[str, float]]


class Simulated(NamedTuple):
    """Simulated candidate tests, sentences about them, and the seeds of each parameter set."""

    candidates: list[Candidate]
    remarks: list[str]
    seeds: int


def require_simulated(simulate: bool, **given: object) -> None:
    """Raise `InputError` that names options of simulated trials where nothing is simulated."""
    names = [name for name, value in given.items() if value is not None and not simulate]
    InputError.raise_for([messages.NOTHING_SIMULATED.fault(name) for name in names])


@dataclass(frozen=True)
class Simulation:
    """Options for simulating candidate tests.

    Parameters
    ----------
    folder : Path
        Work folder that keeps the runs.
    workers, seeds, max_seconds, on_start, on_progress
        As for `grainfit.work_folder.advice.advise`.

    Raises
    ------
    InputError
        A number is impossible.
    """

    folder: Path
    workers: int
    seeds: int | None = None
    max_seconds: float | None = None
    on_start: Callable[[ExpectedWork], None] | None = None
    on_progress: Callable[[int, int], None] | None = None

    def __post_init__(self) -> None:
        set_plain(self, "seeds", "workers")
        counts = {} if self.seeds is None else {"seeds": self.seeds}
        faults = whole_number_faults({**counts, "workers": self.workers})
        if self.max_seconds is not None and not as_number(self.max_seconds) > 0:
            faults.append(messages.NO_TIME.fault("max_seconds", given=self.max_seconds))
        InputError.raise_for(faults)

    def seeds_for(self, solvers: Mapping[str, Solver], points: Points) -> int:
        """Return the seeds of each parameter set: as given, or as many as the time allows."""
        if self.seeds is not None or self.max_seconds is None:
            return self.seeds or SEEDS
        seconds = sum(seconds_of(s, point) for s in solvers.values() for point in points)
        affordable = self.max_seconds * self.workers / max(seconds, 1e-9)
        return int(min(max(affordable, 1), MOST_SEEDS))

    def run(self, solvers: Mapping[str, Solver], points: Points) -> list[Evaluation]:
        """Simulate parameter sets in every test, with the same seeds at all of them."""
        seeds = range(1, self.seeds_for(solvers, points) + 1)
        # All points with one seed first: when the time is over, every direction has been seen.
        proposals = [Proposal(point, seed, "design") for seed in seeds for point in points]
        timeouts = {name: _timeout(solver, points) for name, solver in solvers.items()}
        known = {name: seconds for name, seconds in timeouts.items() if seconds is not None}
        return simulate_batch(
            solvers,
            proposals,
            self.folder,
            CampaignOptions(self.workers, known),
            self.on_start,
            self.on_progress,
            self.max_seconds,
        )

    def candidates(
        self, tests: AvailableTests, cloud: Cloud, points: Points, accuracy_of: AccuracyOf
    ) -> Simulated:
        """Simulate tests and find the slopes of their responses.

        Parameters
        ----------
        tests : AvailableTests
            The tests.
        cloud, points, accuracy_of
            As for `candidates_from_runs`.
        """
        evaluations = self.run(tests.solvers, points)
        found, failed = candidates_from_runs(tests.solvers, cloud, points, evaluations, accuracy_of)
        usable = tests.without(failed)
        remarks = [*usable.remarks(), *failure_remarks(usable.solvers, evaluations)]
        return Simulated(found, remarks, self.seeds_for(tests.solvers, points))


def _timeout(solver: Solver, points: Points) -> float | None:
    found = [solver.default_timeout(point) for point in points]
    return max((seconds for seconds in found if seconds is not None), default=None)


def candidates_from_runs(
    solvers: Mapping[str, Solver],
    cloud: Cloud,
    points: Points,
    evaluations: Sequence[Evaluation],
    accuracy_of: AccuracyOf,
) -> tuple[list[Candidate], dict[str, str]]:
    """Return the simulated tests with their slopes, and reasons for those that have none.

    Parameters
    ----------
    solvers : mapping of str to Solver
        The tests, by name.
    cloud : Cloud
        Parameter sets among which they are to decide.
    points : sequence of mapping of str to float
        Simulated parameter sets.
    evaluations : sequence of Evaluation
        Runs at these points.
    accuracy_of : callable
        Accuracies of the responses.
    """
    numbers = {tuple(point.values()): i for i, point in enumerate(points)}
    where = cloud.relative(points)
    found, failed = [], {}
    for test, solver in solvers.items():
        assert solver.bulk_test is not None, "only bulk tests are available"
        responses = []
        for name, info in solver.bulk_test.responses.items():
            key = response_name(test, name, len(solvers))
            runs = [
                Run(numbers[tuple(made.parameters.values())], made.seed, e.responses[key].value)
                for e in evaluations
                if key in e.responses and (made := e.proposal)
            ]
            if (accuracy := accuracy_of(test, name, info)) is not None:
                full = f"{test}.{name}"
                responses.append(simulated_response(full, accuracy, cloud, where, runs, info.unit))
        known = tuple(response for response in responses if response is not None)
        if known:
            found.append(Candidate(test, seconds_of(solver, points[0]), known))
        else:
            failed[test] = _why_failed(test, evaluations)
    return found, failed


def failure_remarks(tests: Collection[str], evaluations: Sequence[Evaluation]) -> list[str]:
    """Return sentences about tests that are compared although some of their runs failed.

    A run without one of its responses has failed as a whole.
    """
    remarks = []
    for test in tests:
        reasons = [e.failures[test] for e in evaluations if test in e.failures]
        if reasons:
            share = f"{len(reasons)} of {counted(len(evaluations), 'run')}"
            reason = reasons[0]
            remarks.append(messages.RUNS_DO_NOT_COUNT(test=test, share=share, reason=reason))
    return remarks


def _why_failed(test: str, evaluations: Sequence[Evaluation]) -> str:
    reasons = [e.failures[test] for e in evaluations if test in e.failures]
    return messages.RUNS_FAILED(reason=reasons[0]) if reasons else messages.TOO_FEW_RUNS()
