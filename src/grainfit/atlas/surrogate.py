"""Surrogate of a bulk test: what the rows of the atlas tell about any material and apparatus."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from grainfit.arrays import Array
from grainfit.atlas.row import Row
from grainfit.atlas.strata import Stratum
from grainfit.bulk_tests.varied_options import Range
from grainfit.metamodels.kriging import Kriging

#: Fewest rows with a response from which it is predicted.
FEWEST_ROWS = 24
#: Fewest of them that are not of dry spheres.
FEWEST_OWN = 12
#: A response whose values span this factor is predicted as its logarithm, unless it is an angle.
_WIDE = 2.0
_ANGLE = "deg"
#: Sets of hyperparameters that are kept: more change predictions by less than their errors.
_SETS = 3
#: Standard uncertainty of what a trend adds beyond the rows, over it.
_UNSURE_FORM = 0.5
#: Fewest pairs of a row and its repeat that tell the scatter of a run.
_FEWEST_PAIRS = 12
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
        Of the chance that a run has the response, the same for all that the same rows have.
    inflation : float
        Factor of variances, 1 or more: errors of rows left out are as large as predicted then.
    """

    kriging: Kriging
    is_logarithm: bool
    chance: Kriging
    inflation: float

    @classmethod
    def fit(
        cls,
        stratum: Stratum,
        name: str,
        points: Array,
        rows: Sequence[Row],
        chance: Kriging,
        own: int | None = None,
        repeats: Sequence[Row] = (),
    ) -> ResponseModel:
        """Fit the metamodel of a response to rows at points of the unit cube.

        Its inflation is that of the first ``own`` rows alone. Repeats of them, if there are enough,
        tell how much of what a row is off is no scatter of its run.
        """
        has = _has(name, rows)
        values, errors = row_values(stratum, name, rows)
        is_wide = bool(values.min() > 0 and values.max() > _WIDE * values.min())
        is_logarithm = is_wide and stratum.kind.responses[name].unit != _ANGLE
        if is_logarithm:
            values, errors = np.log(values), errors / values
        stated = errors if (errors > 0).all() else None
        kriging = Kriging.fit(points[has], values, standard_errors=stated).reduced(_SETS)
        count = int(has[:own].sum())
        differences = _differences(stratum, name, rows[:own], repeats, is_logarithm=is_logarithm)
        if len(differences) < _FEWEST_PAIRS:
            inflation = float((kriging.standardised_residuals()[:count] ** 2).mean())
        else:
            check = kriging.leave_one_out()
            off = (kriging.values - check.predicted)[:count]
            expected = check.standard_deviation[:count] ** 2 - kriging.noise_standard_deviation**2
            scatter = float((differences**2).mean()) / 2
            inflation = (float((off**2).mean()) - scatter) / float(expected.mean())
        return cls(kriging, is_logarithm, chance, max(1.0, inflation))

    @classmethod
    def from_plain(
        cls,
        plain: Mapping[str, Any],
        stratum: Stratum,
        name: str,
        points: Array,
        rows: Sequence[Row],
        chance: Kriging,
    ) -> ResponseModel:
        """Return the metamodel of `to_plain`, without a fit.

        Raises
        ------
        KeyError, TypeError, ValueError
            The data belongs to other rows.
        """
        values, _ = row_values(stratum, name, rows)
        is_logarithm = bool(plain["is_logarithm"])
        values = np.log(values) if is_logarithm else values
        kriging = Kriging.from_plain(plain["kriging"], points[_has(name, rows)], values)
        return cls(kriging, is_logarithm, chance, float(plain["inflation"]))

    def predict(self, points: Array) -> tuple[Array, Array]:
        """Return means and variances of the expected response, each of shape (m,).

        Beyond the rows, a part of what the trend adds is as uncertain as its form.
        """
        found = self.kriging.predict(points)
        variance = self.inflation * found.variance_of_mean
        inside = np.clip(points, 0.0, 1.0)
        beyond = (inside != points).any(axis=1)
        if beyond.any():
            added = found.mean[beyond] - self.kriging.mean(inside[beyond])
            variance[beyond] += (_UNSURE_FORM * added) ** 2
        return self._in_units(found.mean, variance)

    def mean(self, points: Array) -> Array:
        """Return the means of `predict` alone, shape (m,), for a fraction of its operations."""
        means = self.kriging.mean(points)
        return np.exp(means) if self.is_logarithm else means

    def predict_beyond(self, points: Array, columns: Sequence[int]) -> tuple[Array, Array]:
        """Return means and variances where inputs lie beyond the rows that have no trend.

        There responses are those at the end of the rows, and less sure by what they change over
        the whole range of the input, and the errors of both its ends, times how far it is beyond,
        in ranges.

        Parameters
        ----------
        points : ndarray, shape (m, inputs)
            Beyond 0 to 1 outside of the rows.
        columns : sequence of int
            Of these inputs.
        """
        inside = clipped(points, columns)
        means, variances = self.predict(inside)
        for column in columns:
            excess = np.abs(points[:, column] - inside[:, column])
            if excess.any():
                low, of_low = self.predict(_with_column(inside, column, 0.0))
                high, of_high = self.predict(_with_column(inside, column, 1.0))
                variances = variances + excess**2 * ((high - low) ** 2 + of_low + of_high)
        return means, variances

    def scatter(self, points: Array) -> Array:
        """Return the standard deviation from run to run, shape (m,)."""
        means = self.kriging.mean(points)
        noise = np.full(len(points), self.kriging.noise_standard_deviation**2)
        return np.sqrt(self._in_units(means, noise)[1])

    def relative_scatter(self, points: Array) -> Array:
        """Return the standard deviation from run to run over the mean, shape (m,)."""
        noise = np.full(len(points), self.kriging.noise_standard_deviation)
        return noise if self.is_logarithm else noise / np.abs(self.kriging.mean(points))

    def relative_error(self, points: Array) -> Array:
        """Return the standard error of the expected response over its mean, shape (m,)."""
        found = self.kriging.predict(points)
        errors = np.sqrt(self.inflation * found.variance_of_mean)
        return np.asarray(errors if self.is_logarithm else errors / np.abs(found.mean))

    def relative_covariance(self, points: Array) -> Array:
        """Return the covariance of the expected response between points over its means, (m, m)."""
        found = self.inflation * self.kriging.covariance_with(points)(points)[0]
        if self.is_logarithm:
            return np.asarray(found)
        means = self.kriging.mean(points)
        return np.asarray(found / np.outer(means, means))

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
        }


class Surrogate:
    """What the rows of a stratum of the atlas tell.

    Parameters
    ----------
    stratum : Stratum
        Test and particles.
    rows : sequence of Row
        Its runs.
    dry : sequence of Row
        Rows of dry spheres, the limit of all other particles.
    plain : mapping, optional
        Metamodels as of `to_plain`; without them, they are fitted.

    Raises
    ------
    KeyError, TypeError, ValueError
        The metamodels belong to other rows.
    """

    def __init__(
        self,
        stratum: Stratum,
        rows: Sequence[Row],
        dry: Sequence[Row] = (),
        plain: Mapping[str, Any] | None = None,
    ) -> None:
        self.rows = tuple(rows)
        repeats = [row for row in rows if row.is_repeat]
        own = [row for row in rows if not row.is_repeat]
        # A metamodel of pairs follows each of them, and is rough in between.
        rows = [*own, *stratum.with_limit([row for row in dry if not row.is_repeat])]
        self.models: dict[str, ResponseModel] = {}
        self._has: dict[str, NDArray[np.bool_]] = {}
        self._chances: dict[bytes, Kriging] = {}
        points = points_of(rows, stratum.ranges)
        for name in stratum.kind.responses:
            has = _has(name, rows)
            if has.sum() < FEWEST_ROWS or has[: len(own)].sum() < FEWEST_OWN:
                continue
            given = stratum, name, points, rows
            if plain is None:
                chance = self._chance(has, points, None)
                model = ResponseModel.fit(*given, chance, len(own), repeats)
            else:
                one = plain[name]
                chance = self._chance(has, points, plain["chances"][one["chance"]])
                model = ResponseModel.from_plain(one, *given, chance)
            self.models[name], self._has[name] = model, has

    def correlation(self, names: Sequence[str]) -> Array:
        """Return the correlation of the errors of responses, shape (responses, responses).

        A heap that is steeper than its neighbours tell is higher and narrower, too. It is that of
        the residuals of rows left out; where few rows have all responses, they are independent.
        """
        common = np.all([self._has[name] for name in names], axis=0)
        if len(names) < 2 or common.sum() < FEWEST_ROWS:
            return np.eye(len(names))
        residuals = [
            self.models[name].kriging.standardised_residuals()[common[self._has[name]]]
            for name in names
        ]
        return np.asarray(np.corrcoef(residuals))

    def _chance(self, has: NDArray[np.bool_], points: Array, plain: Any) -> Kriging:
        """Return the metamodel of the chance of a response; those of one run have the same."""
        key = has.tobytes()
        if key not in self._chances:
            shares = has.astype(float)
            self._chances[key] = (
                Kriging.fit(points, shares, linear_trend=False).reduced(_SETS)
                if plain is None
                else Kriging.from_plain(plain, points, shares)
            )
        return self._chances[key]

    def to_plain(self) -> dict[str, Any]:
        """Return the metamodels as JSON, without the rows."""
        chances = list(self._chances.values())
        return {
            **{
                name: model.to_plain() | {"chance": chances.index(model.chance)}
                for name, model in self.models.items()
            },
            "chances": [_without_runs(chance) for chance in chances],
        }


def least_chance(models: Iterable[ResponseModel], points: Array) -> Array:
    """Return the chance that runs have all responses of some metamodels, shape (m,)."""
    # Responses that the same rows have share one.
    different = {id(one.chance): one for one in models}
    return np.asarray(np.min([one.chance_at(points) for one in different.values()], axis=0))


def clipped(points: Array, columns: Sequence[int]) -> Array:
    """Return points of the unit cube with some inputs no farther than its ends."""
    found = points.copy()
    found[:, columns] = np.clip(points[:, columns], 0.0, 1.0)
    return found


def _with_column(points: Array, column: int, value: float) -> Array:
    found = points.copy()
    found[:, column] = value
    return found


def _has(name: str, rows: Sequence[Row]) -> NDArray[np.bool_]:
    return np.array([name in row.responses for row in rows])


def row_values(stratum: Stratum, name: str, rows: Sequence[Row]) -> tuple[Array, Array]:
    """Return values and standard errors of a response over what it is proportional to."""
    found = [
        np.array(row.responses[name]) / stratum.proportion(name, row.inputs)
        for row in rows
        if name in row.responses
    ]
    values, errors = np.array(found).T
    return values, errors


def _differences(
    stratum: Stratum,
    name: str,
    rows: Sequence[Row],
    repeats: Sequence[Row],
    *,
    is_logarithm: bool,
) -> Array:
    """Return how far repeats are from the rows that they repeat, as the metamodel has them."""
    first = {row.number: row for row in rows if name in row.responses}
    again = [row for row in repeats if name in row.responses and row.point in first]
    if not again:
        return np.array([])
    values = [
        row_values(stratum, name, some)[0] for some in (again, [first[r.point] for r in again])
    ]
    one, other = map(np.log, values) if is_logarithm else values
    return np.asarray(one - other)


def points_of(rows: Sequence[Row], ranges: Mapping[str, Range]) -> Array:
    """Return the rows as points of the unit cube, shape (rows, inputs)."""
    return shares_of((row.inputs for row in rows), ranges)


def shares_of(every: Iterable[Mapping[str, float]], ranges: Mapping[str, Range]) -> Array:
    """Return inputs as points of the unit cube, shape (points, inputs)."""
    return np.array(
        [[float(span.share(one[name])) for name, span in ranges.items()] for one in every]
    )


def _without_runs(kriging: Kriging) -> dict[str, Any]:
    plain = kriging.to_plain(factors=False)
    for name in ("points", "values", "known_noise"):
        del plain[name]
    short: dict[str, Any] = _short(plain)
    return short


def _short(value: Any) -> Any:
    """Return plain data with six digits of every number."""
    if isinstance(value, dict):
        return {key: _short(one) for key, one in value.items()}
    if isinstance(value, list):
        return [_short(one) for one in value]
    return float(f"{value:.6g}") if isinstance(value, float) and math.isfinite(value) else value
