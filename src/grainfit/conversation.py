"""The conversation of a calibration: a strategy asks, a campaign answers."""

from __future__ import annotations

import time
from collections.abc import Callable
from contextlib import suppress
from dataclasses import asdict, dataclass
from importlib.metadata import version
from typing import Any

from grainfit.campaign.evaluation import Evaluation, Proposal
from grainfit.campaign.identity import run_identity
from grainfit.campaign.runner import Campaign
from grainfit.campaign.store import RequestRecord, RunStore
from grainfit.errors import GrainfitError, RunFailedError, StoreError
from grainfit.misfit import relative_deviation
from grainfit.problem import Problem
from grainfit.progress import Progress
from grainfit.result import ResponseResult, Result, RunCounts, RunSummary, Status
from grainfit.strategies.base import Answer, Strategy, insertion_seed
from grainfit.verification import (
    ROUNDS,
    Verified,
    meets_targets,
    needs_more_runs,
    verified_responses,
)

#: With this many failures and not one success there is no use in going on.
_HOPELESS = 3


@dataclass(frozen=True)
class ConversationOptions:
    """What the user decides about a conversation, see `grainfit.calibrate`."""

    name: str
    workers: int
    max_runs: int | None
    verification_runs: int
    on_progress: Callable[[Progress], None] | None = None


class Conversation:
    """The strategy asks, the campaign answers, until the answer is verified."""

    def __init__(
        self,
        problem: Problem,
        strategy: Strategy,
        campaign: Campaign,
        store: RunStore,
        options: ConversationOptions,
    ) -> None:
        self._problem = problem
        self._strategy = strategy
        self._campaign = campaign
        self._store = store
        self._options = options
        self._evaluations: list[Evaluation] = []
        self._verification: list[Evaluation] = []
        self._verification_asked = 0
        self._stage = "design"
        self._requested = 0
        self._started = time.monotonic()
        self._identity = run_identity(self._definition())

    def _definition(self) -> dict[str, Any]:
        return {
            "parameters": [asdict(parameter) for parameter in self._problem.parameters],
            "targets": [asdict(target) for target in self._problem.targets],
            "strategy": self._strategy.name,
            "seed": self._strategy.seed,
            "max_runs": self._options.max_runs,
        }

    def hold(self) -> Result:
        """Hold the conversation to its end; Ctrl-C ends it early with what is known."""
        self._store.begin_calibration(self._identity, self._options.name, self._definition())
        answer: Answer | None = None
        status: Status
        try:
            answer, status = self._converse()
        except KeyboardInterrupt:
            self._campaign.cancel()
            answer, status = self._best_so_far(), "interrupted"
        except GrainfitError:
            self._campaign.cancel()
            with suppress(StoreError):
                self._store.end_calibration(self._identity, "failed")
            raise
        result = self._result(answer, status)
        self._store.end_calibration(self._identity, status)
        return result

    def _converse(self) -> tuple[Answer, Status]:
        self._run_strategy()
        answer = self._strategy.answer()
        while not self._verify(answer) and self._strategy.reconsider():
            self._run_strategy()
            earlier, answer = answer, self._strategy.answer()
            if answer.parameters == earlier.parameters:
                break
        if meets_targets(self._problem, self._verified()):
            return answer, "calibrated"
        return answer, "unreachable" if answer.out_of_reach else "out_of_tolerance"

    def _best_so_far(self) -> Answer | None:
        try:
            return self._strategy.answer()
        except RunFailedError:
            return None

    def _run_strategy(self) -> None:
        while not self._strategy.finished:
            while self._campaign.has_free_worker:
                proposal = self._strategy.ask()
                if proposal is None:
                    break
                self._start(proposal)
            for evaluation in self._wait():
                self._strategy.tell(evaluation)

    def _verify(self, answer: Answer) -> bool:
        """Run fresh seeds at the answer until the verdict is clear; return whether it is met."""
        self._verification = []
        for _ in range(ROUNDS):
            if not self._affordable(self._options.verification_runs):
                break
            self._verification += self._verification_round(answer)
            if not needs_more_runs(self._problem, self._verified()):
                break
        return meets_targets(self._problem, self._verified())

    def _verification_round(self, answer: Answer) -> list[Evaluation]:
        waiting = []
        for _ in range(self._options.verification_runs):
            self._verification_asked += 1
            seed = insertion_seed(self._strategy.seed, "verification", self._verification_asked)
            waiting.append(Proposal(answer.parameters, seed, "verification"))
        order = {proposal.seed: position for position, proposal in enumerate(waiting)}
        ended: list[Evaluation] = []
        while len(ended) < self._options.verification_runs:
            while waiting and self._campaign.has_free_worker:
                self._start(waiting.pop(0))
            ended += self._wait()
        ended.sort(key=lambda evaluation: order[evaluation.proposal.seed])
        for evaluation in ended:
            self._strategy.tell(evaluation)
        return ended

    def _affordable(self, evaluations: int) -> bool:
        if self._options.max_runs is None:
            return True
        made = len(self._evaluations) + evaluations
        return made * self._campaign.tests <= self._options.max_runs

    def _start(self, proposal: Proposal) -> None:
        self._stage = proposal.stage
        runs = self._campaign.start(proposal)
        self._requested += 1
        self._store.add_request(
            self._identity,
            RequestRecord(
                self._requested, proposal.stage, dict(proposal.parameters), proposal.seed, runs
            ),
        )
        self._show()

    def _wait(self) -> list[Evaluation]:
        evaluations = self._campaign.wait(self._show)
        self._evaluations += evaluations
        self._stop_when_hopeless()
        self._show()
        return evaluations

    def _stop_when_hopeless(self) -> None:
        if len(self._evaluations) < _HOPELESS or any(e.responses for e in self._evaluations):
            return
        reasons = [reason for e in self._evaluations for reason in e.failures.values()]
        log = next(iter(self._evaluations[-1].runs.values()))
        record = self._store.find(log)
        raise RunFailedError(
            f"the first {len(self._evaluations)} runs all failed, so going on is pointless. "
            f"The last one: {reasons[-1]}",
            record.log_tail if record else "",
        )

    def _verified(self) -> dict[str, Verified]:
        return verified_responses(self._problem, self._verification)

    def _show(self) -> None:
        if self._options.on_progress is None:
            return
        evaluations = self._evaluations
        left = self._strategy.expected_left
        if self._stage == "verification":
            verified = sum(e.proposal.stage == "verification" for e in evaluations)
            left = self._verification_asked - verified
        else:
            left += self._options.verification_runs
        simulated = [e.seconds for e in evaluations if not e.reused]
        seconds = (
            sum(simulated) / len(simulated) * left / self._options.workers if simulated else None
        )
        self._options.on_progress(
            Progress(
                self._stage,
                len(evaluations),
                self._campaign.under_way,
                sum(1 for e in evaluations if e.failures),
                left,
                seconds,
                min(self._deviations(), default=None),
                tuple(self._strategy.notices),
            )
        )

    def _deviations(self) -> list[float]:
        """Largest relative deviation of each evaluation that has all responses."""
        names = {target.name for target in self._problem.targets}
        return [
            max(
                abs(relative_deviation(e.responses[target.name].value, target))
                for target in self._problem.targets
            )
            for e in self._evaluations
            if names <= e.responses.keys()
        ]

    def _result(self, answer: Answer | None, status: Status) -> Result:
        problem = self._problem
        middle = problem.from_unit([0.5] * problem.dimension)
        rayleigh = problem.rayleigh
        parameters = dict(answer.parameters) if answer else {}
        return Result(
            status=status,
            parameters=parameters,
            responses=self._responses(answer) if answer else {},
            runs=self._counts(),
            rayleigh_time_step=problem.rayleigh_time_step(parameters) if answer else None,
            rayleigh_time_step_before=problem.rayleigh_time_step(middle),
            rayleigh_time_step_limits=rayleigh.limits(problem.intervals) if rayleigh else None,
            wall_seconds=time.monotonic() - self._started,
            name=self._options.name,
            strategy=self._strategy.name,
            seed=self._strategy.seed,
            version=version("grainfit"),
            units={parameter.name: parameter.unit for parameter in problem.parameters},
            out_of_reach=answer.out_of_reach if answer else (),
            metamodels=answer.quality if answer else {},
            notices=(*self._strategy.notices, *(_edge_notices(problem, answer) if answer else ())),
            history=tuple(_summary(evaluation) for evaluation in self._evaluations),
        )

    def _responses(self, answer: Answer) -> dict[str, ResponseResult]:
        verified = self._verified()
        results = {}
        for target in self._problem.targets:
            known = verified.get(target.name)
            best = known.mean if known else answer.predicted[target.name]
            results[target.name] = ResponseResult(
                target=target.value,
                tolerance=target.accepted_deviation,
                unit=target.unit,
                predicted=answer.predicted[target.name],
                std_error=answer.standard_errors[target.name],
                verified_mean=known.mean if known else None,
                verified_std_error=known.standard_error if known else None,
                verified_interval=known.half_width if known else None,
                deviation_percent=100 * relative_deviation(best, target),
                within_tolerance=abs(best - target.value) <= target.accepted_deviation,
            )
        return results

    def _counts(self) -> RunCounts:
        def runs(stage: str) -> int:
            return sum(len(e.runs) for e in self._evaluations if e.proposal.stage == stage)

        return RunCounts(
            design=runs("design"),
            optimisation=runs("optimisation"),
            verification=runs("verification"),
            failed=sum(len(e.failures) for e in self._evaluations),
            reused=sum(e.reused for e in self._evaluations),
            total=sum(len(e.runs) for e in self._evaluations),
        )


def _edge_notices(problem: Problem, answer: Answer) -> list[str]:
    """Say when the answer lies on a bound of an interval."""
    notices = []
    for parameter in problem.parameters:
        position = parameter.to_unit(answer.parameters[parameter.name])
        for bound, value, near in (
            ("min", parameter.minimum, position < 0.01),
            ("max", parameter.maximum, position > 0.99),
        ):
            if near:
                notices.append(
                    f"{parameter.name} lies on its bound {bound} = {value:g}: "
                    "a wider interval may fit better."
                )
    return notices


def _summary(evaluation: Evaluation) -> RunSummary:
    return RunSummary(
        evaluation.proposal.stage,
        dict(evaluation.proposal.parameters),
        evaluation.proposal.seed,
        {name: response.value for name, response in evaluation.responses.items()},
        dict(evaluation.failures),
        dict(evaluation.runs),
    )
