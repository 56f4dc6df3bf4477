"""Makes a parameter set the answer, with all that the metamodels say of it."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from math import isfinite

import numpy as np
from numpy.typing import NDArray

from grainfit.kriging import Kriging
from grainfit.strategies.answer import Answer, Bound, MetamodelQuality, OutOfReach
from grainfit.strategies.metamodels import Metamodels

#: Nearer to a bound than this share of the interval counts as on it.
_ON_BOUND = 0.01
#: In squared tolerances: what fits worse than the best by less fits as well, and by more does not.
_AS_GOOD, _WORSE = 1.0, 4.0


def make_answer(
    metamodels: Metamodels,
    parameters: Mapping[str, float],
    out_of_reach: Sequence[OutOfReach],
    closest: NDArray[np.float64],
    *,
    spread: bool = True,
) -> Answer:
    """Make a parameter set the answer, with all that the metamodels say of it.

    ``closest`` is the point of the unit cube where they meet the targets best, and ``spread`` tells
    whether the runs are spread by a design, see `Kriging.warnings`.
    """
    point: NDArray[np.float64] = metamodels.problem.to_unit(parameters)
    means, variances = metamodels.predict(point)
    names = [target.name for target in metamodels.problem.targets]
    return Answer(
        parameters=dict(parameters),
        predicted=dict(zip(names, means[0].tolist(), strict=True)),
        standard_errors=dict(zip(names, np.sqrt(variances[0]).tolist(), strict=True)),
        agreement=float(metamodels.agreement(point)[0]),
        out_of_reach=tuple(out_of_reach),
        quality=metamodel_quality(metamodels, spread=spread),
        cut_off=dict(_cut_off(metamodels, closest)),
    )


def bound_at(position: float) -> Bound | None:
    """Return the bound that a position in an interval is on, 0 being its minimum; or None."""
    if _ON_BOUND <= position <= 1 - _ON_BOUND:
        return None
    return "min" if position < _ON_BOUND else "max"


def _cut_off(metamodels: Metamodels, closest: NDArray[np.float64]) -> Iterator[tuple[str, Bound]]:
    least = float(metamodels.misfit(closest[None])[0])
    for axis, parameter in enumerate(metamodels.problem.parameters):
        ends = np.array([closest, closest])
        ends[:, axis] = 0.0, 1.0
        low, high = metamodels.misfit(ends) - least
        if low <= _AS_GOOD and high >= _WORSE:
            yield parameter.name, "min"
        elif high <= _AS_GOOD and low >= _WORSE:
            yield parameter.name, "max"


def metamodel_quality(
    metamodels: Metamodels, *, spread: bool = True
) -> dict[str, MetamodelQuality]:
    """Return how far the metamodels can be trusted, by name of the target.

    ``spread`` tells whether the runs are spread by a design, see `Kriging.warnings`.
    """
    names = [target.name for target in metamodels.problem.targets]
    return {
        name: _quality(model, spread) for name, model in zip(names, metamodels.models, strict=True)
    }


def _quality(model: Kriging, spread: bool) -> MetamodelQuality:
    check = model.leave_one_out()
    return MetamodelQuality(
        q2=float(check.q2) if isfinite(check.q2) else None,
        coverage=float(check.coverage),
        noise=float(model.noise_standard_deviation),
        warnings=tuple(model.warnings(spread=spread)),
    )
