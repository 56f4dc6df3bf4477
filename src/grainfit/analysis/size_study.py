"""A material in apparatus of several sizes: what changes, and the trend to the real size."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass, field, replace
from pathlib import Path
from statistics import fmean

from grainfit.analysis import messages
from grainfit.analysis.modulus_study import MeanResponse, amount, cell, mean_responses
from grainfit.analysis.size_trend import FEWEST_SIZES, Prediction, predict
from grainfit.bulk_tests.base import BulkTest
from grainfit.bulk_tests.size import growth, resized, size_power
from grainfit.campaign.batch import ExpectedWork, simulate_batch
from grainfit.campaign.campaign import CampaignOptions
from grainfit.errors import InputError, RunFailedError
from grainfit.evaluation import Evaluation, Proposal
from grainfit.formatting import causes, duration, in_unit, plain_interval
from grainfit.one_line import OneLine
from grainfit.problem import Problem, Target
from grainfit.solvers.base import Solver
from grainfit.tables import Summary, TextTable
from grainfit.validation import number_list_faults, plain_tuple, set_plain, whole_number_faults


@dataclass(frozen=True)
class SizePlan:
    """Input of `simulate_sizes`.

    Parameters
    ----------
    solvers : mapping of str to Solver
        By name of the test, each of a bulk test whose apparatus can be resized.
    problem : Problem
        Its targets are the responses to compare, with their tolerances.
    parameters : mapping of str to float
        Values of the free parameters.
    times : sequence of float
        Numbers of particles to simulate, over that of the test.
    to : float
        Number of particles for which the trend is told, over that of the test.
    seeds, workers : int
        Runs of each size, and runs at a time.
    timeouts : mapping of str to float
        Longest wall time of a run by name of the test, s.
    executor : Executor, optional
        Executor of the runs, such as the nodes of a cluster; by default this machine.

    Raises
    ------
    InputError
        A size is not above zero or impossible, there are fewer than two, or a number is below one.
    """

    solvers: Mapping[str, Solver]
    problem: Problem
    parameters: Mapping[str, float]
    times: Sequence[float]
    to: float = 1.0
    seeds: int = 3
    workers: int = 1
    timeouts: Mapping[str, float] = field(default_factory=dict)
    executor: Executor | None = None

    def __post_init__(self) -> None:
        set_plain(self, "seeds", "workers")
        faults = whole_number_faults({"seeds": self.seeds, "workers": self.workers})
        faults += number_list_faults("times", plain_tuple(self.times))
        faults += number_list_faults("to", (self.to,))
        InputError.raise_for(faults)
        given = [*(("times", one) for one in self.times), ("to", self.to)]
        wrong = [(key, one) for key, one in given if not (math.isfinite(one) and one > 0)]
        if wrong:
            key, one = wrong[0]
            faults.append(messages.NO_SIZE.fault(key, given=one))
        elif len(set(self.times)) < FEWEST_SIZES:
            faults.append(messages.FEW_SIZES.fault("times", count=len(set(self.times))))
        InputError.raise_for(faults)

    @property
    def sizes(self) -> tuple[float, ...]:
        """Numbers of particles over that of the test, each once, the smallest first."""
        return tuple(sorted(set(self.times)))

    def test_of(self, name: str) -> BulkTest:
        """Return a test as it was given."""
        test = self.solvers[name].bulk_test
        assert test is not None, "own models have no apparatus"
        return test

    def solver_of(self, name: str, times: float) -> Solver:
        """Return the solver of a test in an apparatus of another size."""
        try:
            return self.solvers[name].of_test(resized(self.test_of(name), times))
        except InputError as error:
            raise InputError(
                messages.IMPOSSIBLE_SIZE.fault("times", test=name, times=times, why=error.reasons)
            ) from None

    def sized_solvers(self) -> dict[tuple[str, float], Solver]:
        """Return the solvers of all tests and sizes.

        Raises
        ------
        InputError
            A test is impossible at one of the sizes.
        """
        return {(n, t): self.solver_of(n, t) for t in self.sizes for n in self.solvers}


@dataclass(frozen=True)
class SizeRow:
    """Responses of one test at one size.

    Parameters
    ----------
    times : float
        Number of particles over that of the test as it was given.
    particles : int
        Their number.
    responses : mapping of str to MeanResponse
        By name of the target; empty if every run failed.
    seconds : float, optional
        Wall time of a run, s: measured, or expected where none was made.
    failures : tuple of str
        Reasons of failed runs, one for each.
    """

    times: float
    particles: int
    responses: Mapping[str, MeanResponse]
    seconds: float | None
    failures: tuple[str, ...] = ()


@dataclass(frozen=True)
class SizesOfTest:
    """Responses of one test at several sizes, and the trend.

    Parameters
    ----------
    name : str
        Name of the test.
    test : BulkTest
        The test as it was given.
    targets : tuple of Target
        Responses that are compared.
    rows : tuple of SizeRow
        The smallest first.
    goal : SizeRow
        The size that the trend is told for, without responses.
    """

    name: str
    test: BulkTest
    targets: tuple[Target, ...]
    rows: tuple[SizeRow, ...]
    goal: SizeRow

    def at(self, times: float) -> SizesOfTest:
        """Return the same with another goal, whose number of particles is not counted."""
        return replace(self, goal=SizeRow(times, 0, {}, None))

    def growth(self, target: Target, times: float) -> float:
        """Return how a response grows by itself, as the width of a heap does."""
        return growth(self.test, target.name.removeprefix(f"{self.name}."), times)

    def prediction(self, target: Target) -> Prediction | None:
        """Return what the trend gives at the goal; None where fewer than two sizes tell."""
        known = [row for row in self.rows if target.name in row.responses]
        found = [row.responses[target.name] for row in known]
        errors = [one.standard_error for one in found]
        if len(known) < FEWEST_SIZES or None in errors:
            return None
        scales = [math.cbrt(row.times) for row in known]
        growths = [self.growth(target, row.times) for row in known]
        free = [one.mean / g for one, g in zip(found, growths, strict=True)]
        sure = [float(e or 0.0) / g for e, g in zip(errors, growths, strict=True)]
        least = 1e-9 * (max(map(abs, free), default=1.0) or 1.0)
        trend = predict(scales, free, [max(e, least) for e in sure], math.cbrt(self.goal.times))
        return trend.times(self.growth(target, self.goal.times))

    def table(self, seeds: int) -> TextTable:
        """Return the responses at every size, and those of the trend."""
        header = ("particles", *(target.name for target in self.targets), "a run")
        rows = [
            (
                str(row.particles),
                *(cell(row.responses.get(target.name)) for target in self.targets),
                _time(row.seconds),
            )
            for row in self.rows
        ]
        predicted = [self.prediction(target) for target in self.targets]
        cells = ["-" if p is None else plain_interval(p.value, p.half_width) for p in predicted]
        rows.append((f"{self.goal.particles} (trend)", *cells, _time(self.goal.seconds)))
        units = [in_unit(t.name, t.unit) for t in self.targets if t.unit]
        errors = f"± standard error of the mean of {seeds} seeds; of the trend, 95 % interval"
        return TextTable(header, tuple(rows), ", ".join([*units, errors]))

    def sentences(self) -> Iterator[str]:
        """Yield what the size changes beyond the tolerance, and what stays uncertain."""
        first = self.rows[0]
        for target in self.targets:
            found, here = self.prediction(target), first.responses.get(target.name)
            if found is None or here is None:
                yield messages.NO_TREND(test=self.name, response=target.name)
                continue
            grown = self.growth(target, self.goal.times) / self.growth(target, first.times)
            change = found.value - here.mean * grown
            tolerance = amount(target.tolerance, target)
            if found.half_width > target.tolerance:
                yield messages.SIZE_IN_DOUBT(
                    response=target.name,
                    particles=self.goal.particles,
                    half=amount(found.half_width, target),
                    tolerance=tolerance,
                )
            elif abs(change) > target.tolerance:
                yield messages.SIZE_MATTERS(
                    response=target.name,
                    particles=self.goal.particles,
                    change=amount(change, target),
                    first=first.particles,
                    tolerance=tolerance,
                )


@dataclass(frozen=True)
class SizeStudy(Summary, OneLine):
    """Responses of a material in apparatus of several sizes.

    Parameters
    ----------
    tests : tuple of SizesOfTest
        One for each test.
    parameters : mapping of str to float
        Values of the free parameters.
    seeds : int
        Runs of each size.
    """

    tests: tuple[SizesOfTest, ...]
    parameters: Mapping[str, float]
    seeds: int

    def summary(self) -> tuple[str | TextTable, ...]:
        """Return the tables and the sentences that `print` and a notebook show."""
        parts: list[str | TextTable] = []
        for test in self.tests:
            parts += [f"Test {test.name}", test.table(self.seeds), *test.sentences()]
            failures = causes(why for row in test.rows for why in row.failures)
            parts += [f"A run failed: {why}" for why in failures]
        return tuple(parts)


def simulate_sizes(
    plan: SizePlan,
    folder: Path,
    on_start: Callable[[ExpectedWork], None] | None = None,
    on_progress: Callable[[int, int], None] | None = None,
    on_end: Callable[[Sequence[Evaluation]], None] | None = None,
) -> SizeStudy:
    """Simulate a material in apparatus of several sizes, or find the runs in the store.

    Parameters
    ----------
    plan : SizePlan
        Tests, parameters, sizes and seeds.
    folder : Path
        Work folder that keeps the runs; after Ctrl-C, another call continues.
    on_start, on_progress : callable, optional
        See `simulate_batch`.
    on_end : callable, optional
        Called with all runs, failed ones included.

    Raises
    ------
    InputError
        A test is impossible at a size.
    RunFailedError
        No run has a response that is compared.
    SolverNotFoundError
        A program is not found.
    StoreError
        The folder cannot be used.
    """
    sized = plan.sized_solvers()
    labels = {f"{name}, size {plan.sizes.index(t) + 1}": (name, t) for name, t in sized}
    solvers = {label: sized[key] for label, key in labels.items()}
    needed = {label: {*plan.problem.targets_of(name)} for label, (name, _) in labels.items()}
    timeouts = {
        label: max(solver.default_timeout(plan.parameters) or 0.0, plan.timeouts.get(key[0], 0.0))
        for (label, solver), key in zip(solvers.items(), labels.values(), strict=True)
    }
    proposals = [Proposal(plan.parameters, seed, "design") for seed in range(1, plan.seeds + 1)]
    evaluations = simulate_batch(
        solvers,
        proposals,
        folder,
        CampaignOptions(plan.workers, timeouts, plan.executor, needed=needed),
        on_start,
        on_progress,
    )
    if on_end is not None:
        on_end(evaluations)
    by_key = {key: label for label, key in labels.items()}
    tests = tuple(_sizes_of(plan, name, by_key, evaluations) for name in plan.solvers)
    if not any(row.responses for test in tests for row in test.rows):
        reasons = [why for test in tests for row in test.rows for why in row.failures]
        raise RunFailedError(
            reasons[0] if reasons else messages.NO_RESPONSES(runs=len(sized) * plan.seeds)
        )
    return SizeStudy(tests, dict(plan.parameters), plan.seeds)


def _sizes_of(
    plan: SizePlan,
    name: str,
    labels: Mapping[tuple[str, float], str],
    evaluations: Sequence[Evaluation],
) -> SizesOfTest:
    test, targets = plan.test_of(name), plan.problem.targets_of(name)
    compared = {n: t for n, t in targets.items() if size_power(test, n) is not None}
    values = {
        target.name: {
            times: [
                found.value
                for e in evaluations
                if (found := e.responses.get(f"{labels[name, times]}.{response}"))
            ]
            for times in plan.sizes
        }
        for response, target in compared.items()
    }
    means = {
        target.name: _means(
            values[target.name], {times: growth(test, response, times) for times in plan.sizes}
        )
        for response, target in compared.items()
    }
    rows = tuple(
        SizeRow(
            times,
            resized(test, times).number_of_particles,
            {n: found[times] for n, found in means.items() if times in found},
            _seconds(evaluations, label),
            tuple(e.failures[label] for e in evaluations if label in e.failures),
        )
        for times, label in ((times, labels[name, times]) for times in plan.sizes)
    )
    return SizesOfTest(name, test, tuple(compared.values()), rows, _goal(plan, name))


def _means(
    groups: Mapping[float, Sequence[float]], grown: Mapping[float, float]
) -> dict[float, MeanResponse]:
    """Return the means; scatter grows like the response."""
    free = {times: [v / grown[times] for v in values] for times, values in groups.items()}
    return {
        times: MeanResponse(
            one.mean * grown[times],
            None if one.standard_error is None else one.standard_error * grown[times],
        )
        for times, one in mean_responses(free).items()
    }


def _seconds(evaluations: Sequence[Evaluation], label: str) -> float | None:
    known = [e.test_seconds[label] for e in evaluations if label in e.test_seconds]
    return fmean(known) if known else None


def _goal(plan: SizePlan, name: str) -> SizeRow:
    """Return the size of the trend, with the expected time of a run."""
    try:
        cost = plan.solver_of(name, plan.to).estimate_cost(plan.parameters)
        count = resized(plan.test_of(name), plan.to).number_of_particles
    except InputError:
        count = round(plan.to * plan.test_of(name).number_of_particles)
        return SizeRow(plan.to, count, {}, None)
    return SizeRow(plan.to, count, {}, None if cost is None else cost.wall_seconds)


def _time(seconds: float | None) -> str:
    return "-" if seconds is None else duration(seconds)
