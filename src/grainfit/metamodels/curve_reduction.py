"""Reduction of curves to a few numbers: principal components, each a target of its own.

The errors of the points of a measured curve are correlated, and simulated curves differ from each
other in a few ways only. Divided by the root of the measurement's covariance, every curve is a
vector whose measured entries have independent errors of 1. The principal components of the
simulated vectors are orthogonal directions, so the coordinates of the measured curve along them are
a few independent numbers with errors of 1: targets like any other. Nothing else of the measurement
depends on the parameters; the rest tells whether any simulated curve has the measured shape.

References
----------
Higdon, Gattiker, Williams & Rightley (2008), J. Am. Stat. Assoc. 103, 570-583, sections 2.2 and
2.3.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from scipy import linalg
from scipy.special import chdtrc
from typing_extensions import override

from grainfit.arrays import Array
from grainfit.errors import Fault
from grainfit.evaluation import Curve, Evaluation, Response
from grainfit.formatting import on_curve, unit_for_people, with_unit
from grainfit.metamodels import messages
from grainfit.problem import CurveTarget, Problem, Target, TestScope
from grainfit.problem.target import DEFAULT_RELATIVE_TOLERANCE

#: Standard deviation of the runs, in standard uncertainties of the measurement, up to which a
#: component is left out: it could tell hardly anything of the parameters.
_TRUNCATED = 0.5
_MOST_COMPONENTS = 6
#: A simulated value this many times the largest measured one is no physical answer; a single such
#: curve would be the first component.
_BLOWN_UP = 1e4
#: Rounds in which the values that percentages refer to settle, to this share of the largest.
_MOST_ROUNDS = 10
_SAME = 1e-3
#: Accepted deviations along components, in standard uncertainties: along the leading ones, as many
#: as there are parameters, and along the others, which the material can hardly follow. So errors
#: as they are stated are seldom called out of reach.
_LEADING_TOLERANCE, _OTHER_TOLERANCE = 2.0, 4.0
#: Probability of the shape of a measured curve below which no simulated curve is said to have it.
_OTHER_SHAPE = 1e-3


@dataclass(frozen=True)
class ComponentTarget(Target):
    """Coordinate of a measured curve along a principal component, in standard uncertainties.

    Parameters
    ----------
    is_leading : bool
        Whether it is one of the leading components, which the parameters decide.
    """

    is_leading: bool = True

    @override
    def _faults_of_size(self) -> list[Fault]:
        """None: it is computed, and may be as good as zero."""
        return []

    @property
    def is_relative(self) -> bool:
        """False: the value is a distance from the mean of the runs."""
        return False

    @property
    def misfit_unit(self) -> float:
        """Deviation that counts as 1 in the misfit: as if 1 % of it were the uncertainty."""
        return _usual_tolerance(self.is_leading) / DEFAULT_RELATIVE_TOLERANCE


def _usual_tolerance(is_leading: bool) -> float:
    return _LEADING_TOLERANCE if is_leading else _OTHER_TOLERANCE


def component_name(curve: str, number: int) -> str:
    """Return the name of the response along a principal component, numbered from 1."""
    return f"{curve}, component {number}"


def values_at(curve: Curve, coordinates: Sequence[float]) -> Array | None:
    """Interpolate a simulated curve at the measured coordinates; None where it has no values."""
    there = np.asarray(curve.coordinates, dtype=float)
    wanted = np.asarray(coordinates, dtype=float)
    # Roundings of the last digits do not end a curve.
    slack = 1e-9 * (there[-1] - there[0])
    if wanted[0] < there[0] - slack or (not curve.stays and wanted[-1] > there[-1] + slack):
        return None
    return np.asarray(np.interp(wanted, there, np.asarray(curve.values, dtype=float)))


@dataclass(frozen=True)
class CurveBasis:
    """Principal components of the simulated curves of one measured curve.

    Parameters
    ----------
    target : CurveTarget
        The measured curve, of n points.
    root : ndarray, shape (n, n)
        Lower Cholesky factor of the covariance of the measurement.
    mean : ndarray, shape (n,)
        Mean of the simulated curves less the measured one, whitened by the root.
    components : ndarray, shape (k, n)
        Orthonormal directions of the whitened curves.
    left_out : ndarray, shape (m, n)
        Further directions in which the runs differ, each times its standard deviation.
    parameters : int
        Number of free parameters that the curve depends on.
    runs : int
        Number of simulated curves.
    """

    target: CurveTarget
    root: Array
    mean: Array
    components: Array
    left_out: Array
    parameters: int
    runs: int

    @classmethod
    def of(cls, target: CurveTarget, curves: Array, parameters: int) -> CurveBasis:
        """Find the components of simulated curves at the measured coordinates, shape (runs, n).

        Percentages are shares of the sum of components that is nearest to the measured curve.
        """
        true = np.asarray(target.values)
        for _ in range(_MOST_ROUNDS):
            basis = cls._about(target, curves, parameters, true)
            before, true = true, basis.nearest
            if np.abs(true - before).max() <= _SAME * np.abs(true).max():
                break
        return basis

    @classmethod
    def _about(cls, target: CurveTarget, curves: Array, parameters: int, true: Array) -> CurveBasis:
        """Find the components with the errors of the measurement about some true values."""
        covariance = target.covariance_about(true)
        root = np.asarray(np.linalg.cholesky(covariance), dtype=np.float64)
        off = linalg.solve_triangular(root, (curves - np.asarray(target.values)).T, lower=True).T
        mean = off.mean(axis=0)
        _, sizes, directions = np.linalg.svd(off - mean, full_matrices=False)
        deviations = sizes / np.sqrt(max(len(curves) - 1, 1))
        telling = int((deviations > _TRUNCATED).sum())
        kept = min(max(telling, 1), _MOST_COMPONENTS, len(directions))
        left_out = deviations[kept:, None] * directions[kept:]
        return cls(target, root, mean, directions[:kept], left_out, parameters, len(curves))

    @property
    def names(self) -> list[str]:
        """Names of the components."""
        return [component_name(self.target.name, j + 1) for j in range(len(self.components))]

    @cached_property
    def targets(self) -> list[ComponentTarget]:
        """The measured curve along the components."""
        values = (-self.components @ self.mean).tolist()
        leading = [number < self.parameters for number in range(len(values))]
        tolerances = map(_usual_tolerance, leading)
        if self.target.tolerance is not None:
            tolerances = map(self._accepted_along, self.components)
        return [
            # The typical curve: far runs of a small component are nonlinear rather than outlying.
            ComponentTarget(name, value, 1.0, tolerance, statistic="median", is_leading=is_leading)
            for name, value, tolerance, is_leading in zip(
                self.names, values, tolerances, leading, strict=True
            )
        ]

    def _accepted_along(self, direction: Array) -> float:
        """Return the largest deviation along a component that is accepted at every point."""
        return float(1 / np.abs(self.root @ direction / self.target.tolerances).max())

    def scores(self, values: Array) -> dict[str, Response]:
        """Return a simulated curve, at the measured coordinates, along the components."""
        off = values - np.asarray(self.target.values)
        off = linalg.solve_triangular(self.root, off, lower=True) - self.mean
        return dict(zip(self.names, map(Response, (self.components @ off).tolist()), strict=True))

    @property
    def parts(self) -> dict[str, str]:
        """Descriptions of the components, by their names."""
        target = self.target
        moved = np.abs(self.components @ self.root.T) / target.standard_uncertainties
        places = [target.coordinates[i] for i in moved.argmax(axis=1)]
        about = target.coordinate, target.coordinate_unit
        texts = [f"{target.name}, as it varies most at {on_curve(p, *about)}" for p in places]
        return dict(zip(self.names, texts, strict=True))

    def values_of(self, evaluation: Evaluation) -> Array | None:
        """Return the curve of a run at the measured coordinates; None if it gives no component."""
        return _values(self.target, evaluation)

    @property
    def nearest(self) -> Array:
        """Sum of components nearest to the measured curve, shape (n,)."""
        return self.expected(-self.components @ self.mean, np.zeros(len(self.components)))[0]

    def expected(self, scores: Array, variances: Array) -> tuple[Array, Array]:
        """Return the expected curve and its standard errors, shape (n,) each.

        Parameters
        ----------
        scores, variances : ndarray, shape (k,)
            Expected coordinates along the components, and their variances. Components that are left
            out add the variance that the runs have along them.
        """
        curve = self.curves(scores @ self.components)
        errors = np.sqrt(variances)[:, None] * self.components
        spread = np.vstack([errors, self.left_out]) @ self.root.T
        return curve, np.sqrt((spread**2).sum(axis=0))

    def curves(self, whitened: Array) -> Array:
        """Return curves of whitened deviations from their mean, shape (..., n)."""
        return np.asarray(np.asarray(self.target.values) + (self.mean + whitened) @ self.root.T)

    @cached_property
    def shape_probability(self) -> float:
        """Probability of a rest as large as that of the measured curve, if its errors are as said.

        The rest is what no combination of the components gives. Where it is tiny, no simulated
        curve has the measured shape.
        """
        rest = -self.mean - self._on_components(-self.mean)
        deviations = np.linalg.norm(self.left_out, axis=1)
        seen = deviations > 0
        directions = self.left_out[seen] / deviations[seen, None]
        along = directions @ rest
        others = rest - along @ directions
        # The mean of the runs scatters too, also where too few of them show how much.
        scatter = float((deviations[seen] ** 2).mean()) if seen.any() else 0.0
        square = float(
            (along**2 / (1 + deviations[seen] ** 2 * (1 + 1 / self.runs))).sum()
            + others @ others / (1 + scatter / self.runs)
        )
        degrees = len(rest) - len(self.components)
        return float(chdtrc(degrees, square)) if degrees else 1.0

    @property
    def has_other_shape(self) -> bool:
        """Whether the measured curve has a shape that no simulated curve has.

        It has not where the nearest sum of components is within a tolerance that is given.
        """
        deviations = np.abs(self.nearest - np.asarray(self.target.values))
        is_far = self.target.tolerance is None or bool((deviations > self.target.tolerances).any())
        return is_far and self.shape_probability < _OTHER_SHAPE

    def _on_components(self, vector: Array) -> Array:
        return np.asarray((self.components @ vector) @ self.components)


@dataclass(frozen=True)
class Reduction:
    """Problem whose curves are replaced by their components.

    Parameters
    ----------
    whole : Problem
        The problem with its curves.
    bases : tuple of CurveBasis
        One for each curve.
    """

    whole: Problem
    bases: tuple[CurveBasis, ...] = ()

    @classmethod
    def of(cls, problem: Problem, evaluations: Sequence[Evaluation]) -> Reduction:
        """Find the components of all curves in some runs, of which each has one run at least."""
        return cls(
            problem, tuple(_basis(problem, target, evaluations) for target in problem.curves)
        )

    @classmethod
    def where_possible(cls, problem: Problem, evaluations: Sequence[Evaluation]) -> Reduction:
        """Find the components of those curves that some runs have; leave out the others."""
        known = [curve for curve in problem.curves if runs_with_curve(curve, evaluations)]
        if not known:
            # Without its curves, the problem may have nothing left to meet.
            return cls(problem)
        return cls.of(problem.with_targets(problem.targets, known), evaluations)

    @property
    def parts(self) -> dict[str, str]:
        """Descriptions of the components of each curve, by their names."""
        return {name: text for basis in self.bases for name, text in basis.parts.items()}

    @cached_property
    def problem(self) -> Problem:
        """The problem with components instead of curves."""
        if not self.bases:
            return self.whole
        names = {basis.target.name: basis.names for basis in self.bases}
        return replace(
            self.whole,
            targets=[*self.whole.targets, *(t for basis in self.bases for t in basis.targets)],
            tests=[_with_components(scope, names) for scope in self.whole.tests],
            curves=(),
        )

    def evaluations(self, evaluations: Sequence[Evaluation]) -> list[Evaluation]:
        """Return runs with the components of their curves among their responses."""
        if not self.bases:
            return list(evaluations)
        return [replace(e, responses={**e.responses, **self._scores(e)}) for e in evaluations]

    def _scores(self, evaluation: Evaluation) -> dict[str, Response]:
        found: dict[str, Response] = {}
        for basis in self.bases:
            values = basis.values_of(evaluation)
            found |= {} if values is None else basis.scores(values)
        return found


def runs_with_curve(target: CurveTarget, evaluations: Sequence[Evaluation]) -> list[Evaluation]:
    """Return the runs whose curve covers the measured coordinates, and has not blown up."""
    return [e for e in evaluations if _values(target, e) is not None]


def simulated_curves(target: CurveTarget, evaluations: Sequence[Evaluation]) -> list[Array]:
    """Return the curves of `runs_with_curve` at the measured coordinates, shape (n,) each."""
    return [values for e in evaluations if (values := _values(target, e)) is not None]


def about_other_kind(problem: Problem, evaluations: Sequence[Evaluation], name: str) -> str:
    """Say that a response is a curve where its target is a number, or the reverse; else ""."""
    if name in {curve.name for curve in problem.curves}:
        is_other, message = any(name in e.responses for e in evaluations), messages.IS_A_NUMBER
    else:
        is_other, message = any(name in e.curves for e in evaluations), messages.IS_A_CURVE
    return message(name=name) if is_other else ""


def about_short_curves(target: CurveTarget, evaluations: Sequence[Evaluation]) -> str:
    """Say that simulated curves do not reach all measured points; "" if they all do."""
    found = [e.curves[target.name] for e in evaluations if target.name in e.curves]
    short = [curve for curve in found if values_at(curve, target.coordinates) is None]
    if not short:
        return ""
    start, end = target.coordinates[0], target.coordinates[-1]
    least = min(short, key=lambda c: min(c.coordinates[-1], end) - max(c.coordinates[0], start))
    ranges = [
        f"{on[0]:.4g} to {with_unit(f'{on[-1]:.4g}', unit_for_people(target.coordinate_unit))}"
        for on in (least.coordinates, target.coordinates)
    ]
    return (
        f"{len(short)} of {len(found)} simulated curves of {target.name} do not hold all measured "
        f"points: the shortest is {ranges[0]}, and the measured one is {ranges[1]}. Leave out what "
        "the test does not reach, or change its options."
    )


def _values(target: CurveTarget, evaluation: Evaluation) -> Array | None:
    curve = evaluation.curves.get(target.name)
    values = None if curve is None else values_at(curve, target.coordinates)
    largest = max(np.abs(target.values).max(), target.standard_uncertainties.max())
    if values is None or np.abs(values).max() > _BLOWN_UP * largest:
        return None
    return values


def _basis(problem: Problem, target: CurveTarget, evaluations: Sequence[Evaluation]) -> CurveBasis:
    found = np.array(simulated_curves(target, evaluations))
    return CurveBasis.of(target, found, len(problem.scope_of(target.name).parameters))


def _with_components(scope: TestScope, names: Mapping[str, Sequence[str]]) -> TestScope:
    targets = [part for target in scope.targets for part in names.get(target, [target])]
    return replace(scope, targets=targets)
