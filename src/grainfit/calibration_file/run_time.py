"""Time that a calibration will take, what would stop its runs, and what would shorten days."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass

from grainfit.bulk_tests.abilities import user_functions
from grainfit.bulk_tests.base import BulkTest
from grainfit.bulk_tests.coarse_graining import coarse_grained, factor_words, sized_for
from grainfit.bulk_tests.sensitivities import MODULUS
from grainfit.calibration_file.build import CalibrationSetup
from grainfit.errors import InputError
from grainfit.formatting import duration, number
from grainfit.solvers.base import Solver
from grainfit.strategies.budget import start_search
from grainfit.verdict.options import VERDICT

#: From this time on, a calibration is worth shortening, s.
_LONG = 86_400.0
#: Largest share of the time that is worth a sentence.
_WORTH_IT = 0.8
#: Excess of bulk densities from overlaps that the offered modulus leaves.
_TOLERATED_EXCESS = 0.02
_COARSER = 2.0
#: Largest number of runs after the design, over the usual one.
_MOST = 4
_DAY = 86_400.0
#: Time from which on only hours are told, s.
_HOURS = 36_000.0


@dataclass(frozen=True)
class ExpectedRuns:
    """Expected number of runs of a calibration.

    Parameters
    ----------
    design, after : int
        Runs of the design, and the usual number after it, verification included.
    verification : int
        Fewest runs with fresh seeds, part of those after the design.
    strategy : str
        Name of the strategy.
    limit : int, optional
        Budget.
    """

    design: int
    after: int
    verification: int
    strategy: str
    limit: int | None

    @property
    def most_after(self) -> int:
        """Largest usual number of runs after the design."""
        return _MOST * self.after

    @property
    def total(self) -> tuple[int, int]:
        """Smallest and largest usual number of runs in all, within the budget."""
        most = self.limit or math.inf
        return (
            int(min(self.design + self.after, most)),
            int(min(self.design + self.most_after, most)),
        )


def expected_runs(setup: CalibrationSetup) -> ExpectedRuns:
    """Return the expected number of runs.

    Raises
    ------
    InputError
        The options of the strategy do not fit the problem.
    """
    strategy = setup.strategy
    verification = strategy.verification_runs or VERDICT.fresh_seeds
    runs_per_set = sum(setup.repeats.values())
    search = start_search(
        strategy.strategy,
        setup.problem,
        runs_per_set,
        seed=1,
        max_runs=strategy.max_runs,
        verification_runs=verification,
    )
    # Runs of an evaluation of one test, on average.
    each = runs_per_set / len(setup.repeats)
    left = math.ceil((search.expected_left - search.runs_of_design) * each)
    return ExpectedRuns(
        math.ceil(search.runs_of_design * each),
        max(left, verification * runs_per_set),
        verification * runs_per_set,
        search.name,
        strategy.max_runs,
    )


@dataclass(frozen=True)
class RunTime:
    """Expected time of a calibration.

    Parameters
    ----------
    runs : ExpectedRuns
        Expected number of runs.
    per_run : mapping of str to float
        Estimated wall time of a run by name of the test, s.
    repeats : mapping of str to int
        Runs of an evaluation by name of the test.
    workers : int
        Runs at a time.
    """

    runs: ExpectedRuns
    per_run: Mapping[str, float]
    repeats: Mapping[str, int]
    workers: int

    @property
    def seconds(self) -> tuple[float, float]:
        """Smallest and largest usual wall time in all, s."""
        weights = self.repeats
        mean = sum(weights[test] * s for test, s in self.per_run.items()) / sum(weights.values())
        low, high = (math.ceil(runs / self.workers) * mean for runs in self.runs.total)
        return low, high

    @property
    def is_long(self) -> bool:
        """Whether it may take a day or more."""
        return self.seconds[1] >= _LONG

    def __str__(self) -> str:
        low, high = map(_in_words, self.seconds)
        return f"about {low}" if low == high else f"about {low} to {high}"


def run_time(setup: CalibrationSetup, runs: ExpectedRuns) -> RunTime | None:
    """Return the expected time of a calibration; None if the cost of a test is not known.

    Parameters
    ----------
    setup : CalibrationSetup
        The calibration; costs are those in the middle of its intervals.
    runs : ExpectedRuns
        Expected number of runs.
    """
    per_run: dict[str, float] = {}
    for test, solver in setup.solvers.items():
        seconds = _seconds(solver, setup.problem.middle)
        if seconds is None:
            return None
        per_run[test] = seconds
    return RunTime(runs, per_run, setup.repeats, setup.workers)


def timeout_notes(setup: CalibrationSetup) -> Iterator[str]:
    """Yield a note on each test whose runs would be stopped before their estimated end.

    Parameters
    ----------
    setup : CalibrationSetup
        The calibration; costs are those in the middle of its intervals, as far as they are known.
    """
    for test, limit in setup.file.timeouts.items():
        seconds = _seconds(setup.solvers[test], setup.problem.middle)
        if seconds is not None and limit < seconds:
            yield (
                f"Test {test}: timeout = {duration(limit)}, but a run takes about "
                f"{duration(seconds)} and would be stopped before its end. Leave timeout out, or "
                "give several times as much."
            )


def shortening_notes(setup: CalibrationSetup, time: RunTime) -> Iterator[str]:
    """Yield what would shorten a calibration that takes days, each with the time it would take.

    Parameters
    ----------
    setup : CalibrationSetup
        The calibration.
    time : RunTime
        Its expected time.
    """
    if not time.is_long:
        return
    offers = [*_usual_size(setup), *_softer(setup), *_coarser(setup)]
    shorter = []
    for words, seconds in offers:
        faster = RunTime(time.runs, {**time.per_run, **seconds}, time.repeats, time.workers)
        if faster.seconds[1] <= _WORTH_IT * time.seconds[1]:
            shorter.append(f"with {words}, it would take {faster}")
    words = f"The calibration takes {time}"
    yield f"{words}. " + (
        f"Shorter: {'; '.join(shorter)}."
        if shorter
        else "More workers shorten it: a computer with more cores, or a cluster (docs/clusters.md)."
    )


def _usual_size(setup: CalibrationSetup) -> Iterator[tuple[str, Mapping[str, float]]]:
    """Offer the usual dimensions of tests that are given larger ones."""
    for name, solver, test in _known_tests(setup):
        try:
            usual = sized_for(type(test), test.sizes)
            seconds = solver.estimate_cost_of(usual, _material(setup, solver)).wall_seconds
        except (InputError, TypeError):
            continue
        if seconds > _WORTH_IT * time_of(setup, solver):
            continue
        words = (
            f"the usual dimensions of the {test.type} test ({usual.number_of_particles} "
            f"particles), measured in an apparatus of that size"
        )
        yield words, {name: seconds}


def _softer(setup: CalibrationSetup) -> Iterator[tuple[str, Mapping[str, float]]]:
    """Offer the softest particles whose overlaps hardly change a response."""
    modulus = setup.file.fixed.get(MODULUS)
    tests = list(_known_tests(setup))
    if modulus is None or not tests:
        return
    try:
        needed = max(
            modulus
            * test.overlap_law.number_with(_TOLERATED_EXCESS)
            / test.stiffness_number(_material(setup, solver))
            for _, solver, test in tests
        )
        if needed >= _WORTH_IT * modulus or any(_refuses(setup, needed, *one) for one in tests):
            return
        seconds = {
            name: solver.estimate_cost_of(
                test, {**_material(setup, solver), MODULUS: needed}
            ).wall_seconds
            for name, solver, test in tests
        }
    except InputError:
        return
    words = (
        f"{MODULUS} = {number(needed / 1e6, 2)} MPa, whose overlaps add "
        f"{100 * _TOLERATED_EXCESS:.0f} % to bulk densities"
    )
    yield words, seconds


def _coarser(setup: CalibrationSetup) -> Iterator[tuple[str, Mapping[str, float]]]:
    """Offer fewer, larger particles in the same apparatus."""
    coarser: dict[str, BulkTest] = {}
    seconds: dict[str, float] = {}
    for name, solver, test in _known_tests(setup):
        try:
            material = _material(setup, solver)
            coarser[name] = coarse_grained(test, _COARSER, material)
            cost = solver.estimate_cost_of(coarser[name], material)
        except InputError:
            # All tests have the same particles.
            return
        seconds[name] = cost.wall_seconds
    if seconds:
        words = (
            f"{factor_words(coarser)}, fewer and larger particles in the same apparatus "
            "(docs/coarse_graining.md)"
        )
        yield words, seconds


def _known_tests(setup: CalibrationSetup) -> Iterator[tuple[str, Solver, BulkTest]]:
    """Yield the bulk tests without code of the user."""
    for name, solver in setup.solvers.items():
        test = solver.bulk_test
        if test is not None and not user_functions(test):
            yield name, solver, test


def _refuses(
    setup: CalibrationSetup, modulus: float, _name: str, solver: Solver, test: BulkTest
) -> bool:
    """Return whether a test means nothing with particles of a Young's modulus."""
    return any(test.material_faults({**_material(setup, solver), MODULUS: modulus}))


def _material(setup: CalibrationSetup, solver: Solver) -> dict[str, float]:
    return solver.run_parameters(setup.problem.middle)


def time_of(setup: CalibrationSetup, solver: Solver) -> float:
    """Return the estimated wall time of a run, s; infinite if it is not known."""
    seconds = _seconds(solver, setup.problem.middle)
    return math.inf if seconds is None else seconds


def _seconds(solver: Solver, middle: Mapping[str, float]) -> float | None:
    try:
        cost = solver.estimate_cost(middle)
    except InputError:
        # The check says why.
        return None
    return None if cost is None else cost.wall_seconds


def _in_words(seconds: float) -> str:
    if seconds >= 2 * _DAY:
        return f"{seconds / _DAY:.0f} days"
    if seconds >= _HOURS:
        # Minutes of such an estimate would say nothing.
        return f"{seconds / 3600:.0f} h"
    return duration(seconds)
