"""Calibrate for the laboratory's apparatus by runs of smaller ones, and verify it at full size."""

from __future__ import annotations

import math
import time
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import Executor
from contextlib import closing
from dataclasses import dataclass, field, replace
from pathlib import Path

from grainfit.analysis.modulus_study import MeanResponse
from grainfit.analysis.size_study import SizePlan, SizesOfTest, simulate_sizes
from grainfit.analysis.size_trend import Prediction, together
from grainfit.calibration.timeouts import default_timeouts
from grainfit.calibration.twins import SizeRatio, Twins
from grainfit.calibration_file import messages
from grainfit.calibration_file.twins import MOST_SERIES, SEEDS, first_twins, sizes_at_answer
from grainfit.campaign.batch import simulate_batch
from grainfit.campaign.campaign import CampaignOptions
from grainfit.campaign.folder_lock import hold
from grainfit.campaign.open_campaign import open_campaign
from grainfit.campaign.reuse import needed_responses
from grainfit.campaign.store.store import RunStore
from grainfit.campaign.work_folder import RESULT_NAME
from grainfit.errors import StoreError
from grainfit.evaluation import Evaluation, Proposal, response_name
from grainfit.formatting import in_a_row
from grainfit.problem import Problem
from grainfit.result import Result, RunCounts
from grainfit.solvers.base import Solver
from grainfit.student import NORMAL_QUANTILE
from grainfit.verdict.reasons import FullSizeFailed, FullSizeMade

#: Most runs at full size.
_MOST_FULL = 3


@dataclass(frozen=True)
class RealSizeOptions:
    """Options of `RealSizeCalibration`.

    Parameters
    ----------
    confidence : float
        Demanded probability that every target is met.
    workers : int
        Runs at a time.
    timeouts : mapping of str to float
        Longest wall time of a run by name of the test, s, where one is given.
    executor : Executor, optional
        Executor of the runs, such as the nodes of a cluster; by default this machine.
    full_size : bool
        Make one run of each real test at the answer. Without it, those that are known count.
    on_phase : callable, optional
        Called with a sentence at the beginning of each phase.
    """

    confidence: float
    workers: int = 1
    timeouts: Mapping[str, float] = field(default_factory=dict)
    executor: Executor | None = None
    full_size: bool = False
    on_phase: Callable[[str], None] = lambda _: None


class RealSizeCalibration:
    """A calibration of the laboratory's apparatus that searches in smaller ones.

    Runs of every phase are kept in the work folder: started again, it continues.

    Parameters
    ----------
    problem : Problem
        Parameters and measured targets.
    solvers, twins : mapping of str to Solver
        Of the tests, and of those that have a twin.
    folder : Path
        The work folder.
    search : callable
        Calibrates with some `Twins`.
    options : RealSizeOptions
        Options.
    """

    def __init__(
        self,
        problem: Problem,
        solvers: Mapping[str, Solver],
        twins: Mapping[str, Solver],
        folder: Path,
        search: Callable[[Twins], Result],
        options: RealSizeOptions,
    ) -> None:
        self._problem = problem
        self._solvers = solvers
        self._twins = twins
        self._folder = folder
        self._find = search
        self._options = options
        self._result: Result | None = None
        self._runs = AllRuns(options.workers)
        #: Ratio of each series of sizes, by target.
        self._found: dict[str, list[Prediction]] = {}

    def run(self) -> Result:
        """Search, learn the ratios at the answer, search again; verify what there are runs for.

        Ctrl-C ends it with the last result, as interrupted. The result of an earlier start stays
        as it is, and is returned, if it rests on no fewer runs.

        Raises
        ------
        InputError, SolverNotFoundError, RunFailedError, StoreError
            As `grainfit.calibrate`.
        """
        earlier = self._earlier_result()
        try:
            result = self._all_phases()
        except KeyboardInterrupt:
            if self._result is None:
                self._give_back(earlier)
                raise
            result = self._runs.counted(replace(self._result, status="interrupted"))
        if earlier is None or result.status != "interrupted":
            return result
        has_more = result.runs.total > earlier.runs.total
        is_back = not has_more and self._give_back(earlier)
        return replace(earlier, status="interrupted") if is_back else result

    def _all_phases(self) -> Result:
        twins = first_twins(self._solvers, self._twins, self._problem)
        self._say(messages.FIRST_SEARCH(tests=_in_words(twins)))
        result = self._search(twins)
        twins = replace(twins, first_search=result.identity)
        for _ in range(MOST_SERIES):
            if result.status != "predicted":
                return result
            updated = self._learn(result, twins)
            has_moved = self._has_moved(twins, updated)
            twins = updated
            self._say(messages.NEXT_SEARCH())
            result = self._search(twins)
            if not has_moved:
                break
        return self._verified(result, twins)

    def _earlier_result(self) -> Result | None:
        """Return the result in the work folder, if there is one that can be read."""
        try:
            return Result.from_json(self._folder / RESULT_NAME)
        except StoreError:
            return None

    def _give_back(self, earlier: Result | None) -> bool:
        """Make an earlier result that of the folder again; return whether it is of this search.

        Every start begins with the first search, whose result is another one.
        """
        if earlier is None:
            return False
        folder = self._folder.absolute()
        with hold(folder), closing(RunStore.in_folder(folder)) as store:
            latest, its = store.latest_calibration(), store.calibration(earlier.identity)
            if latest is None or its is None or latest.first_search != its.first_search:
                return False
            store.begin_calibration(its.identity, its.name, its.definition, its.known, its.about)
            store.end_calibration(its.identity, earlier.status)
            earlier.to_json(folder / RESULT_NAME)
        return True

    def _say(self, words: str) -> None:
        self._options.on_phase(words)

    def _search(self, twins: Twins) -> Result:
        found = self._find(twins)
        if found.runs.sizes:
            # Ctrl-C has left the result of an earlier start, with its counts, as it is.
            self._result = found
            return found
        self._result = counted = self._runs.with_search(found)
        if counted.runs != found.runs:
            counted.to_json(self._folder / RESULT_NAME)
        return counted

    # Ratios -----------------------------------------------------------------------------------

    def _learn(self, result: Result, twins: Twins) -> Twins:
        """Return the twins with the ratios of a series of sizes at the answer, and of those before.

        Answers lie beside each other, and an extrapolation is the surer the more runs it has.
        """
        ratios = dict(twins.ratios)
        for name, twin in self._twins.items():
            series = self._series(name, twin, result)
            for target in series.targets:
                one, used = result.responses[target.name], twins.ratios[target.name]
                expected = _of_twin(one.predicted, one.standard_error, used)
                there = _weighed(expected, series.rows[0].responses.get(target.name))
                found = _with_smallest(series, target.name, there).prediction(target)
                if found is not None and found.value * there.mean > 0:
                    known = self._found.setdefault(target.name, [])
                    known.append(found.times(1 / there.mean))
                    ratio = together(known)
                    error = abs(there.mean) * ratio.half_width / NORMAL_QUANTILE
                    ratios[target.name] = SizeRatio(ratio.value, error)
        return replace(twins, ratios=ratios, are_measured=True)

    def _series(self, name: str, twin: Solver, result: Result) -> SizesOfTest:
        solver = self._solvers[name]
        test, small = solver.bulk_test, twin.bulk_test
        assert test is not None, "twins are of bulk tests"
        assert small is not None, "twins are bulk tests"
        times = sizes_at_answer(test, small)
        counts = [round(one * test.number_of_particles) for one in times]
        sizes = in_a_row(f"{count:,}" for count in counts)
        self._say(messages.SIZES_OF(test=name, sizes=sizes, seeds=SEEDS))
        plan = SizePlan(
            {name: solver},
            self._problem,
            result.parameters,
            times,
            1.0,
            SEEDS,
            self._options.workers,
            self._options.timeouts,
            self._options.executor,
        )
        return simulate_sizes(plan, self._folder, on_end=self._runs.add_sizes).tests[0]

    def _has_moved(self, before: Twins, after: Twins) -> bool:
        """Return whether a target moved by more than its tolerance from one ratio to another."""
        targets = {target.name: target for target in self._problem.targets}
        return any(
            abs(ratio.value / before.ratios[name].value - 1) * abs(targets[name].value)
            > targets[name].tolerance
            for name, ratio in after.ratios.items()
        )

    # Full size --------------------------------------------------------------------------------

    def _verified(self, result: Result, twins: Twins) -> Result:
        """Return the verdict by runs of the laboratory's apparatus, as far as there are some."""
        for number in range(1, _MOST_FULL + 1):
            if result.status != "predicted":
                return result
            run = self._full_size_run(number, result, twins)
            if run is None:
                return result
            if run.failures:
                failed = [FullSizeFailed(test, why) for test, why in run.failures.items()]
                return self._keep(replace(result, reasons=(*failed, *result.reasons)))
            made = [_made(name, run.responses[name].value, result) for name in twins.ratios]
            judged = twins.at_full_size(result, self._options.confidence, made)
            if judged.status == "calibrated" or number == _MOST_FULL:
                return self._keep(judged)
            ratios = {one.target: _ratio_at(judged, one.target, twins, result) for one in made}
            self._keep(judged)
            twins = replace(twins, ratios=ratios)
            self._say(messages.NEXT_SEARCH())
            result = self._search(twins)
        return result

    def _full_size_run(self, number: int, result: Result, twins: Twins) -> Evaluation | None:
        """Return one run of each real test at an answer; None where none is to be made."""
        solvers = {name: self._solvers[name] for name in self._twins}
        proposal = Proposal(result.parameters, number, "verification")
        limits = default_timeouts(self._problem, solvers) | dict(self._options.timeouts)
        limits = {name: limit for name, limit in limits.items() if limit < math.inf}
        making = CampaignOptions(
            self._options.workers,
            limits,
            self._options.executor,
            needed=needed_responses(self._problem, self._solvers),
        )
        if not self._options.full_size:
            with open_campaign(solvers, self._folder, making) as campaign:
                runs = campaign.identities(proposal)
                if not all(campaign.is_known(run, name) for name, run in runs.items()):
                    return None
        tests = in_a_row(f"{one.test} ({one.particles:,} particles)" for one in twins.tests)
        self._say(messages.FULL_SIZE_RUN(number=number, tests=tests))
        for name, solver in solvers.items():
            if why := solver.starts_anew(result.parameters):
                self._say(messages.STARTS_ANEW(test=name, why=why))
        [found] = simulate_batch(solvers, [proposal], self._folder, making)
        self._runs.add_sizes([found])
        if len(solvers) == 1 and len(self._solvers) > 1:
            [name] = solvers
            named = {response_name(name, n, 2): one for n, one in found.responses.items()}
            found = replace(found, responses=named)
        return found

    def _keep(self, result: Result) -> Result:
        """Write a result and its status, instead of those of the search."""
        self._result = result = self._runs.counted(result)
        folder = self._folder.absolute()
        with hold(folder), closing(RunStore.in_folder(folder)) as store:
            store.end_calibration(result.identity, result.status)
            result.to_json(folder / RESULT_NAME)
        return result


class AllRuns:
    """Runs of all searches, and those that compare sizes, and the time that they took.

    Parameters
    ----------
    workers : int
        Runs at a time.
    """

    def __init__(self, workers: int) -> None:
        self._workers = workers
        self._started = time.monotonic()
        #: Stage of each run of a search, and whether it failed, by identity.
        self._searched: dict[str, tuple[str, bool]] = {}
        #: Runs of other sizes, and all runs that this start made, with their time, s.
        self._sizes = self._made = 0
        self._simulated_seconds = 0.0
        #: Runs of the warm start of the first search: later ones start from the first.
        self._warm_start: int | None = None

    def add_sizes(self, evaluations: Sequence[Evaluation]) -> None:
        """Count runs that compare sizes, or are at full size."""
        for one in evaluations:
            self._sizes += len(one.runs)
            self._made += len(one.runs) - one.reused
            self._simulated_seconds += one.simulated_seconds

    def with_search(self, result: Result) -> Result:
        """Return the result of one more search with the runs of all."""
        self._made += result.runs.total - result.runs.reused
        self._simulated_seconds += result.utilisation * self._workers * result.wall_seconds
        if self._warm_start is None:
            self._warm_start = result.runs.warm_start_runs
        for one in result.history:
            for test, run in one.runs.items():
                self._searched.setdefault(run, (one.stage, test in one.failures))
        return self.counted(result)

    def counted(self, result: Result) -> Result:
        """Return a result with the runs of all searches and of other sizes, and the whole time."""
        stages = Counter(stage for stage, _ in self._searched.values())
        total = len(self._searched) + self._sizes
        counts = RunCounts(
            **stages,
            failed=sum(failed for _, failed in self._searched.values()),
            reused=total - self._made,
            total=total,
            warm_start_runs=self._warm_start or 0,
            sizes=self._sizes,
        )
        seconds = time.monotonic() - self._started
        share = self._simulated_seconds / (self._workers * max(seconds, 1e-9))
        return replace(result, runs=counts, wall_seconds=seconds, utilisation=min(1.0, share))


def _made(name: str, value: float, result: Result) -> FullSizeMade:
    """Return a run at full size beside the prediction, which has what earlier ones told.

    Its scatter is counted as that of a twin, which is larger.
    """
    one, quality = result.responses[name], result.metamodels.get(name)
    scatter = 0.0 if quality is None else quality.noise
    predicted = one.predicted, NORMAL_QUANTILE * one.standard_error
    return FullSizeMade(name, one.unit, value, NORMAL_QUANTILE * scatter, *predicted)


def _ratio_at(judged: Result, name: str, twins: Twins, result: Result) -> SizeRatio:
    """Return the ratio that follows from a verdict at full size."""
    there = result.responses[name].predicted / twins.ratios[name].value
    found = judged.responses[name]
    value = found.predicted / there if found.predicted * there > 0 else twins.ratios[name].value
    return SizeRatio(value, found.standard_error)


def _of_twin(predicted: float, error: float, ratio: SizeRatio) -> MeanResponse:
    """Return what the metamodel expects of a twin, without the error of the ratio."""
    own = math.sqrt(max(0.0, error**2 - ratio.standard_error**2))
    return MeanResponse(predicted / ratio.value, own / ratio.value)


def _weighed(expected: MeanResponse, found: MeanResponse | None) -> MeanResponse:
    """Return what a metamodel expects and the mean of other runs, weighed by their errors."""
    if found is None or not (found.standard_error and expected.standard_error):
        return expected
    own, other = expected.standard_error**-2, found.standard_error**-2
    mean = (own * expected.mean + other * found.mean) / (own + other)
    return MeanResponse(mean, (own + other) ** -0.5)


def _with_smallest(series: SizesOfTest, target: str, there: MeanResponse) -> SizesOfTest:
    """Return a series whose smallest size is what all runs of the twin lead to expect."""
    first, *others = series.rows
    responses = {**first.responses, target: there}
    return replace(series, rows=(replace(first, responses=responses), *others))


def _in_words(twins: Twins) -> str:
    return in_a_row(
        f"{one.test} ({one.simulated:,} of {one.particles:,} particles)" for one in twins.tests
    )
