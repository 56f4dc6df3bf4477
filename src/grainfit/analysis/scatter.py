"""Mean and scatter of responses over seeds at one parameter set."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from statistics import fmean, stdev

from grainfit.analysis import messages
from grainfit.analysis.curve_scatter import CurveScatter
from grainfit.analysis.scatter_statistics import (
    MANY_RUNS,
    half_interval_of_mean,
    interval_of_deviation,
    runs_within,
)
from grainfit.errors import InputError
from grainfit.evaluation import Evaluation
from grainfit.formatting import counted, in_a_row, in_unit, number, plain_ends, plain_interval
from grainfit.one_line import one_line
from grainfit.problem import CurveTarget, Target
from grainfit.tables import Summary, TextTable
from grainfit.verdict.rule import useless_scatter


@dataclass(frozen=True)
class ResponseScatter:
    """Mean and scatter of one response over seeds.

    Parameters
    ----------
    name : str
        Name of the response.
    values : tuple of float
        Responses of the runs, by rising seed.
    target : Target, optional
        Its target, if it has one.
    unit : str
        Unit of the response.
    """

    __repr__ = one_line

    name: str
    values: tuple[float, ...]
    target: Target | None = None
    unit: str = ""

    @property
    def mean(self) -> float:
        """Mean of the runs."""
        return fmean(self.values)

    @property
    def standard_deviation(self) -> float | None:
        """Standard deviation of single runs; None for one run."""
        return stdev(self.values) if len(self.values) > 1 else None

    @property
    def mean_interval(self) -> float | None:
        """Half of the 95 % confidence interval of the mean (Student's t); None for one run."""
        if self.standard_deviation is None:
            return None
        return half_interval_of_mean(len(self.values)) * self.standard_deviation

    @property
    def standard_deviation_interval(self) -> tuple[float, float] | None:
        """95 % confidence interval of the standard deviation; None for one run.

        By the chi-squared distribution, so for normal scatter: a response with outlying runs may be
        farther away.
        """
        if self.standard_deviation is None:
            return None
        return interval_of_deviation(self.standard_deviation, len(self.values))

    @property
    def runs_for_tolerance(self) -> int | None:
        """Runs whose mean is within the tolerance of the expected response in 95 % of all cases.

        None without a target, and for one run.
        """
        if self.target is None or self.standard_deviation is None:
            return None
        return runs_within(self.standard_deviation, self.target.tolerance)


@dataclass(frozen=True)
class RepeatedRuns(Summary):
    """Runs of every test at one parameter set with several seeds.

    Parameters
    ----------
    responses : tuple of ResponseScatter
        Every response that a run gave.
    parameters : mapping of str to float
        Values of the free parameters.
    evaluations : tuple of Evaluation
        By rising seed.
    remarks : tuple of str
        What responses mean that are easily taken for others.
    curves : tuple of CurveScatter
        Those that were measured.
    """

    __repr__ = one_line

    responses: tuple[ResponseScatter, ...]
    parameters: Mapping[str, float]
    evaluations: tuple[Evaluation, ...]
    remarks: tuple[str, ...] = ()
    curves: tuple[CurveScatter, ...] = ()

    def __getitem__(self, name: str) -> ResponseScatter:
        return next(found for found in self.responses if found.name == name)

    @property
    def failures(self) -> tuple[tuple[int, str, str], ...]:
        """Seed, test and reason of every failed run."""
        return tuple(
            (evaluation.proposal.seed, test, reason)
            for evaluation in self.evaluations
            for test, reason in evaluation.failures.items()
        )

    def summary(self) -> tuple[str | TextTable, ...]:
        """Return the table and the sentences that `print` and a notebook show."""
        table = (self._table(),) if self.responses else ()
        failed = (f"Seed {seed}: {test} failed: {reason}" for seed, test, reason in self.failures)
        curves = (part for curve in self.curves for part in curve.parts())
        return (*table, *self.remarks, *self._advice(), *curves, *self._other_curves(), *failed)

    def _table(self) -> TextTable:
        header = ("response", "mean", "standard deviation", "target", "runs")
        rows = tuple(_row(response) for response in self.responses)
        caption = "Mean ± half of its 95 % interval; standard deviation of single runs with its own"
        return TextTable(header, rows, caption)

    def _other_curves(self) -> Iterator[str]:
        measured = {curve.name for curve in self.curves}
        found = dict.fromkeys(name for run in self.evaluations for name in run.curves)
        if others := [name for name in found if name not in measured]:
            words = "is a curve that was" if len(others) == 1 else "are curves that were"
            yield f"{in_a_row(others)} {words} not measured: scatter is shown at measured points."

    def _advice(self) -> list[str]:
        return [words for response in self.responses if (words := _advice(response))]


def _row(found: ResponseScatter) -> tuple[str, ...]:
    half, deviation = found.mean_interval, found.standard_deviation
    ends = found.standard_deviation_interval
    mean = number(found.mean) if half is None else plain_interval(found.mean, half)
    spread = "-"
    if deviation is not None and ends is not None:
        spread = number(deviation, 3)
        if deviation > 0:
            spread += f" ({plain_ends(*ends)})"
    target = found.target
    wanted = "-" if target is None else plain_interval(target.value, target.tolerance)
    return in_unit(found.name, found.unit), mean, spread, wanted, str(len(found.values))


def _advice(found: ResponseScatter) -> str:
    runs, target = found.runs_for_tolerance, found.target
    if runs is None or target is None or runs <= 1:
        return ""
    within = messages.MEAN_WITHIN(runs=counted(runs, "run"))
    value = target.value if target.is_relative else None
    deviation = found.standard_deviation or 0.0
    if useless := useless_scatter(target.name, target.unit, deviation, target.tolerance, value):
        return f"{useless} {within.capitalize()}"
    ratio = number(deviation / target.tolerance, 2)
    scatters = messages.ONE_RUN_SCATTERS(name=found.name, ratio=ratio, mean_within=within)
    return scatters if runs <= MANY_RUNS else messages.MANY_RUNS_NEEDED(scatters=scatters)


def scatter_over_seeds(
    evaluations: Sequence[Evaluation],
    targets: Sequence[Target] = (),
    units: Mapping[str, str] | None = None,
    curves: Sequence[CurveTarget] = (),
) -> RepeatedRuns:
    """Compute mean and scatter of the responses of evaluations at one parameter set.

    Parameters
    ----------
    evaluations : sequence of Evaluation
        Runs with different seeds.
    targets : sequence of Target
        Targets with which the scatter is compared.
    units : mapping of str to str, optional
        Units of responses without a target.
    curves : sequence of CurveTarget
        Measured curves, at whose points that of simulated ones is computed.

    Raises
    ------
    InputError
        There are no evaluations, they are at several parameter sets, or a seed occurs twice.
    """
    _require_repeats(evaluations)
    ordered = sorted(evaluations, key=lambda evaluation: evaluation.proposal.seed)
    wanted = {target.name: target for target in targets}
    names = dict.fromkeys(name for evaluation in ordered for name in evaluation.responses)
    found = [
        ResponseScatter(
            name,
            tuple(e.responses[name].value for e in ordered if name in e.responses),
            wanted.get(name),
            wanted[name].unit if name in wanted else (units or {}).get(name, ""),
        )
        for name in names
    ]
    return RepeatedRuns(
        tuple(found),
        dict(ordered[0].proposal.parameters),
        tuple(ordered),
        curves=tuple(CurveScatter.of(curve, ordered) for curve in curves),
    )


def _require_repeats(evaluations: Sequence[Evaluation]) -> None:
    if not evaluations:
        raise InputError(messages.NO_EVALUATIONS.fault("evaluations"))
    points = {tuple(sorted(e.proposal.parameters.items())) for e in evaluations}
    if len(points) > 1:
        fault = messages.SEVERAL_PARAMETER_SETS.fault("evaluations", count=len(points))
        raise InputError(fault)
    seeds = [e.proposal.seed for e in evaluations]
    repeated = sorted({seed for seed in seeds if seeds.count(seed) > 1})
    if repeated:
        seeds_twice = in_a_row(map(str, repeated))
        raise InputError(messages.SEED_TWICE.fault("evaluations", seeds=seeds_twice))
