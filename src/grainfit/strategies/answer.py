"""What a strategy believes in, and how far it can be trusted."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from math import isfinite

import numpy as np
from numpy.typing import NDArray

from grainfit.strategies.metamodels import Metamodels
from grainfit.strategies.reachability import OutOfReach


@dataclass(frozen=True)
class MetamodelQuality:
    """How far a metamodel can be trusted, by leave-one-out.

    Parameters
    ----------
    q2 : float or None
        Share of the variance of the responses that is predicted; 1 is perfect. None when the
        responses are all equal.
    coverage : float
        Share of the runs inside their 95 % interval.
    noise : float
        Estimated standard deviation of the response from seed to seed.
    warnings : tuple of str
        Why it is not to be trusted, in words; empty when it is.
    """

    q2: float | None
    coverage: float
    noise: float
    warnings: tuple[str, ...] = ()


@dataclass(frozen=True)
class Answer:
    """What a strategy believes in.

    Parameters
    ----------
    parameters : mapping of str to float
        Values of the free parameters.
    predicted, standard_errors : mapping of str to float
        Expected response and its standard error, by name of the target.
    agreement : float
        Probability, by the metamodels, that all expected responses are within their tolerances.
    out_of_reach : tuple of OutOfReach
        Targets that no parameter set within the intervals meets.
    quality : mapping of str to MetamodelQuality
        By name of the target.
    """

    parameters: Mapping[str, float]
    predicted: Mapping[str, float]
    standard_errors: Mapping[str, float]
    agreement: float
    out_of_reach: tuple[OutOfReach, ...] = ()
    quality: Mapping[str, MetamodelQuality] = field(default_factory=dict)


def make_answer(
    metamodels: Metamodels,
    parameters: Mapping[str, float],
    out_of_reach: Sequence[OutOfReach],
    *,
    spread: bool = True,
) -> Answer:
    """Make a parameter set the answer, with all that the metamodels say of it.

    ``spread`` tells whether the runs are spread by a design, see `Kriging.warnings`.
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
        quality=dict(zip(names, _quality(metamodels, spread), strict=True)),
    )


def _quality(metamodels: Metamodels, spread: bool) -> Iterator[MetamodelQuality]:
    for model in metamodels.models:
        check = model.leave_one_out()
        yield MetamodelQuality(
            q2=float(check.q2) if isfinite(check.q2) else None,
            coverage=float(check.coverage),
            noise=float(model.noise_standard_deviation),
            warnings=tuple(model.warnings(spread=spread)),
        )
