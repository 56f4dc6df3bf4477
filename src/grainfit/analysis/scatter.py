"""Mean and scatter of responses and curves over seeds at one parameter set."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from statistics import fmean, stdev

import numpy as np

from grainfit.analysis import messages
from grainfit.analysis.scatter_statistics import (
    MANY_RUNS,
    half_interval_of_mean,
    interval_of_deviation,
    runs_within,
)
from grainfit.arrays import Array
from grainfit.errors import InputError
from grainfit.evaluation import Evaluation
from grainfit.formatting import (
    counted,
    ends,
    in_a_row,
    in_unit,
    interval,
    number,
    on_curve,
)
from grainfit.metamodels.curve_reduction import about_short_curves, values_at
from grainfit.one_line import OneLine
from grainfit.problem import CurveTarget, Target
from grainfit.tables import Summary, TextTable
from grainfit.verdict.rule import useless_scatter

#: Points spread over the curve that are shown, beside the one that scatters most.
_SHOWN = 5
#: Accepted deviation of a curve, in standard uncertainties.
_TOLERANCE = 2.0


@dataclass(frozen=True)
class ResponseScatter(OneLine):
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
class RepeatedRuns(Summary, OneLine):
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
    of_deviation = found.standard_deviation_interval
    mean = number(found.mean) if half is None else interval(found.mean, half)
    spread = "-"
    if deviation is not None and of_deviation is not None:
        spread = number(deviation, 3)
        if deviation > 0:
            spread += f" ({ends(*of_deviation)})"
    target = found.target
    wanted = "-" if target is None else interval(target.value, target.tolerance)
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


@dataclass(frozen=True)
class CurveScatter:
    """Mean and scatter of a curve over seeds, at the measured points.

    Parameters
    ----------
    target : CurveTarget
        The measured curve, of n points.
    values : tuple of tuple of float
        n values of each run that holds all points, by rising seed.
    short : str
        Words on runs that do not; empty if all do.
    """

    target: CurveTarget
    values: tuple[tuple[float, ...], ...]
    short: str = ""

    @classmethod
    def of(cls, target: CurveTarget, evaluations: Sequence[Evaluation]) -> CurveScatter:
        """Read the curves of runs with different seeds."""
        found = [
            values_at(run.curves[target.name], target.coordinates)
            for run in evaluations
            if target.name in run.curves
        ]
        values = tuple(tuple(one.tolist()) for one in found if one is not None)
        return cls(target, values, about_short_curves(target, evaluations))

    @property
    def name(self) -> str:
        """Name of the response."""
        return self.target.name

    @property
    def mean(self) -> Array:
        """Mean curve, shape (n,)."""
        return np.asarray(np.mean(self.values, axis=0))

    @property
    def standard_deviations(self) -> Array | None:
        """Standard deviations of single runs, shape (n,); None for fewer than two."""
        return np.std(self.values, axis=0, ddof=1) if len(self.values) > 1 else None

    @property
    def mean_intervals(self) -> Array | None:
        """Halves of the 95 % confidence intervals of the mean (Student's t), shape (n,)."""
        if self.standard_deviations is None:
            return None
        return np.asarray(half_interval_of_mean(len(self.values)) * self.standard_deviations)

    @property
    def in_uncertainties(self) -> Array | None:
        """Standard deviations in standard uncertainties of the measured points, shape (n,)."""
        if self.standard_deviations is None:
            return None
        return np.asarray(self.standard_deviations / self.target.standard_uncertainties)

    @property
    def runs_for_tolerance(self) -> int | None:
        """Runs whose mean is within two standard uncertainties at each point in 95 % of all cases.

        None for fewer than two runs.
        """
        if self.in_uncertainties is None:
            return None
        return runs_within(float(self.in_uncertainties.max()), _TOLERANCE)

    def parts(self) -> list[str | TextTable]:
        """Return the table of a few points, and sentences."""
        table = [self._table()] if self.values else []
        return [*table, *filter(None, (self._advice(), self.short))]

    def _table(self) -> TextTable:
        target = self.target
        header = (
            in_unit(target.coordinate or "coordinate", target.coordinate_unit),
            in_unit(f"mean of {self.name}", target.unit),
            "standard deviation",
            "in σ",
            "measured",
            "runs",
        )
        caption = (
            f"{len(self._shown())} of {counted(len(target.values), 'measured point')} ± standard "
            "uncertainty σ; mean ± half of its 95 % interval; standard deviation of single runs"
        )
        return TextTable(header, tuple(map(self._row, self._shown())), caption)

    def _shown(self) -> list[int]:
        places = np.linspace(0, len(self.target.values) - 1, _SHOWN).round().astype(int).tolist()
        worst = [] if self.in_uncertainties is None else [int(self.in_uncertainties.argmax())]
        return sorted({*places, *worst})

    def _row(self, index: int) -> tuple[str, ...]:
        target, mean = self.target, float(self.mean[index])
        halves, deviations, ratios = (
            None if found is None else float(found[index])
            for found in (self.mean_intervals, self.standard_deviations, self.in_uncertainties)
        )
        return (
            number(target.coordinates[index]),
            number(mean) if halves is None else interval(mean, halves),
            "-" if deviations is None else number(deviations, 3),
            "-" if ratios is None else number(ratios, 2),
            interval(target.values[index], float(target.standard_uncertainties[index])),
            str(len(self.values)),
        )

    def _advice(self) -> str:
        ratios, runs = self.in_uncertainties, self.runs_for_tolerance
        if ratios is None or runs is None or runs <= 1:
            return ""
        worst, target = int(ratios.argmax()), self.target
        place = on_curve(target.coordinates[worst], target.coordinate, target.coordinate_unit)
        more = (
            " State a larger uncertainty, or repeats, whose mean is one evaluation; a bulk test "
            "of more particles scatters less."
        )
        return (
            f"{self.name}: one run scatters by {number(float(np.sqrt((ratios**2).mean())), 2)} "
            "standard uncertainties σ of the measured points (root mean square), by up to "
            f"{number(float(ratios[worst]), 2)} at {place}; the mean of {counted(runs, 'run')} is "
            "within 2 σ at each point (95 %)."
            f"{more if runs > MANY_RUNS else ''}"
        )
