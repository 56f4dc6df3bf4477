"""Surrogate of a bulk test: what the rows of the atlas tell about any material and apparatus."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from grainfit.atlas.row import Row
from grainfit.bulk_tests.varied_options import Range
from grainfit.metamodels.kriging import Kriging

Array = NDArray[np.float64]
#: Fewest rows with a response from which it is predicted.
FEWEST_ROWS = 24
#: A response whose values span this factor is predicted as its logarithm.
_WIDE = 3.0
#: Sets of hyperparameters that are kept: more change predictions by less than their errors.
_SETS = 3
#: Least and largest chance that a run has a response.
_LEAST, _MOST = 0.02, 0.98


@dataclass(frozen=True)
class ResponseModel:
    """Metamodel of one response over all inputs of the atlas, in natural units.

    Parameters
    ----------
    kriging : Kriging
        Of the response, or of its logarithm.
    is_logarithm : bool
        Whether it is the logarithm.
    chance : Kriging
        Of the chance that a run has the response.
    inflation : float
        Factor of variances that makes the errors of rows left out as large as predicted, at least 1.
    """

    kriging: Kriging
    is_logarithm: bool
    chance: Kriging
    inflation: float

    @classmethod
    def fit(cls, name: str, points: Array, rows: Sequence[Row]) -> ResponseModel:
        """Fit the metamodels of a response to rows at points of the unit cube."""
        has = np.array([name in row.responses for row in rows])
        found = [row.responses[name] for row in rows if name in row.responses]
        values, errors = (np.array(column) for column in zip(*found, strict=True))
        is_logarithm = bool(values.min() > 0 and values.max() > _WIDE * values.min())
        if is_logarithm:
            values, errors = np.log(values), errors / values
        stated = errors if (errors > 0).all() else None
        kriging = Kriging.fit(points[has], values, standard_errors=stated).reduced(_SETS)
        chance = Kriging.fit(points, has.astype(float), linear_trend=False).reduced(_SETS)
        squares = kriging.standardised_residuals() ** 2
        return cls(kriging, is_logarithm, chance, max(1.0, float(squares.mean())))

    @classmethod
    def from_plain(
        cls, plain: Mapping[str, Any], name: str, points: Array, rows: Sequence[Row]
    ) -> ResponseModel:
        """Return the metamodels of `to_plain`, without a fit.

        Raises
        ------
        KeyError, TypeError, ValueError
            The data belongs to other rows.
        """
        has = np.array([name in row.responses for row in rows])
        values = np.array([row.responses[name][0] for row in rows if name in row.responses])
        is_logarithm = bool(plain["is_logarithm"])
        return cls(
            Kriging.from_plain(
                plain["kriging"], points[has], np.log(values) if is_logarithm else values
            ),
            is_logarithm,
            Kriging.from_plain(plain["chance"], points, has.astype(float)),
            float(plain["inflation"]),
        )

    def predict(self, points: Array) -> tuple[Array, Array]:
        """Return means and variances of the expected response, each of shape (m,)."""
        found = self.kriging.predict(points)
        return self._in_units(found.mean, self.inflation * found.variance_of_mean)

    def scatter(self, points: Array) -> Array:
        """Return the standard deviation from run to run, shape (m,)."""
        means = self.kriging.mean(points)
        noise = np.full(len(points), self.kriging.noise_standard_deviation**2)
        return np.sqrt(self._in_units(means, noise)[1])

    def chance_at(self, points: Array) -> Array:
        """Return the chance that a run has the response, shape (m,)."""
        return np.clip(self.chance.mean(points), _LEAST, _MOST)

    def _in_units(self, means: Array, variances: Array) -> tuple[Array, Array]:
        if not self.is_logarithm:
            return means, variances
        values = np.exp(means)
        return values, values**2 * variances

    def to_plain(self) -> dict[str, Any]:
        """Return all but the rows as JSON."""
        return {
            "is_logarithm": self.is_logarithm,
            "inflation": self.inflation,
            "kriging": _without_runs(self.kriging),
            "chance": _without_runs(self.chance),
        }


def points_of(rows: Sequence[Row], ranges: Mapping[str, Range]) -> Array:
    """Return the rows as points of the unit cube, shape (rows, inputs)."""
    return np.array([
        [float(span.share(row.inputs[name])) for name, span in ranges.items()] for row in rows
    ])


def _without_runs(kriging: Kriging) -> dict[str, Any]:
    plain = kriging.to_plain(factors=False)
    for name in ("points", "values", "known_noise"):
        del plain[name]
    return _short(plain)


def _short(value: Any) -> Any:
    """Return plain data with six digits of every number."""
    if isinstance(value, dict):
        return {key: _short(one) for key, one in value.items()}
    if isinstance(value, list):
        return [_short(one) for one in value]
    return float(f"{value:.6g}") if isinstance(value, float) and math.isfinite(value) else value
