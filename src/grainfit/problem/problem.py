"""Calibration problems: free parameters, targets, and the Rayleigh time step."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from grainfit.errors import Fault, InputError
from grainfit.materials.time_step import RayleighTimeStep
from grainfit.one_line import as_call, shortened
from grainfit.problem import messages
from grainfit.problem.correlations import (
    Correlation,
    correlated_groups,
    correlation_faults,
    correlation_matrix,
    split_covariance,
)
from grainfit.problem.curve_target import CurveTarget
from grainfit.problem.parameter import Parameter
from grainfit.problem.quantities import make_floats, shown
from grainfit.problem.target import LARGEST_WEIGHT, Target
from grainfit.problem.test_scope import (
    Relative,
    TestScope,
    relative_faults,
    repeated_names,
    scope_faults,
)
from grainfit.validation import as_number, list_faults, mapping_faults

#: Arguments that map names to values, with examples.
_BY_NAME = {
    "scatters": '{"angle": 0.5}',
    "ratios": '{"angle": 1.1}',
}


@dataclass(frozen=True)
class Problem:
    """Free parameters, targets, and the Rayleigh time step, if it is known.

    Parameters
    ----------
    parameters : sequence of Parameter
        Free parameters.
    targets : sequence of Target
        Targets to meet.
    rayleigh : RayleighTimeStep, optional
        Rayleigh time step of the material; without it, time steps are not part of the problem.
    rayleigh_weight : float
        Weight of the Rayleigh criterion (equation 2) among the residuals. 0 by default: as a
        summand of the misfit it trades accuracy for speed.
    correlations : sequence of (str, str, float)
        Correlations of the errors of measured values: two targets and a coefficient between -1 and
        1. Pairs that are not named are not correlated. See `with_covariance`.
    tests : sequence of TestScope
        The tests, when there are several: then a proposal may be for some of them. Empty when
        every run yields all targets.
    curves : sequence of CurveTarget
        Measured curves to meet.
    scatters : mapping of str to float
        Standard deviations of responses from run to run, by name, where they are known before the
        runs. They count as the estimates of five more runs, unless the runs contradict them.
    relatives : sequence of Relative
        Cheaper relatives of the tests, at most one of each: their runs tell where those of the
        tests are worth making. Proposals name the tests and the relatives that they are for.
    ratios : mapping of str to float
        Responses of the laboratory's apparatus over those of the smaller one that is simulated,
        by name of the target; 1 for the others. Targets and evaluations are the laboratory's.

    Raises
    ------
    InputError
        No parameters, neither targets nor curves, a name given twice, a Rayleigh time step that
        lacks a value, or correlations that name no targets or contradict each other.

    Examples
    --------
    >>> problem = Problem([Parameter("friction", 0.1, 0.9)], [Target("angle", 30.0)])
    >>> problem.from_unit([0.5])
    {'friction': 0.5}
    """

    parameters: Sequence[Parameter]
    targets: Sequence[Target]
    rayleigh: RayleighTimeStep | None = None
    rayleigh_weight: float = 0.0
    correlations: Sequence[Correlation] = ()
    tests: Sequence[TestScope] = ()
    curves: Sequence[CurveTarget] = ()
    scatters: Mapping[str, float] = field(default_factory=dict, hash=False)
    relatives: Sequence[Relative] = ()
    ratios: Mapping[str, float] = field(default_factory=dict, hash=False)

    def __post_init__(self) -> None:
        kinds = {
            "parameters": Parameter,
            "targets": Target,
            "tests": TestScope,
            "curves": CurveTarget,
            "relatives": Relative,
        }
        for key, kind in kinds.items():
            InputError.raise_for(list_faults(key, getattr(self, key), kind))
            object.__setattr__(self, key, tuple(getattr(self, key)))
        for key, example in _BY_NAME.items():
            InputError.raise_for(mapping_faults(key, getattr(self, key), example))
        InputError.raise_for([*self._faults()] or self._read_correlations())
        make_floats(self, "rayleigh_weight")

    def _faults(self) -> Iterator[Fault]:
        parameters = [parameter.name for parameter in self.parameters]
        for kind, names in (("parameter", parameters), ("target", list(self.responses))):
            if not names:
                yield messages.EMPTY.fault(f"{kind}s", kind=kind)
            yield from repeated_names(kind, names)
        if not 0 <= as_number(self.rayleigh_weight) <= LARGEST_WEIGHT:
            given = shown(self.rayleigh_weight)
            key = "rayleigh_weight"
            yield messages.BAD_RAYLEIGH_WEIGHT.fault(key, given=given, most=LARGEST_WEIGHT)
        yield from self._faults_by_target("scatters", self.scatters)
        yield from self._faults_by_target("ratios", self.ratios)
        yield from scope_faults(self.tests, parameters)
        yield from relative_faults(self.relatives, self.tests)
        if isinstance(self.rayleigh, RayleighTimeStep):
            yield from self.rayleigh.faults(self.intervals)
        elif self.rayleigh is not None:
            yield messages.NO_RAYLEIGH.fault("rayleigh", given=shown(self.rayleigh))

    def _faults_by_target(self, key: str, given: Mapping[str, float]) -> Iterator[Fault]:
        names = [target.name for target in self.targets]
        for name, value in given.items():
            if name not in names:
                known = ", ".join(names) or "none"
                yield messages.NOT_A_TARGET.fault(f"{key}.{name}", known=known)
            elif not 0 < as_number(value) < math.inf:
                yield messages.NOT_ABOVE_ZERO.fault(f"{key}.{name}", given=shown(value))

    def _read_correlations(self) -> list[Fault]:
        given = self.correlations
        try:
            pairs = [(first, second, value) for first, second, value in given]
            are_named = all(isinstance(name, str) for *names, _ in pairs for name in names)
        except (TypeError, ValueError):
            are_named = False
        if not are_named:
            return [messages.NO_TRIPLES.fault("correlations", given=shortened(given))]
        plain = tuple((str(a), str(b), as_number(value)) for a, b, value in pairs)
        object.__setattr__(self, "correlations", plain)
        return correlation_faults([target.name for target in self.targets], pairs)

    def __repr__(self) -> str:
        names = {"parameters": [*self.intervals], "targets": [*self.responses]}
        return as_call("Problem", names)

    @property
    def responses(self) -> tuple[str, ...]:
        """Names of all responses that were measured: those of the targets, then the curves."""
        return (*(t.name for t in self.targets), *(curve.name for curve in self.curves))

    @property
    def units(self) -> dict[str, str]:
        """Units of parameters and responses by name, in which their values are."""
        return {item.name: item.unit for item in self.parameters} | {
            **{target.name: target.unit for target in self.targets},
            **{curve.name: curve.unit for curve in self.curves},
        }

    @cached_property
    def correlation_matrix(self) -> NDArray[np.float64]:
        """Correlations of the errors of the measured values, shape (targets, targets)."""
        return correlation_matrix([target.name for target in self.targets], self.correlations)

    @cached_property
    def precision_matrix(self) -> NDArray[np.float64]:
        """Inverse of the correlation matrix."""
        return np.asarray(np.linalg.inv(self.correlation_matrix))

    @cached_property
    def decorrelation(self) -> NDArray[np.float64]:
        """Matrix that combines deviations into as many that are not correlated.

        The inverse of the Cholesky factor of the correlation matrix.
        """
        return np.asarray(np.linalg.inv(np.linalg.cholesky(self.correlation_matrix)))

    def is_met_by(self, responses: Sequence[float] | NDArray[np.float64]) -> bool:
        """Return True if responses, in the order of the targets, meet them.

        Each is within its tolerance. Correlated ones also go together: the mean square of their
        decorrelated deviations is at most one tolerance squared.
        """
        pairs = list(zip(self.targets, map(float, responses), strict=True))
        if not all(target.is_met_by(response) for target, response in pairs):
            return False
        deviations = [(response - target.value) / target.tolerance for target, response in pairs]
        scaled = np.array(deviations)
        precision = self.precision_matrix
        return all(
            float(scaled[group] @ precision[np.ix_(group, group)] @ scaled[group]) <= len(group)
            for group in correlated_groups(self.correlation_matrix)
        )

    def with_covariance(self, covariance: ArrayLike) -> Problem:
        """Return the problem with a covariance of the errors of the measured values.

        Parameters
        ----------
        covariance : array_like, shape (n, n)
            Of the n targets, in their order and units. It replaces their uncertainties, and
            tolerances that were the default.

        Raises
        ------
        InputError
            The matrix has another shape, is not symmetric, or is not positive definite.

        Examples
        --------
        >>> targets = [Target("density", 1500.0), Target("angle", 30.0)]
        >>> problem = Problem([Parameter("friction", 0.1, 0.9)], targets)
        >>> problem.with_covariance([[225.0, 6.0], [6.0, 0.25]]).correlations
        (('density', 'angle', 0.8),)
        """
        names = [target.name for target in self.targets]
        errors, correlations = split_covariance(names, covariance)
        targets = [
            Target(**{**target.to_json(), "uncertainty": float(error)})
            for target, error in zip(self.targets, errors, strict=True)
        ]
        return replace(self, targets=targets, correlations=correlations)

    def with_targets(
        self, targets: Sequence[Target], curves: Sequence[CurveTarget] = ()
    ) -> Problem:
        """Return the problem with some targets and curves, and the correlations among these."""
        InputError.raise_for(list_faults("targets", targets, Target))
        names = {target.name for target in targets}
        kept = [pair for pair in self.correlations if {pair[0], pair[1]} <= names]
        return replace(
            self,
            targets=tuple(targets),
            correlations=tuple(kept),
            curves=tuple(curves),
            scatters={name: value for name, value in self.scatters.items() if name in names},
            ratios={name: value for name, value in self.ratios.items() if name in names},
        )

    @property
    def dimension(self) -> int:
        """Number of free parameters."""
        return len(self.parameters)

    @cached_property
    def intervals(self) -> dict[str, tuple[float, float]]:
        """Bounds by parameter name."""
        return {p.name: (p.minimum, p.maximum) for p in self.parameters}

    @cached_property
    def scopes(self) -> tuple[TestScope, ...]:
        """The tests; one of all targets and parameters when no tests are given."""
        if self.tests:
            return tuple(self.tests)
        return (TestScope("", self.responses, [parameter.name for parameter in self.parameters]),)

    @cached_property
    def relative_scopes(self) -> tuple[TestScope, ...]:
        """The relatives of tests that can be run, with the targets that they tell about."""
        can_run = [one for one in self.relatives if one.cost is not None]
        return tuple(one.scope(self.scope_of_test(one.of)) for one in can_run)

    def scope_of_test(self, test: str) -> TestScope:
        """Return the scope of the test of a relative; InputError if there is none."""
        for scope in self.scopes:
            if scope.name == test:
                return scope
        known = ", ".join(scope.name for scope in self.tests) or "none"
        raise InputError(messages.RELATIVE_OF_NO_TEST.fault("relatives", of=test, known=known))

    def relative_of(self, target: str) -> Relative | None:
        """Return the relative of the test that yields a target; None without one."""
        test = self.scope_of(target).name
        return next((one for one in self.relatives if one.of == test), None)

    def axes_of(self, scope: TestScope) -> list[int]:
        """Return the axes of the unit cube that a test depends on."""
        return [i for i, p in enumerate(self.parameters) if p.name in scope.parameters]

    def scope_of(self, target: str) -> TestScope:
        """Return the test that yields a target; all tests together when none names it."""
        found = [scope for scope in self.scopes if target in scope.targets]
        return found[0] if found else replace(self, tests=()).scopes[0]

    def targets_of(self, test: str) -> dict[str, Target]:
        """Return the targets of a test by name of the response in it; all where no test is named.

        Parameters
        ----------
        test : str
            Name of the test.
        """
        own = [target for target in self.targets if self._is_of(target.name, test)]
        return {target.name.removeprefix(f"{test}."): target for target in own}

    def measured_in(self, test: str) -> dict[str, Target | CurveTarget]:
        """Return all that was measured in a test by name of the response in it, curves included.

        Parameters
        ----------
        test : str
            Name of the test.
        """
        own = [curve for curve in self.curves if self._is_of(curve.name, test)]
        curves = {curve.name.removeprefix(f"{test}."): curve for curve in own}
        return {**self.targets_of(test), **curves}

    def _is_of(self, response: str, test: str) -> bool:
        return not self.tests or self.scope_of(response).name == test

    def widened_to(self, points: Sequence[Mapping[str, float]]) -> Problem:
        """Return the problem with its intervals widened to some parameter sets."""
        parameters = [p.widened_to([values[p.name] for values in points]) for p in self.parameters]
        return replace(self, parameters=parameters)

    def to_unit(self, values: Mapping[str, float]) -> NDArray[np.float64]:
        """Map parameter values to a point of the unit cube, shape (d,)."""
        return np.array([p.to_unit(values[p.name]) for p in self.parameters])

    def from_unit(self, point: ArrayLike) -> dict[str, float]:
        """Map a point of the unit cube, shape (d,), to parameter values."""
        positions = np.asarray(point, dtype=float)
        return {
            p.name: float(p.from_unit(float(position)))
            for p, position in zip(self.parameters, positions, strict=True)
        }

    def rounded(self, values: Mapping[str, float]) -> dict[str, float]:
        """Round parameter values to the digits that people read, within the bounds.

        Examples
        --------
        >>> from grainfit import Parameter, Problem, Target
        >>> problem = Problem([Parameter("friction", 0.1, 0.9)], [Target("angle", 30.0)])
        >>> problem.rounded({"friction": 0.43219876})
        {'friction': 0.4322}
        """
        return {p.name: p.rounded(values[p.name]) for p in self.parameters}

    @property
    def middle(self) -> dict[str, float]:
        """Values in the middle of all intervals, each on its scale."""
        return self.from_unit([0.5] * self.dimension)

    @cached_property
    def measured(self) -> tuple[Parameter, ...]:
        """Free parameters that have a measurement of their own."""
        return tuple(p for p in self.parameters if p.measured is not None)

    def standardised_residuals(self, points: ArrayLike) -> NDArray[np.float64]:
        """Return deviations of parameters from their own measurements, in standard uncertainties.

        Parameters
        ----------
        points : array_like, shape (m, d)
            Points of the unit cube.

        Returns
        -------
        ndarray, shape (m, number of measured parameters)
        """
        at = np.atleast_2d(np.asarray(points, dtype=float))
        residuals = np.empty((len(at), len(self.measured)))
        for column, (axis, parameter) in zip(residuals.T, self._measured_axes, strict=True):
            column[:] = [parameter.standardised_residual(float(u)) for u in at[:, axis]]
        return residuals

    def standardised_residual_slopes(self, points: ArrayLike) -> NDArray[np.float64]:
        """Return slopes of `standardised_residuals`, shape (m, measured parameters, d)."""
        at = np.atleast_2d(np.asarray(points, dtype=float))
        slopes = np.zeros((len(at), len(self.measured), self.dimension))
        for row, (axis, parameter) in enumerate(self._measured_axes):
            along = [parameter.standardised_residual_slope(float(u)) for u in at[:, axis]]
            slopes[:, row, axis] = along
        return slopes

    @property
    def _measured_axes(self) -> list[tuple[int, Parameter]]:
        return [(axis, p) for axis, p in enumerate(self.parameters) if p.measured is not None]

    def rayleigh_time_step(self, values: Mapping[str, float]) -> float | None:
        """Return the Rayleigh time step at these parameter values, s; None if it is not known."""
        return None if self.rayleigh is None else self.rayleigh(values)

    def rayleigh_criterion(self, values: Mapping[str, float]) -> float:
        """Return the Rayleigh criterion (equation 2) at these values; 0 without a time step."""
        return 0.0 if self.rayleigh is None else self.rayleigh.criterion(values, self.intervals)
