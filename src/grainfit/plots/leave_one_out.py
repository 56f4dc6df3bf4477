"""Leave-one-out check: each run against its prediction by a metamodel fitted without it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from grainfit.analysis.analysis import Analysis
from grainfit.formatting import plain
from grainfit.metamodels.kriging import POOR_Q2
from grainfit.metamodels.metamodels import Metamodels
from grainfit.metamodels.prediction import NORMAL_QUANTILE, LeaveOneOut
from grainfit.plots.labels import Label, label_of_response
from grainfit.plots.style import named_runs
from grainfit.problem import Target
from grainfit.work_folder.saved_calibration import SavedCalibration


@dataclass(frozen=True)
class LeaveOneOutCheck:
    """Runs of one response against the prediction of each from all others.

    Attributes
    ----------
    target : Target
        The response and its measured value.
    label : Label
        Its symbol and unit.
    names : sequence of str
        Names of the runs.
    simulated : ndarray
        Responses of the runs.
    left_out : LeaveOneOut
        Predictions of each run from all others.
    scatter : float
        Standard deviation from run to run, as the metamodel estimates it.
    warnings : sequence of str
        Reasons not to trust the metamodel.
    """

    target: Target
    label: Label
    names: Sequence[str]
    simulated: NDArray[np.float64]
    left_out: LeaveOneOut
    scatter: float
    warnings: Sequence[str]

    @property
    def spread(self) -> float:
        """Standard deviation of the simulated responses."""
        return float(self.simulated.std())

    @property
    def is_mostly_scatter(self) -> bool:
        """Whether the scatter from run to run explains that runs are predicted poorly."""
        return self.left_out.q2 < POOR_Q2 and self.scatter**2 >= (1 - POOR_Q2) * self.spread**2

    @property
    def half_widths(self) -> NDArray[np.float64]:
        """Half of the 95 % interval of each prediction."""
        return np.asarray(NORMAL_QUANTILE * self.left_out.standard_deviation)

    @property
    def inside(self) -> NDArray[np.bool_]:
        """Whether each run is inside the interval of its prediction."""
        return np.asarray(np.abs(self.simulated - self.left_out.predicted) <= self.half_widths)


def leave_one_out_checks(saved: SavedCalibration, analysis: Analysis) -> list[LeaveOneOutCheck]:
    """Return one check for each response that has a metamodel."""
    metamodels = analysis.metamodels
    if metamodels is None:
        return []
    return [_check(saved, analysis, metamodels, index) for index in range(len(metamodels.models))]


def _check(
    saved: SavedCalibration, analysis: Analysis, metamodels: Metamodels, index: int
) -> LeaveOneOutCheck:
    target, model = metamodels.problem.targets[index], metamodels.models[index]
    # Uses the metamodel's own runs: of many runs, it was fitted to some only.
    known = model.to_plain(factors=False)
    simulated = known["offset"] + known["scale"] * np.array(known["values"])
    runs = [tuple(point) for point in known["points"]]
    quality = analysis.quality.get(target.name)
    return LeaveOneOutCheck(
        target,
        label_of_response(saved, target.name),
        _names(saved, metamodels, target, list(zip(runs, simulated, strict=True))),
        simulated,
        model.leave_one_out(),
        model.noise_standard_deviation,
        [plain(text) for text in quality.warnings] if quality else [],
    )


def _names(
    saved: SavedCalibration,
    metamodels: Metamodels,
    target: Target,
    runs: Sequence[tuple[tuple[float, ...], float]],
) -> list[str]:
    """Names of runs, by their place and response."""
    known: dict[tuple[float, ...], list[tuple[float, str]]] = {}
    for name, evaluation in named_runs(saved, metamodels.reduction):
        if target.name in evaluation.responses:
            point = tuple(metamodels.problem.to_unit(evaluation.proposal.parameters).tolist())
            value = evaluation.responses[target.name].value
            known.setdefault(point, []).append((value, name))
    return [min(known[point], key=lambda run: abs(run[0] - value))[1] for point, value in runs]
