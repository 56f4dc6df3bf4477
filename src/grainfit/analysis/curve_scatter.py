"""Mean and scatter of a curve over seeds at one parameter set, at the points of a measured one."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from grainfit.analysis.scatter_statistics import MANY_RUNS, half_interval_of_mean, runs_within
from grainfit.evaluation import Evaluation
from grainfit.formatting import counted, in_unit, number, on_curve, plain_interval
from grainfit.metamodels.curve_reduction import about_short_curves, values_at
from grainfit.problem import CurveTarget
from grainfit.tables import TextTable

Array = NDArray[np.float64]

#: Points spread over the curve that are shown, beside the one that scatters most.
_SHOWN = 5
#: Accepted deviation of a curve, in standard uncertainties.
_TOLERANCE = 2.0


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
            number(mean) if halves is None else plain_interval(mean, halves),
            "-" if deviations is None else number(deviations, 3),
            "-" if ratios is None else number(ratios, 2),
            plain_interval(target.values[index], float(target.standard_uncertainties[index])),
            str(len(self.values)),
        )

    def _advice(self) -> str:
        ratios, runs = self.in_uncertainties, self.runs_for_tolerance
        if ratios is None or runs is None or runs <= 1:
            return ""
        worst, target = int(ratios.argmax()), self.target
        place = on_curve(target.coordinates[worst], target.coordinate, target.coordinate_unit)
        more = (
            " Raise the number of particles in the test, state a larger uncertainty, or set "
            "repeats in its [[test]]."
        )
        return (
            f"{self.name}: one run scatters by {number(float(np.sqrt((ratios**2).mean())), 2)} "
            "standard uncertainties σ of the measured points (root mean square), by up to "
            f"{number(float(ratios[worst]), 2)} at {place}; the mean of {counted(runs, 'run')} is "
            "within 2 σ at each point (95 %)."
            f"{more if runs > MANY_RUNS else ''}"
        )
