"""What checks see of a calibration before its first run."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass, field
from typing import Any, TypeVar

from grainfit.bulk_tests.base import BulkTest
from grainfit.evaluation import response_name
from grainfit.problem import Problem
from grainfit.solvers.base import Solver

_Found = TypeVar("_Found")


@dataclass(frozen=True)
class CheckContext:
    """A calibration before its first run, as checks see it.

    Parameters
    ----------
    problem : Problem
        Free parameters and targets.
    solvers : mapping of str to Solver
        By name of the test.
    fixed : mapping of str to float
        Parameters that are not free.
    test_keys : mapping of str to str
        Key of each test in the calibration file, ``test[0]`` that of the first, by name.
    twins : collection of str
        Tests of which a smaller apparatus is simulated.
    """

    problem: Problem
    solvers: Mapping[str, Solver]
    fixed: Mapping[str, float] = field(default_factory=dict)
    test_keys: Mapping[str, str] = field(default_factory=dict)
    twins: Collection[str] = ()
    _known: dict[object, Any] = field(default_factory=dict, init=False, repr=False, compare=False)

    def once(self, find: Callable[[Problem, Mapping[str, Solver]], _Found]) -> _Found:
        """Return what a function finds of problem and solvers; several checks share it."""
        if find not in self._known:
            self._known[find] = find(self.problem, self.solvers)
        found: _Found = self._known[find]
        return found

    @property
    def bulk_tests(self) -> dict[str, BulkTest]:
        """The bulk tests that are simulated, by name of the test."""
        tests = {name: solver.bulk_test for name, solver in self.solvers.items()}
        return {name: test for name, test in tests.items() if test is not None}

    @property
    def intervals(self) -> dict[str, tuple[float, float]]:
        """Ends of the interval of every parameter; twice the value of a fixed one."""
        fixed = {name: (value, value) for name, value in self.fixed.items()}
        return {**fixed, **{p.name: (p.minimum, p.maximum) for p in self.problem.parameters}}

    @property
    def lowest(self) -> dict[str, float]:
        """Values of all parameters at the lower ends of their intervals."""
        return {name: ends[0] for name, ends in self.intervals.items()}

    @property
    def highest(self) -> dict[str, float]:
        """Values of all parameters at the upper ends of their intervals."""
        return {name: ends[1] for name, ends in self.intervals.items()}

    def targets_of(self, test: str) -> dict[str, float | None]:
        """Return the measured values of a bulk test by response, None for a curve."""
        values = {target.name: target.value for target in self.problem.targets}
        count, responses = len(self.solvers), self.problem.responses
        known = self.bulk_tests[test].response_names or ()
        names = {one: response_name(test, one, count) for one in known}
        return {one: values.get(full) for one, full in names.items() if full in responses}

    def key(self, test: str, key: str = "") -> str:
        """Return the key of a test, or a key of its table."""
        return ".".join(filter(None, (self.test_keys.get(test, ""), key)))
