"""The effect of the stiffness of particles: responses at several Young's moduli, compared."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from statistics import fmean, stdev

from grainfit.analysis import messages
from grainfit.analysis.modulus_plan import ModulusPlan
from grainfit.bulk_tests.parameter_names import MODULUS
from grainfit.errors import RunFailedError
from grainfit.evaluation import Evaluation
from grainfit.formatting import (
    causes,
    in_a_row,
    in_unit,
    number,
    plain_interval,
    unit_for_people,
    with_unit,
)
from grainfit.one_line import OneLine
from grainfit.problem import Target
from grainfit.student import NORMAL_QUANTILE
from grainfit.tables import Summary, TextTable


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
        Reasons of failed runs, one for each.
    """

    factor: float
    modulus: float
    responses: Mapping[str, MeanResponse]
    time_step: float | None
    seconds: float
    failures: tuple[str, ...] = ()


@dataclass(frozen=True)
class ModulusStudy(Summary, OneLine):
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
    curves : tuple of str
        Measured curves, which are not compared.
    """

    rows: tuple[ModulusRow, ...]
    targets: tuple[Target, ...]
    parameters: Mapping[str, float]
    seeds: int
    curves: tuple[str, ...] = ()

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
            half = NORMAL_QUANTILE * math.hypot(errors[0], errors[1])
        return here.mean - there.mean, half

    def summary(self) -> tuple[str | TextTable, ...]:
        """Return the table and the sentences that `print` and a notebook show."""
        failures = causes(reason for row in self.rows for reason in row.failures)
        failed = (messages.A_RUN_FAILED(why=why) for why in failures)
        return (self._table(), *self._verdict(), *self._left_out(), *failed)

    def _left_out(self) -> Iterator[str]:
        if self.curves:
            what = "is a curve" if len(self.curves) == 1 else "are curves"
            yield messages.CURVES_NOT_COMPARED(curves=in_a_row(self.curves), what=what)

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
                *(cell(row.responses.get(target.name)) for target in self.targets),
                "-" if row.time_step is None else f"{row.time_step:.3g} s",
                f"{row.seconds:.1f} s",
            )
            for row in self.rows
        )
        units = [in_unit(t.name, t.unit) for t in self.targets if t.unit]
        errors = [f"± standard error of the mean of {self.seeds} seeds"] if self.seeds > 1 else []
        return TextTable(header, rows, ", ".join([*units, *errors]))

    def _verdict(self) -> tuple[str, ...]:
        row = self.smallest_sufficient
        top = _in_mpa(self.stiffest.modulus)
        if row is None:
            misses = "; ".join(self._misses())
            return (messages.NO_SMALLER_MODULUS(top=top, misses=misses and f" ({misses})"),)
        sure = [t.name for t in self.targets if t.name not in self.in_doubt]
        modulus = _in_mpa(row.modulus)
        if not self.in_doubt:
            return (messages.MODULUS_ENOUGH(modulus=modulus, top=top),)
        verb = "is" if len(self.in_doubt) == 1 else "are"
        words = f"; {in_a_row(sure)} {'is' if len(sure) == 1 else 'are'}" if sure else ""
        return (
            messages.MODULUS_IN_DOUBT(
                modulus=modulus, responses=in_a_row(self.in_doubt), verb=verb, top=top, sure=words
            ),
        )

    def _misses(self) -> list[str]:
        """Say what differs at the modulus next to the stiffest."""
        position = self.rows.index(self.stiffest)
        if position == 0 or not self._is_complete(row := self.rows[position - 1]):
            return []
        return [
            messages.DIFFERS_AT_MODULUS(
                response=target.name,
                difference=amount(self.difference(row, target.name)[0], target),
                modulus=_in_mpa(row.modulus),
                accepted=amount(target.tolerance, target),
            )
            for target in self._differing(row)
        ]


def _in_mpa(modulus: float) -> str:
    return f"{number(modulus / 1e6, 3)} MPa"


def amount(value: float, target: Target) -> str:
    """Return a difference or a tolerance of a target, with its unit."""
    return with_unit(number(value, 2), unit_for_people(target.unit))


def cell(found: MeanResponse | None) -> str:
    """Return a mean with its standard error for a table; a dash without one."""
    if found is None:
        return "-"
    if found.standard_error is None:
        return number(found.mean)
    return plain_interval(found.mean, found.standard_error)


def modulus_study(plan: ModulusPlan, evaluations: Sequence[Evaluation]) -> ModulusStudy:
    """Compare the responses of a material at several Young's moduli.

    Parameters
    ----------
    plan : ModulusPlan
        Tests, parameters, moduli and seeds.
    evaluations : sequence of Evaluation
        Those of all its parameter sets, in any order.

    Raises
    ------
    RunFailedError
        No modulus has all responses.
    """
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
        for target in plan.problem.targets
    }
    means = {name: mean_responses(groups) for name, groups in values.items()}
    rows = tuple(_row(plan, factor, by_factor[factor], means) for factor in sorted(by_factor))
    study = ModulusStudy(
        rows,
        tuple(plan.problem.targets),
        dict(plan.parameters),
        plan.seeds,
        tuple(curve.name for curve in plan.problem.curves),
    )
    if not any(len(row.responses) == len(plan.problem.targets) for row in rows):
        reasons = [reason for row in rows for reason in row.failures]
        raise RunFailedError(reasons[0] if reasons else messages.NO_RESPONSE_OF_RUNS())
    return study


def _row(
    plan: ModulusPlan,
    factor: float,
    runs: Sequence[Evaluation],
    means: Mapping[str, Mapping[float, MeanResponse]],
) -> ModulusRow:
    parameters = plan.at(factor)
    costs = [solver.estimate_cost(parameters) for solver in plan.solvers.values()]
    steps = [cost.time_step for cost in costs if cost is not None]
    responses = {name: found[factor] for name, found in means.items() if factor in found}
    return ModulusRow(
        factor,
        parameters[MODULUS],
        responses,
        min(steps) if steps else None,
        fmean(run.seconds for run in runs),
        tuple(reason for run in runs for reason in run.failures.values()),
    )


def mean_responses(groups: Mapping[float, Sequence[float]]) -> dict[float, MeanResponse]:
    """Return the mean of each group of runs that has any; all groups together tell the scatter.

    Parameters
    ----------
    groups : mapping of float to sequence of float
        A response of the runs by what is varied.
    """
    scatter = _pooled(list(groups.values()))
    return {
        key: MeanResponse(fmean(found), _error(scatter, len(found)))
        for key, found in groups.items()
        if found
    }


def _pooled(groups: Sequence[Sequence[float]]) -> float | None:
    """Standard deviation within groups, all of them together; None without repetitions."""
    freedom = sum(max(len(group) - 1, 0) for group in groups)
    if not freedom:
        return None
    squares = sum((len(g) - 1) * stdev(g) ** 2 for g in groups if len(g) > 1)
    return math.sqrt(squares / freedom)


def _error(scatter: float | None, count: int) -> float | None:
    return None if scatter is None else scatter / math.sqrt(count)
