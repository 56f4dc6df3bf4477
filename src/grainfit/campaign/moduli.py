"""Simulate the same material at several Young's moduli: the effect of stiffness on responses."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import product
from pathlib import Path
from statistics import fmean, stdev

from grainfit.campaign.campaign import Campaign, CampaignOptions
from grainfit.campaign.store.store import RunStore
from grainfit.campaign.work_folder import hold, recover
from grainfit.contact_models.registry import MATERIAL_PARAMETERS
from grainfit.errors import Fault, InputError, RunFailedError
from grainfit.evaluation import Evaluation, Proposal
from grainfit.formatting import (
    duration,
    in_a_row,
    number,
    plain_interval,
    unit_for_people,
    with_unit,
)
from grainfit.problem import Target
from grainfit.solvers.base import Solver
from grainfit.tables import TextTable, as_html, as_text

MODULUS = "particle.youngs_modulus"
#: Half-width of a 95 % interval, in standard errors.
_NORMAL_QUANTILE = 1.96


@dataclass(frozen=True)
class MeanResponse:
    """Mean of a response over seeds.

    Parameters
    ----------
    mean : float
        In the unit of the target.
    standard_error : float, optional
        From the scatter of all moduli together; None for one seed each.
    """

    mean: float
    standard_error: float | None


@dataclass(frozen=True)
class ModulusRow:
    """Responses at one Young's modulus.

    Parameters
    ----------
    factor, modulus : float
        Young's modulus over that of the material, and the modulus, Pa.
    responses : mapping of str to MeanResponse
        By name; empty if every run failed.
    time_step : float, optional
        Smallest time step of the tests, s; None if it is not known.
    seconds : float
        Wall time of all tests for one seed, s.
    failures : tuple of str
        Reasons of failed runs.
    """

    factor: float
    modulus: float
    responses: Mapping[str, MeanResponse]
    time_step: float | None
    seconds: float
    failures: tuple[str, ...] = ()


@dataclass(frozen=True)
class ModulusStudy:
    """Responses of a material at several Young's moduli.

    Parameters
    ----------
    rows : tuple of ModulusRow
        From the softest to the stiffest.
    targets : tuple of Target
        Responses that are compared, with their tolerances.
    parameters : mapping of str to float
        Values of the other free parameters.
    seeds : int
        Runs of each modulus.
    """

    rows: tuple[ModulusRow, ...]
    targets: tuple[Target, ...]
    parameters: Mapping[str, float]
    seeds: int

    @property
    def stiffest(self) -> ModulusRow:
        """The stiffest row that has every response: the others are compared with it."""
        return next(row for row in reversed(self.rows) if self._is_complete(row))

    @property
    def smallest_sufficient(self) -> ModulusRow | None:
        """Row of the smallest modulus at which no response differs from that of the stiffest one.

        A response differs if it is farther away than its tolerance, beyond what the scatter of the
        runs explains (95 %). None of the stiffer rows has one that differs either. None if only the
        stiffest agrees with itself: whether it is stiff enough cannot be known.
        """
        found = None
        for row in reversed(self.rows[: self.rows.index(self.stiffest)]):
            if not self._is_complete(row) or self._differing(row):
                break
            found = row
        return found

    @property
    def in_doubt(self) -> tuple[str, ...]:
        """Responses whose scatter leaves open whether `smallest_sufficient` is stiff enough."""
        row = self.smallest_sufficient
        return (
            () if row is None else tuple(t.name for t in self.targets if self._may_differ(row, t))
        )

    def difference(self, row: ModulusRow, name: str) -> tuple[float, float | None]:
        """Return how far a response is from that of the stiffest row, and the 95 % half-width.

        Parameters
        ----------
        row : ModulusRow
            One that has the response.
        name : str
            Name of the response.
        """
        here, there = row.responses[name], self.stiffest.responses[name]
        errors = (here.standard_error, there.standard_error)
        half = None
        if errors[0] is not None and errors[1] is not None:
            half = _NORMAL_QUANTILE * math.hypot(errors[0], errors[1])
        return here.mean - there.mean, half

    def summary(self) -> tuple[str | TextTable, ...]:
        """Return the table and the sentences that `print` and a notebook show."""
        failures = dict.fromkeys(reason for row in self.rows for reason in row.failures)
        return (self._table(), *self._verdict(), *(f"A run failed: {why}" for why in failures))

    def __str__(self) -> str:
        return as_text(self.summary())

    def _repr_html_(self) -> str:
        return as_html(self.summary())

    def _is_complete(self, row: ModulusRow) -> bool:
        return all(target.name in row.responses for target in self.targets)

    def _differing(self, row: ModulusRow) -> list[Target]:
        found = []
        for target in self.targets:
            difference, half = self.difference(row, target.name)
            if abs(difference) - (half or 0.0) > target.tolerance:
                found.append(target)
        return found

    def _may_differ(self, row: ModulusRow, target: Target) -> bool:
        difference, half = self.difference(row, target.name)
        return half is None or abs(difference) + half > target.tolerance

    def _table(self) -> TextTable:
        header = ("modulus", *(target.name for target in self.targets), "time step", "a run")
        rows = tuple(
            (
                _in_mpa(row.modulus),
                *(_cell(row.responses.get(target.name)) for target in self.targets),
                "-" if row.time_step is None else f"{row.time_step:.3g} s",
                f"{row.seconds:.1f} s",
            )
            for row in self.rows
        )
        units = [f"{t.name} in {unit_for_people(t.unit)}" for t in self.targets if t.unit]
        errors = [f"± standard error of the mean of {self.seeds} seeds"] if self.seeds > 1 else []
        return TextTable(header, rows, ", ".join([*units, *errors]))

    def _verdict(self) -> tuple[str, ...]:
        row = self.smallest_sufficient
        top = _in_mpa(self.stiffest.modulus)
        if row is None:
            misses = "; ".join(self._misses())
            return (
                f"No smaller modulus gives what {top} gives{f' ({misses})' if misses else ''}. "
                f"Whether {top} is stiff enough is not known: add a larger factor.",
            )
        sure = [t.name for t in self.targets if t.name not in self.in_doubt]
        modulus = _in_mpa(row.modulus)
        if not self.in_doubt:
            return (
                f"{modulus} is enough: every response is within its tolerance of that at {top}, "
                "and at every modulus between them.",
            )
        verb = "is" if len(self.in_doubt) == 1 else "are"
        words = f"; {in_a_row(sure)} {'is' if len(sure) == 1 else 'are'}" if sure else ""
        return (
            f"{modulus} is the smallest modulus that may be enough: the scatter leaves open "
            f"whether {in_a_row(self.in_doubt)} {verb} within "
            f"tolerance of what {top} gives{words}. More seeds tell.",
        )

    def _misses(self) -> list[str]:
        """Say what differs at the modulus next to the stiffest."""
        position = self.rows.index(self.stiffest)
        if position == 0 or not self._is_complete(row := self.rows[position - 1]):
            return []
        return [
            f"{target.name} differs by {_amount(self.difference(row, target.name)[0], target)} at "
            f"{_in_mpa(row.modulus)}, {_amount(target.tolerance, target)} are accepted"
            for target in self._differing(row)
        ]


def _in_mpa(modulus: float) -> str:
    return f"{number(modulus / 1e6, 3)} MPa"


def _amount(value: float, target: Target) -> str:
    return with_unit(number(value, 2), unit_for_people(target.unit))


def _cell(found: MeanResponse | None) -> str:
    if found is None:
        return "-"
    if found.standard_error is None:
        return number(found.mean)
    return plain_interval(found.mean, found.standard_error)


@dataclass(frozen=True)
class ExpectedWork:
    """Runs that a study still has to make, and how long that takes.

    Parameters
    ----------
    runs, known : int
        Runs to make, and runs that are known already.
    seconds : float, optional
        Expected wall time, s; None if it is not known.
    """

    runs: int
    known: int
    seconds: float | None

    def __str__(self) -> str:
        if not self.runs:
            return "All runs are known already"
        words = f"{self.runs} runs to make, {self.known} known already"
        return words if self.seconds is None else f"{words}; about {duration(self.seconds)}"


@dataclass(frozen=True)
class ModulusPlan:
    """Input of `simulate_moduli`.

    Parameters
    ----------
    solvers : mapping of str to Solver
        By name of the test.
    targets : sequence of Target
        Responses to compare, with their tolerances.
    parameters : mapping of str to float
        Values of the free parameters, with Young's modulus of the particles.
    factors : sequence of float
        Moduli to simulate, over that of ``parameters``.
    seeds : int
        Runs of each modulus: insertion seeds 1, 2, ...
    workers : int
        Runs at a time.
    timeouts : mapping of str to float
        Longest wall time of a run by name of the test, s; raised for the stiffest particles.

    Raises
    ------
    InputError
        A factor is not above zero, there are fewer than two of them, or a number is below one.
    """

    solvers: Mapping[str, Solver]
    targets: Sequence[Target]
    parameters: Mapping[str, float]
    factors: Sequence[float]
    seeds: int = 3
    workers: int = 1
    timeouts: Mapping[str, float] = field(default_factory=dict)

    def __post_init__(self) -> None:
        faults = [
            Fault(key, f"is {value!r}.", "Give a whole number from 1 on.")
            for key, value in (("seeds", self.seeds), ("workers", self.workers))
            if not isinstance(value, int) or isinstance(value, bool) or value < 1
        ]
        wrong = [f for f in self.factors if not (math.isfinite(f) and f > 0)]
        if wrong:
            faults.append(Fault("factors", f"{wrong[0]:g} is no factor.", "Give numbers above 0."))
        elif len(set(self.factors)) < 2:
            faults.append(
                Fault("factors", f"{len(set(self.factors))} given.", "Give two or more, as 1,4,16.")
            )
        else:
            faults += self._impossible()
        if faults:
            raise InputError(faults)

    def _impossible(self) -> Iterator[Fault]:
        known = MATERIAL_PARAMETERS[MODULUS]
        for factor in (min(self.factors), max(self.factors)):
            value = factor * self.parameters[MODULUS]
            if not known.lowest <= value <= known.highest:
                limits = f"{known.lowest:g} to {known.highest:g} {known.unit}"
                yield Fault(MODULUS, f"{value:g} is outside {limits}.", "Give factors nearer to 1.")

    def at(self, factor: float) -> dict[str, float]:
        """Return the parameters with the modulus of a factor."""
        return {**self.parameters, MODULUS: factor * self.parameters[MODULUS]}

    def proposals(self) -> list[tuple[float, Proposal]]:
        """Return every parameter set to simulate with its factor, soft ones first."""
        return [
            (factor, Proposal(self.at(factor), seed, "design"))
            for factor, seed in product(sorted(set(self.factors)), range(1, self.seeds + 1))
        ]

    def all_timeouts(self) -> dict[str, float]:
        """Return time-outs that are long enough for the stiffest particles."""
        stiffest = self.at(max(self.factors))
        usual = {test: solver.default_timeout(stiffest) for test, solver in self.solvers.items()}
        return {
            test: max(seconds or 0.0, self.timeouts.get(test, 0.0))
            for test, seconds in usual.items()
            if seconds is not None or test in self.timeouts
        }


def simulate_moduli(
    plan: ModulusPlan,
    folder: Path,
    on_start: Callable[[ExpectedWork], None] | None = None,
    on_progress: Callable[[int, int], None] | None = None,
) -> ModulusStudy:
    """Simulate a material at several Young's moduli, or find the runs in the store of the folder.

    Parameters
    ----------
    plan : ModulusPlan
        Tests, parameters, moduli and seeds.
    folder : Path
        Work folder that keeps the runs; it may be that of a calibration. After Ctrl-C, another call
        continues.
    on_start : callable, optional
        Called with the expected work before the first run.
    on_progress : callable, optional
        Called with the numbers of finished and of all parameter sets.

    Raises
    ------
    InputError
        A modulus is impossible.
    SolverNotFoundError
        A program is not found.
    RunFailedError
        No modulus has all responses.
    StoreError
        The folder cannot be used.
    """
    folder = folder.absolute()
    for solver in plan.solvers.values():
        solver.check()
    proposals = plan.proposals()
    with hold(folder):
        store = RunStore.in_folder(folder)
        recover(folder, store)
        options = CampaignOptions(plan.workers, plan.all_timeouts())
        campaign = Campaign(plan.solvers, store, folder, options)
        try:
            identities = [campaign.identities(proposal) for _, proposal in proposals]
            known = store.find_many({run for runs in identities for run in runs.values()})
            if on_start is not None:
                finished = {name for name, run in known.items() if run.status == "finished"}
                on_start(_expected_work(plan, identities, finished))
            for _, proposal in proposals:
                campaign.start(proposal)
            evaluations = _wait(campaign, len(proposals), on_progress)
        except KeyboardInterrupt:
            campaign.cancel()
            raise
        finally:
            campaign.close()
            store.close()
    return _study(plan, evaluations)


def _wait(
    campaign: Campaign, count: int, on_progress: Callable[[int, int], None] | None
) -> list[Evaluation]:
    evaluations: list[Evaluation] = []
    while campaign.has_pending:
        evaluations += campaign.wait()
        if on_progress is not None:
            on_progress(len(evaluations), count)
    return evaluations


def _expected_work(
    plan: ModulusPlan, identities: Sequence[Mapping[str, str]], finished: set[str]
) -> ExpectedWork:
    seconds: float | None = 0.0
    runs = 0
    for (_, proposal), by_test in zip(plan.proposals(), identities, strict=True):
        for test, identity in by_test.items():
            if identity in finished:
                continue
            runs += 1
            cost = plan.solvers[test].estimate_cost(proposal.parameters)
            seconds = None if cost is None or seconds is None else seconds + cost.wall_seconds
    total = sum(len(by_test) for by_test in identities)
    return ExpectedWork(runs, total - runs, None if seconds is None else seconds / plan.workers)


def _study(plan: ModulusPlan, evaluations: Sequence[Evaluation]) -> ModulusStudy:
    by_factor: dict[float, list[Evaluation]] = {}
    factor_of = {proposal.parameters[MODULUS]: factor for factor, proposal in plan.proposals()}
    for evaluation in evaluations:
        factor = factor_of[evaluation.proposal.parameters[MODULUS]]
        by_factor.setdefault(factor, []).append(evaluation)
    values = {
        target.name: {
            factor: [e.responses[target.name].value for e in runs if target.name in e.responses]
            for factor, runs in by_factor.items()
        }
        for target in plan.targets
    }
    scatter = {name: _pooled(list(groups.values())) for name, groups in values.items()}
    rows = tuple(
        _row(plan, factor, by_factor[factor], values, scatter) for factor in sorted(by_factor)
    )
    study = ModulusStudy(rows, tuple(plan.targets), dict(plan.parameters), plan.seeds)
    if not any(len(row.responses) == len(plan.targets) for row in rows):
        reasons = [reason for row in rows for reason in row.failures]
        raise RunFailedError(reasons[0] if reasons else "the runs give none of the responses")
    return study


def _row(
    plan: ModulusPlan,
    factor: float,
    runs: Sequence[Evaluation],
    values: Mapping[str, Mapping[float, Sequence[float]]],
    scatter: Mapping[str, float | None],
) -> ModulusRow:
    parameters = plan.at(factor)
    costs = [solver.estimate_cost(parameters) for solver in plan.solvers.values()]
    steps = [cost.time_step for cost in costs if cost is not None]
    responses = {
        name: MeanResponse(fmean(found), _error(scatter[name], len(found)))
        for name, groups in values.items()
        if (found := groups[factor])
    }
    failures = dict.fromkeys(reason for run in runs for reason in run.failures.values())
    return ModulusRow(
        factor,
        parameters[MODULUS],
        responses,
        min(steps) if steps else None,
        fmean(run.seconds for run in runs),
        tuple(failures),
    )


def _pooled(groups: Sequence[Sequence[float]]) -> float | None:
    """Standard deviation within groups, all of them together; None without repetitions."""
    freedom = sum(max(len(group) - 1, 0) for group in groups)
    if not freedom:
        return None
    squares = sum((len(g) - 1) * stdev(g) ** 2 for g in groups if len(g) > 1)
    return math.sqrt(squares / freedom)


def _error(scatter: float | None, count: int) -> float | None:
    return None if scatter is None else scatter / math.sqrt(count)
