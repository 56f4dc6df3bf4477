"""Candidate tests: simulated at a few parameter sets, with the slopes of their responses."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from grainfit.analysis.advice import CandidateTest
from grainfit.analysis.bench import Bench
from grainfit.analysis.slopes import Cloud, Run, simulated_measurable
from grainfit.bulk_tests.accuracy import Accuracy
from grainfit.bulk_tests.base import ResponseInfo
from grainfit.campaign.batch import ExpectedWork, simulate_batch
from grainfit.campaign.campaign import CampaignOptions
from grainfit.checks import as_number, count_faults
from grainfit.errors import Fault, InputError
from grainfit.evaluation import Evaluation, Proposal, response_name
from grainfit.formatting import counted
from grainfit.solvers.base import Solver

#: Seeds of each parameter set: by default, and most where the time allows more.
SEEDS, MOST_SEEDS = 2, 4
#: Returns the accuracy of a response of a test, by their names; None if it is not measured.
AccuracyOf = Callable[[str, str, ResponseInfo], Accuracy | None]


@dataclass(frozen=True)
class Simulation:
    """Options for simulating candidate tests.

    Parameters
    ----------
    folder : Path
        Work folder that keeps the runs.
    workers : int
        Runs at a time.
    seeds : int, optional
        Seeds of each parameter set; by default 2, or as many as ``max_seconds`` allows.
    max_seconds : float, optional
        Wall time after which no more is simulated, s.
    on_start : callable, optional
        Called with the expected work before the first run; it may raise to stop.
    on_progress : callable, optional
        Called with the numbers of finished and of all parameter sets.

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
        counts = {"workers": self.workers}
        if self.seeds is not None:
            counts = {"seeds": self.seeds, **counts}
        faults = count_faults(counts)
        if self.max_seconds is not None and not as_number(self.max_seconds) > 0:
            words = f"is {self.max_seconds!r}."
            faults.append(Fault("max_seconds", words, "Give a time above 0 s."))
        if faults:
            raise InputError(faults)

    def seeds_for(
        self, solvers: Mapping[str, Solver], points: Sequence[Mapping[str, float]]
    ) -> int:
        """Return the seeds of each parameter set: as given, or as many as the time allows."""
        if self.seeds is not None or self.max_seconds is None:
            return self.seeds or SEEDS
        seconds = sum(seconds_of(s, point) for s in solvers.values() for point in points)
        affordable = self.max_seconds * self.workers / max(seconds, 1e-9)
        return int(min(max(affordable, 1), MOST_SEEDS))

    def run(
        self, solvers: Mapping[str, Solver], points: Sequence[Mapping[str, float]]
    ) -> list[Evaluation]:
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

    def compare(
        self,
        bench: Bench,
        cloud: Cloud,
        points: Sequence[Mapping[str, float]],
        accuracy_of: AccuracyOf,
    ) -> Compared:
        """Simulate the tests of a bench and find the slopes of their responses.

        Parameters
        ----------
        bench : Bench
            The tests.
        cloud : Cloud
            Parameter sets among which they are to decide.
        points : sequence of mapping of str to float
            Parameter sets to simulate.
        accuracy_of : callable
            Accuracies of the responses.
        """
        evaluations = self.run(bench.solvers, points)
        found, failed = candidate_tests(bench.solvers, cloud, points, evaluations, accuracy_of)
        usable = bench.without(failed)
        remarks = [*usable.remarks(), *failure_remarks(usable.solvers, evaluations)]
        return Compared(found, remarks, self.seeds_for(bench.solvers, points))


@dataclass(frozen=True)
class Compared:
    """Simulated tests with their slopes.

    Parameters
    ----------
    candidates : list of CandidateTest
        The tests.
    remarks : list of str
        Sentences about other options than the usual ones, refused tests and failed runs.
    seeds : int
        Seeds of each parameter set.
    """

    candidates: list[CandidateTest]
    remarks: list[str]
    seeds: int


def _timeout(solver: Solver, points: Sequence[Mapping[str, float]]) -> float | None:
    found = [solver.default_timeout(point) for point in points]
    return max((seconds for seconds in found if seconds is not None), default=None)


def candidate_tests(
    solvers: Mapping[str, Solver],
    cloud: Cloud,
    points: Sequence[Mapping[str, float]],
    evaluations: Sequence[Evaluation],
    accuracy_of: AccuracyOf,
) -> tuple[list[CandidateTest], dict[str, str]]:
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
        assert solver.bulk_test is not None, "the bench has bulk tests only"
        responses = []
        for name, info in solver.bulk_test.responses.items():
            accuracy = accuracy_of(test, name, info)
            if accuracy is None:
                continue
            key = response_name(test, name, len(solvers))
            runs = [
                Run(
                    numbers[tuple(evaluation.proposal.parameters.values())],
                    evaluation.proposal.seed,
                    evaluation.responses[key].value,
                )
                for evaluation in evaluations
                if key in evaluation.responses
            ]
            seen = simulated_measurable(f"{test}.{name}", accuracy, cloud, where, runs)
            responses += [replace(seen, unit=info.unit)] if seen is not None else []
        if responses:
            found.append(CandidateTest(test, seconds_of(solver, points[0]), tuple(responses)))
        else:
            failed[test] = _why_failed(test, evaluations)
    return found, failed


def seconds_of(solver: Solver, point: Mapping[str, float]) -> float:
    """Return the estimated wall time of a run, s; 0 if it is unknown."""
    cost = solver.estimate_cost(point)
    return 0.0 if cost is None else cost.wall_seconds


def failure_remarks(tests: Collection[str], evaluations: Sequence[Evaluation]) -> list[str]:
    """Return sentences about tests that are compared although some of their runs failed.

    A run without one of its responses has failed as a whole.
    """
    remarks = []
    for test in tests:
        reasons = [e.failures[test] for e in evaluations if test in e.failures]
        if reasons:
            share = f"{len(reasons)} of {counted(len(evaluations), 'run')}"
            remarks.append(
                f"{test}: {share} failed and do not count. The first: {reasons[0].rstrip('.')}."
            )
    return remarks


def _why_failed(test: str, evaluations: Sequence[Evaluation]) -> str:
    reasons = dict.fromkeys(e.failures[test] for e in evaluations if test in e.failures)
    if reasons:
        return f"Its runs failed: {next(iter(reasons)).rstrip('.')}."
    return "Too few of its runs ended in time."
