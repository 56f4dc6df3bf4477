"""Run a calibration: a strategy proposes runs, a campaign executes them."""

from __future__ import annotations

import math
import time
from collections import Counter, deque
from collections.abc import Callable, Collection, Mapping, Sequence
from contextlib import suppress
from dataclasses import asdict, dataclass, replace
from importlib.metadata import version
from itertools import accumulate
from pathlib import Path
from typing import Any

from grainfit.atlas.guide import Guide, guide
from grainfit.calibration import messages
from grainfit.calibration.build_result import Ending, make_result
from grainfit.calibration.expected_deviation import ExpectedDeviation
from grainfit.calibration.failed_runs import fail_by_machine, would_all_fail
from grainfit.calibration.holdout import Material
from grainfit.calibration.intervals import material_of_result, with_intervals
from grainfit.calibration.judged_answer import Demands, JudgedAnswer, judge_by_runs
from grainfit.calibration.live_file import LiveFile
from grainfit.calibration.progress import Progress
from grainfit.calibration.provenance import Provenance
from grainfit.calibration.records_read import RecordsRead
from grainfit.calibration.repetitions import Repetitions
from grainfit.calibration.runs_to_come import RunsSoFar, runs_to_come
from grainfit.calibration.twins import Twins
from grainfit.calibration.warm_start import warm_start
from grainfit.calibration.yield_loci import tests_of_runs, yield_loci
from grainfit.campaign.campaign import Campaign
from grainfit.campaign.near_runs import NearRuns, near_records, near_runs
from grainfit.campaign.reuse import models_of, runs_of
from grainfit.campaign.store.records import CalibrationRecord, RequestRecord, RunRecord
from grainfit.campaign.store.store import RunStore
from grainfit.errors import GrainfitError, RunFailedError, StoreError
from grainfit.evaluation import Evaluation, Proposal, name_of_test
from grainfit.formatting import in_a_row
from grainfit.metamodels.blow_ups import without_blow_ups
from grainfit.metamodels.curve_reduction import about_other_kind, about_short_curves
from grainfit.metamodels.known_runs import nearest_runs
from grainfit.metamodels.metamodels import runs_that_yield
from grainfit.problem import Problem
from grainfit.problem.test_scope import cost_of_relatives, named_test
from grainfit.result import Result
from grainfit.run_definition import identity_of
from grainfit.strategies.answer import Answer
from grainfit.strategies.base import Search
from grainfit.strategies.seeds import insertion_seed
from grainfit.verdict.looks import confidence_after
from grainfit.verdict.options import VERDICT
from grainfit.verdict.reasons import NoRecordThere
from grainfit.verdict.rule import Status

#: Statuses of runs that are not made again.
_ENDED = ("finished", "failed")
#: Of many fresh seeds that are needed, this part is run before the answer is judged again.
_PART = 4


@dataclass(frozen=True)
class LoopOptions:
    """Options of a calibration loop, see `grainfit.calibrate`.

    ``result_file`` is that of the work folder, of an earlier start.
    """

    name: str
    workers: int
    max_runs: int | None
    verification_runs: int
    on_progress: Callable[[Progress], None] | None = None
    provenance: Provenance | None = None
    live_file: LiveFile | None = None
    twins: Twins | None = None
    near_runs: bool = True
    atlas: bool = True
    result_file: Path | None = None


class CalibrationLoop:
    """Loop of proposals and evaluations until the answer is verified.

    The search may run relatives of the tests. The problem of the loop has none: its verdict, its
    intervals and its report rest on runs of the tests alone.
    """

    def __init__(
        self,
        problem: Problem,
        strategy: Search,
        campaign: Campaign,
        store: RunStore,
        options: LoopOptions,
    ) -> None:
        self._problem = problem
        self._strategy = strategy
        self._campaign = campaign
        self._store = store
        self._options = options
        self._evaluations: list[Evaluation] = []
        self._latest_repetitions = Repetitions()
        self._records = RecordsRead(campaign.solvers, campaign.repeats, campaign.folder)
        #: Runs of the warm start.
        self._known: Sequence[Evaluation] = ()
        #: Number of runs of the warm start, by their source.
        self._origins: Mapping[str, int] = {}
        #: Runs of near problems.
        self._near = NearRuns()
        #: What the atlas expects of tests without near runs.
        self._guide = Guide()
        #: How often fresh seeds have been judged.
        self._looks = 0
        #: Numbers of the runs of the verification by their seeds.
        self._fresh_seeds: dict[int, int] = {}
        #: Notices of the search and of the campaign, in the order in which they came.
        self._notices: list[str] = []
        self._taken = (0, 0)
        self._stage = "design"
        self._expected = ExpectedDeviation(problem, strategy)
        self._requested = 0
        #: Requests of earlier starts of this calibration that this start has not reached yet.
        self._recorded: deque[RequestRecord] = deque()
        #: Whether Ctrl-C has left the result of an earlier start as it is.
        self.earlier_stays = False
        #: Number of requests of earlier starts whose runs had ended.
        self._ended_before = 0
        self._started = time.monotonic()
        self._definition = self._define()
        self._identity = identity_of(self._definition)

    def _runs_known_before(self) -> list[Evaluation]:
        """Return the runs for the warm start; a later start uses those of the first start."""
        earlier = self._store.calibration(self._identity)
        if earlier is None:
            solvers = {**self._campaign.solvers, **self._campaign.relatives}
            records = self._store.runs_of(models_of(solvers))
        else:
            records = list(self._store.find_many(earlier.known).values())
        campaign = self._campaign
        self._near = self._near_runs(None if earlier is None else records)
        self._guide = self._guide_of_atlas(earlier)
        known = [runs_of(self._problem, campaign.solvers, records, campaign.repeats)]
        for name, solver in campaign.relatives.items():
            single = replace(self._problem, tests=())
            known.append(runs_of(single, {name: solver}, records, campaign.repeats))
        # Many runs of a relative displace none of the test.
        seed = self._strategy.seed
        chosen = [one for own in known for one in nearest_runs(self._problem, own, seed=seed)]
        used = {run for evaluation in chosen for run in evaluation.runs.values()}
        self._origins = Counter(record.origin for record in records if record.identity in used)
        return chosen

    def _near_runs(self, recorded: Sequence[RunRecord] | None) -> NearRuns:
        """Return the runs of near problems: those of the first start, or of the store."""
        strategy = self._strategy
        if not self._options.near_runs or not strategy.strategy.uses_relatives:
            return NearRuns()
        with_relatives = {one.of for one in strategy.problem.relatives}
        solvers = {n: s for n, s in self._campaign.solvers.items() if n not in with_relatives}
        if recorded is None:
            recorded = near_records(self._store, self._problem, solvers)
        return near_runs(self._problem, solvers, recorded, strategy.seed)

    def _guide_of_atlas(self, earlier: CalibrationRecord | None) -> Guide:
        """Return what the atlas expects of the tests that nothing else guides.

        A later start keeps the guide of the first one, whatever the atlas says since.
        """
        strategy = self._strategy
        if earlier is not None:
            return Guide.from_json(earlier.about.get("atlas", {}))
        if not self._options.atlas or not strategy.strategy.uses_relatives:
            return Guide()
        solvers = self._campaign.solvers
        return guide(strategy.problem, solvers, strategy.seed, self._near.tests)

    def _define(self) -> dict[str, Any]:
        # Another input deck or solver version makes another calibration: the requests of the old
        # one would be misleading. The run at the centre represents all runs.
        problem = self._problem
        sample = Proposal(problem.middle, 1, "design")
        return {
            "tests": self._campaign.identities(sample),
            "parameters": [parameter.to_json() for parameter in self._problem.parameters],
            "targets": [target.to_json() for target in self._problem.targets],
            "strategy": self._strategy.name,
            "seed": self._strategy.seed,
            "options": self._strategy.definition,
            **self._rayleigh(),
            **self._relatives(),
            **({} if self._options.near_runs else {"near_runs": False}),
            **({} if self._options.atlas else {"atlas": False}),
            **({"ratios": dict(problem.ratios)} if problem.ratios else {}),
            **({"correlations": list(problem.correlations)} if problem.correlations else {}),
            **({"curves": [one.to_json() for one in problem.curves]} if problem.curves else {}),
        }

    def _rayleigh(self) -> dict[str, Any]:
        """Return the Rayleigh time step, if any: it influences the answer, too."""
        known = self._problem.rayleigh
        if known is None:
            return {}
        return {"rayleigh": known.to_json(), "rayleigh_weight": self._problem.rayleigh_weight}

    def _relatives(self) -> dict[str, Any]:
        """Return the identities of the relatives' runs, if there are any, and their costs."""
        costs = {one.name: one.cost for one in self._strategy.problem.relatives}
        if not costs:
            return {}
        sample = Proposal(self._problem.middle, 1, "design", tuple(costs))
        return {"relatives": self._campaign.identities(sample), "costs": costs}

    def _about(self, known: Sequence[Evaluation]) -> dict[str, Any]:
        twins = self._options.twins
        return {
            **({"first_search": twins.first_search} if twins and twins.first_search else {}),
            "learnt": [{**asdict(one.proposal), "runs": dict(one.runs)} for one in known],
            "near": self._near.notice,
            "atlas": self._guide.to_json(),
            "version": version("grainfit"),
            "workers": self._options.workers,
            "max_runs": self._options.max_runs,
            "tests": [asdict(scope) for scope in self._problem.tests],
            "scatters": dict(self._problem.scatters),
            "provenance": asdict(self._options.provenance or Provenance()),
        }

    def run(self) -> Result:
        """Run the calibration to its end. Ctrl-C stops it and returns the best result so far.

        While the runs of an earlier start are recalled, that is its result (`earlier_stays`).
        """
        self._begin()
        outcome: JudgedAnswer | None
        status: Status = "interrupted"
        try:
            outcome = self._search_and_verify()
            status = outcome.status
            if status == "calibrated" and self._options.twins is not None:
                status = "predicted"
        except KeyboardInterrupt:
            self._campaign.cancel()
            if earlier := self._better_result:
                self.earlier_stays = True
                self._store.end_calibration(self._identity, earlier.status)
                return replace(earlier, status="interrupted")
            outcome = self._best_so_far()
        except BaseException as error:
            self._campaign.cancel()
            why = str(error) if isinstance(error, GrainfitError) else type(error).__name__
            with suppress(StoreError):
                self._store.end_calibration(self._identity, "failed", why)
            raise
        self._store.end_calibration(self._identity, status)
        if status != "interrupted":
            self._store.forget_requests_behind(self._identity, self._requested)
        return self._result(outcome, status)

    def _begin(self) -> None:
        """Write the start to the store, and recall known runs and requests of earlier starts."""
        recorded = self._requests_of_earlier_starts()
        self._recorded.extend(recorded)
        if recorded:
            ended = {run for run, state in self._store.states().items() if state in _ENDED}
            self._ended_before = sum(ended.issuperset(one.runs.values()) for one in recorded)
        known = self._known = self._runs_known_before()
        runs = [run for evaluation in known for run in evaluation.runs.values()]
        runs += self._near.identities
        self._store.begin_calibration(
            self._identity, self._options.name, self._definition, runs, self._about(known)
        )
        if tests := (*self._near.tests, *self._guide.tests):
            guiding = [*self._near.evaluations, *self._guide.evaluations]
            self._strategy.learn_from_near(guiding, tests)
        self._notices += self._about_guides
        if known:
            warm_start(self._strategy, self._problem, known)
            self._show()
        self._campaign.fetch([run for r in self._recorded for run in r.runs.values()])

    def _result(self, outcome: JudgedAnswer | None, status: Status) -> Result:
        wall_seconds = time.monotonic() - self._started
        ending = Ending(
            self._options.name,
            self._identity,
            wall_seconds,
            self._utilisation(wall_seconds),
            status,
        )
        known_runs = sum(self._origins.values())
        result = make_result(ending, self._strategy, outcome, self._evaluations, known_runs)
        search = [one for one in self._evaluations if one.proposal.stage != "verification"]
        again = self._records.read_again(search)
        result = replace(result, other_notices=(*self._about_guides, *again, *result.other_notices))
        own = self._own_evidence()
        result = with_intervals(result, self._problem, own, self._known, self._campaign.solvers)
        tests = tests_of_runs(self._evaluations, self._store.find_many)
        result = replace(result, yield_loci=yield_loci(self._problem, tests, result.responses))
        twins = self._options.twins
        return result if twins is None else twins.predicted(result, self._strategy.confidence)

    @property
    def _about_guides(self) -> list[str]:
        near = [self._near.notice] if self._near.tests else []
        tests = [named_test(one, self._campaign.solvers) for one in self._guide.tests]
        guided = [messages.GUIDED_BY_ATLAS(tests=in_a_row(tests))] if tests else []
        fault = [messages.WITHOUT_ATLAS(why=self._guide.fault)] if self._guide.fault else []
        return [*near, *guided, *fault]

    def _own_evidence(self) -> list[Evaluation]:
        known = self._repetitions(self._evaluations).is_known
        return [one for one in self._evaluations if not known(one)]

    def material(self, result: Result) -> Material:
        """Return what the runs tell of the parameters, for the prediction of hold-outs.

        Raises
        ------
        RunFailedError
            No parameter set agrees with the targets, as far as the runs tell.
        """
        return material_of_result(result, self._problem, self._own_evidence(), self._known)

    @property
    def _better_result(self) -> Result | None:
        """The result of an earlier start, if it rests on more runs than are recalled yet."""
        path = self._options.result_file
        if path is None or len(self._evaluations) >= self._ended_before:
            return None
        try:
            found = Result.from_json(path)
        except StoreError:
            return None
        return found if found.identity == self._identity else None

    def _requests_of_earlier_starts(self) -> list[RequestRecord]:
        recorded = self._store.requests(self._identity)
        names = [parameter.name for parameter in self._problem.parameters]
        for request in recorded:
            try:
                tests = [*self._campaign.solvers, *self._campaign.relatives]
                request.require_part_of(names, tests)
            except ValueError as error:
                place = f"table requests, row {self._identity} {request.position}"
                raise self._store.damaged(f"{place}: {error}") from error
        return recorded

    def _search_and_verify(self) -> JudgedAnswer:
        """Alternate between search and fresh seeds at its answer until the verdict is known.

        It rests on all runs, as that of a later start does: those under way are waited for.
        """
        self._run_strategy()
        outcome = self._verify(self._judge_answer())
        while self._campaign.has_pending:
            while self._campaign.has_pending:
                self._tell(self._wait())
            self._run_strategy()
            if not self._looks:
                outcome = self._verify(self._judge_answer())
            elif not self._is_sure(outcome := self._keep_or_move(outcome.answer.parameters)):
                outcome = self._verify(outcome)
        return outcome

    def _tell(self, evaluations: Sequence[Evaluation]) -> None:
        for evaluation in evaluations:
            self._strategy.tell(evaluation.proposal, evaluation)

    def _verify(self, outcome: JudgedAnswer) -> JudgedAnswer:
        """Run fresh seeds at an answer, and search again, until the verdict is known."""
        while self._can_be_confirmed(outcome):
            before = len(self._evaluations)
            self._run_fresh_seeds(outcome)
            self._looks += 1
            outcome = self._judge_at(outcome.answer.parameters)
            if self._is_sure(outcome):
                break
            if self._strategy.resume_after_verification(self._left()):
                self._run_strategy()
                outcome = self._keep_or_move(outcome.answer.parameters)
            if len(self._evaluations) == before or self._is_sure(outcome):
                # Fresh seeds of a deterministic model are none, and the search has ended.
                break
        return outcome

    def _judge_answer(self) -> JudgedAnswer:
        """Judge what the search proposes; its parameters are those that people will read."""
        if recorded := self._recorded_answer():
            return self._judge_at(recorded)
        answer = self._strategy.answer()
        shown = self._strategy.current_problem.rounded(answer.parameters)
        if self._no_record_at(answer.parameters) != self._no_record_at(shown):
            # A row of a table is simulated at its own parameters.
            return self._judge(answer)
        return self._judge_at(shown)

    def _judge_at(self, parameters: Mapping[str, float]) -> JudgedAnswer:
        return self._judge(self._strategy.answer(parameters))

    def _keep_or_move(self, frozen: Mapping[str, float]) -> JudgedAnswer:
        """Judge the answer that is verified, or the one of the search if it is confirmed sooner."""
        moved = self._judge_answer()
        if self._recorded:
            return moved
        kept = self._judge_at(frozen)
        return moved if moved.runs_to_confirm < kept.runs_to_confirm else kept

    def _judge(self, answer: Answer) -> JudgedAnswer:
        every = without_blow_ups(self._problem, [*self._known, *self._in_order()])
        problem, evaluations = answer.reduced(self._problem, every)
        return judge_by_runs(
            problem,
            answer,
            evaluations,
            Demands(
                self._strategy.confidence, self._options.verification_runs, self._campaign.repeats
            ),
            self._repetitions(self._evaluations),
            self._no_record_at(answer.parameters),
        )

    def _no_record_at(self, parameters: Mapping[str, float]) -> list[NoRecordThere]:
        return self._records.missing_at(parameters, self._problem)

    def _in_order(self) -> list[Evaluation]:
        """Return all evaluations, those with fresh seeds last and in the order of their requests.

        They end in another order on another machine, and the verdict does not depend on that.
        """
        order = self._fresh_seeds
        return sorted(self._evaluations, key=lambda one: order.get(one.proposal.seed, 0))

    def _repetitions(self, evaluations: Sequence[Evaluation]) -> Repetitions:
        """Return the runs at answers that are no evidence of their own, see `RecordsRead`."""
        search = [one for one in evaluations if one.proposal.stage != "verification"]
        verification = [one for one in evaluations if one.proposal.stage == "verification"]
        found = self._records.repetitions([*self._known, *search], verification)
        self._latest_repetitions = found
        return found

    def _is_sure(self, outcome: JudgedAnswer) -> bool:
        """Return whether an outcome is certain enough after so many looks at fresh seeds."""
        enough = confidence_after(self._looks - 1, self._strategy.confidence)
        return outcome.status == "calibrated" and outcome.answer.probability_all_met >= enough

    def _can_be_confirmed(self, outcome: JudgedAnswer) -> bool:
        """Return whether a few fresh seeds at the answer could make it certain enough."""
        if self._recorded:
            return True
        answer, left, least = outcome.answer, self._left(), self._strategy.verify_from
        return (
            not outcome.fresh.no_record
            and not answer.out_of_reach
            and (left is None or left > 0)
            and answer.probability_all_met >= least
            and (answer.runs_needed <= self._affordable or self._may_be_moved(outcome))
        )

    def _may_be_moved(self, outcome: JudgedAnswer) -> bool:
        """Return whether a search that does not look at the probability learns from fresh seeds."""
        goes_on = self._strategy.verify_from <= VERDICT.verify_from
        return goes_on and self._affordable > 0 and any(outcome.judgement.lacking.values())

    @property
    def _affordable(self) -> int:
        """Parameter sets left for fresh seeds: of the budget, or of what is usual without one."""
        left = self._left()
        if left is not None:
            return left
        search = [one for one in self._evaluations if one.proposal.stage != "verification"]
        usual = self._strategy.limit or self._sets(search)
        return usual + VERDICT.most_verification - self._sets(self._evaluations)

    def _sets(self, evaluations: Sequence[Evaluation]) -> int:
        """Return the number of parameter sets that take as many runs, rounded up."""
        return math.ceil(self._cost(evaluations) / self._campaign.runs_per_set)

    def _cost(self, evaluations: Sequence[Evaluation]) -> int:
        """Return the number of runs of the tests that cost as much: those of relatives cost less.

        Rounded down, as the search does.
        """
        relatives = self._strategy.problem.relatives
        names = {one.name for one in relatives}
        runs = [name_of_test(run) for evaluation in evaluations for run in evaluation.runs]
        return sum(test not in names for test in runs) + cost_of_relatives(relatives, runs)

    def _recorded_answer(self) -> Mapping[str, float] | None:
        """Return the answer that an earlier start was verifying when it ended."""
        if self._recorded and self._recorded[0].stage == "verification":
            return self._recorded[0].parameters
        return None

    def _utilisation(self, wall_seconds: float) -> float:
        """Return the share of the workers' time in which they simulated."""
        simulated = sum(evaluation.simulated_seconds for evaluation in self._evaluations)
        return min(1.0, simulated / (self._options.workers * max(wall_seconds, 1e-9)))

    def _best_so_far(self) -> JudgedAnswer | None:
        try:
            return self._judge(self._strategy.answer())
        except RunFailedError:
            return None

    def _recall_search(self) -> list[Proposal]:
        """Take the recorded proposals up to the next verification."""
        recalled = []
        while self._recorded and self._recorded[0].stage != "verification":
            recalled.append(self._recorded.popleft().proposal(self._campaign.tests))
        return recalled

    def _recall_verification(self, answer: Answer) -> None:
        """Take the recorded verification of an answer, but not that of the next one.

        The same answer requests the same verification again.
        """
        while self._recorded and self._recorded[0].stage == "verification":
            if self._recorded[0].parameters != answer.parameters:
                return
            self._recorded.popleft()

    def _run_strategy(self) -> None:
        recalled = self._recall_search()
        self._strategy.replay(recalled)
        if self._recorded:
            # An earlier start found an answer here; this decision is kept.
            self._answer_proposals(lambda asked: asked == len(recalled))
        else:
            self._answer_proposals(lambda _asked: self._strategy.finished)

    def _answer_proposals(self, is_enough: Callable[[int], bool]) -> None:
        """Evaluate proposals of the strategy until their number is enough."""
        asked = 0
        while not is_enough(asked):
            while self._has_room and not is_enough(asked):
                proposal = self._strategy.ask()
                if proposal is None:
                    break
                self._start(proposal)
                asked += 1
            if not self._campaign.has_pending:
                return
            self._tell(self._wait())

    @property
    def _has_room(self) -> bool:
        """Whether to ask for a proposal now: a worker is free, and no evaluation is waiting."""
        return self._campaign.has_free_worker and not self._campaign.has_complete

    def _run_fresh_seeds(self, outcome: JudgedAnswer) -> None:
        """Run fresh seeds at the answer: as many as its confirmation lacks."""
        answer = outcome.answer
        self._recall_verification(answer)
        waiting = []
        for tests in self._tests_to_verify(outcome):
            number = len(self._fresh_seeds) + 1
            seed = insertion_seed(self._strategy.seed, "verification", number)
            self._fresh_seeds[seed] = number
            waiting.append(Proposal(answer.parameters, seed, "verification", tests))
        order = {proposal.seed: position for position, proposal in enumerate(waiting)}
        ended: list[Evaluation] = []
        repetitions = Repetitions()
        # Pending runs of the search may end meanwhile.
        while waiting or self._campaign.has_pending:
            while waiting and self._campaign.has_free_worker:
                self._start(waiting.pop(0))
            for evaluation in self._wait():
                if evaluation.proposal.seed in order:
                    ended.append(evaluation)
                else:
                    self._strategy.tell(evaluation.proposal, evaluation)
            if ended:
                # A watch is told as well.
                repetitions = self._repetitions(self._evaluations)
                waiting = self._without_known(waiting, repetitions.deterministic)
        ended.sort(key=lambda evaluation: order[evaluation.proposal.seed])
        for evaluation in ended:
            # Told twice, the output of one run would make the scatter look small.
            if not repetitions.is_known(evaluation):
                self._strategy.tell(evaluation.proposal, evaluation)

    def _without_known(
        self, waiting: Sequence[Proposal], deterministic: Collection[str]
    ) -> list[Proposal]:
        """Leave out what deterministic models have given already."""
        names = self._campaign.solvers
        return [
            proposal
            for proposal in waiting
            if not set(filter(proposal.asks_for, names)).issubset(deterministic)
        ]

    def _tests_to_verify(self, outcome: JudgedAnswer) -> list[tuple[str, ...] | None]:
        """Return the tests of each run with a fresh seed that is to be made now."""
        answer, fresh, missing = outcome.answer, outcome.fresh, outcome.judgement.lacking
        fewest, workers = self._options.verification_runs, self._options.workers
        left = self._runs_left()
        if not self._problem.tests:
            if "" in fresh.deterministic:
                return [None] * missing[""]
            lacking = fewest - fresh.count
            needed = answer.runs_needed if answer.runs_needed <= self._affordable else 0
            count = max(lacking, min(needed, workers), needed // _PART, 1)
            return [None] * (count if left is None else min(count, max(left, 1)))
        wanted = [test for test, count in missing.items() for _ in range(count)]
        problem, _ = answer.reduced(self._problem, ())
        # More runs of a test tell whether its fresh seeds contradict all runs by chance.
        doubted = {problem.scope_of(name).name for name in outcome.judgement.contradicted}
        wanted += [test for test, count in missing.items() if test in doubted and not count]
        if not wanted or answer.probability_all_met < self._strategy.confidence_to_stop:
            # Of those that make the answer certain, the first: the next verdict may need no more.
            worth = Counter(answer.runs_by_worth[: max(workers, self._tests)])
            wanted += (worth - Counter(wanted)).elements()
        known = {test for test in fresh.deterministic if not missing.get(test)}
        wanted = [test for test in wanted if test not in known]
        return [(test,) for test in self._within(left, wanted)]

    def _within(self, runs: int | None, tests: list[str]) -> list[str]:
        """Return the first of some tests whose runs are within the budget, at least one."""
        if runs is None:
            return tests
        used = accumulate(self._campaign.repeats[test] for test in tests)
        return tests[: max(1, sum(total <= runs for total in used))]

    @property
    def _tests(self) -> int:
        """Number of tests that are simulated one by one."""
        return len(self._problem.scopes)

    def _runs_left(self) -> int | None:
        """Return the number of runs left in the budget, of all tests together without scopes."""
        if self._options.max_runs is None:
            return None
        if not self._problem.tests:
            return self._left()
        return self._options.max_runs - self._cost(self._evaluations)

    def _left(self) -> int | None:
        """Return the number of parameter sets left in the budget."""
        if self._options.max_runs is None:
            return None
        if self._problem.tests:
            return (self._runs_left() or 0) // self._campaign.runs_per_set
        return self._options.max_runs // self._campaign.runs_per_set - len(self._evaluations)

    def _start(self, proposal: Proposal) -> None:
        self._stage = proposal.stage
        self._requested += 1
        self._campaign.start(proposal, lambda runs: self._note_request(proposal, runs))
        self._show()

    def _note_request(self, proposal: Proposal, runs: dict[str, str]) -> None:
        request = RequestRecord(
            self._requested, proposal.stage, dict(proposal.parameters), proposal.seed, runs
        )
        self._store.add_request(self._identity, request)

    def _wait(self) -> list[Evaluation]:
        evaluations = self._campaign.wait(self._show)
        self._evaluations += evaluations
        self._stop_after_failures()
        self._stop_after_faults_of_machine()
        self._show()
        return evaluations

    def _stop_after_failures(self) -> None:
        """Stop when no run has given a target after several tries."""
        all_runs = [*self._known, *self._evaluations]
        missing = [
            name
            for name in self._problem.responses
            if not runs_that_yield(self._problem, all_runs, name)
        ]
        tests = {self._problem.scope_of(name).name for name in missing}
        tried = [e for e in self._evaluations if any(map(e.proposal.asks_for, tests))]
        if not missing or not would_all_fail(tried):
            return
        last = tried[-1]
        why = "; ".join(last.failures.values()) or (
            messages.RESPONSES_MISSING(found=", ".join(sorted(last.response_names)) or "nothing")
        )
        telling = [about_other_kind(self._problem, self._evaluations, name) for name in missing]
        telling += [about_short_curves(curve, self._evaluations) for curve in self._problem.curves]
        why = " ".join(filter(None, telling)) or why
        failed = [self._store.find(last.runs[run]) for run in last.failed_runs]
        self._campaign.forget_failures(self._evaluations)
        raise RunFailedError(
            messages.ALL_FAILED(runs=len(tried), responses=", ".join(missing), why=why),
            failed[0].log_tail if failed and failed[0] else "",
        )

    def _stop_after_faults_of_machine(self) -> None:
        """Stop when the last runs failed for the same reason of the machine, after all retries."""
        latest = fail_by_machine(self._evaluations)
        if not latest:
            return
        self._campaign.forget_failures(latest)
        why = "; ".join(latest[-1].failures.values())
        raise RunFailedError(messages.MACHINE_FAILS(runs=len(latest), why=why), kind="machine")

    def _show(self) -> None:
        show, live_file = self._options.on_progress, self._options.live_file
        is_due = live_file is not None and live_file.is_due
        if show is None and not is_due:
            return
        progress = self._progress()
        if live_file is not None and is_due:
            live_file.update(self._identity, progress, self._latest_repetitions)
        if show is not None:
            show(progress)

    def _progress(self) -> Progress:
        evaluations = self._evaluations
        verified = [e for e in evaluations if e.proposal.stage == "verification"]
        campaign = self._campaign
        failed = sum(len(e.failed_runs) for e in evaluations)
        to_come = runs_to_come(
            self._strategy,
            campaign.runs_per_set,
            self._options.max_runs,
            self._options.verification_runs,
            RunsSoFar(
                _runs(evaluations),
                self._cost(evaluations),
                failed,
                _runs(verified),
                math.ceil(len(self._fresh_seeds) * campaign.runs_per_set / campaign.tests),
                self._stage == "design",
            ),
        )
        simulated = _runs(evaluations) - sum(e.reused for e in evaluations)
        seconds = sum(e.simulated_seconds for e in evaluations)
        return Progress(
            self._stage,
            _runs(evaluations),
            campaign.running,
            failed,
            to_come,
            seconds / simulated * to_come.about / self._options.workers if simulated else None,
            min(self._deviations(), default=None),
            self._all_notices(),
            self._origins,
            pending=campaign.pending_runs,
            jobs=campaign.jobs,
            evaluations=tuple(evaluations),
            best_expected_deviation=self._expected_deviation(),
        )

    def _expected_deviation(self) -> float | None:
        """Return what only a display shows: without one, metamodels are not fitted for it."""
        if self._options.on_progress is None or self._stage == "design":
            return None
        return self._expected.after(len(self._evaluations))

    def _all_notices(self) -> tuple[str, ...]:
        sources = tuple(self._strategy.notices), self._campaign.notices
        for source, taken in zip(sources, self._taken, strict=True):
            self._notices += source[taken:]
        self._taken = len(sources[0]), len(sources[1])
        return tuple(self._notices)

    def _deviations(self) -> list[float]:
        """Return the largest relative deviation of each evaluation that has all responses.

        None where a target has no relative deviations, or is a curve. None after the design of
        several tests: later runs are of one test each, so the best one would be of the design.
        """
        if len(self._problem.scopes) > 1 and self._stage != "design":
            return []
        if self._problem.curves or not all(target.is_relative for target in self._problem.targets):
            return []
        names = {target.name for target in self._problem.targets}
        return [
            max(
                abs(target.misfit(e.responses[target.name].value))
                for target in self._problem.targets
            )
            for e in self._evaluations
            if names <= e.responses.keys()
        ]


def _runs(evaluations: Sequence[Evaluation]) -> int:
    """Return the number of runs of some evaluations, known ones included."""
    return sum(len(evaluation.runs) for evaluation in evaluations)
