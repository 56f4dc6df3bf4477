"""Scopes of tests: the targets of each of several tests, its parameters, and its cost."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass

from grainfit.errors import Fault, InputError
from grainfit.one_line import OneLine
from grainfit.problem import messages
from grainfit.problem.quantities import make_floats
from grainfit.relative_names import relative_name
from grainfit.validation import as_number, set_plain, whole_number_faults

#: Rounding errors of a sum of costs: ten times 0.1 are 1.
_ROUNDING = 1e-9


@dataclass(frozen=True)
class TestScope(OneLine):
    """One of several tests of a problem: its targets, the parameters it depends on, and its cost.

    Parameters
    ----------
    name : str
        Name of the test.
    targets : sequence of str
        Names of the targets that its runs yield.
    parameters : sequence of str
        Names of the free parameters that it depends on. Its metamodels have only these.
    seconds : float, optional
        Estimated wall time of a run, s; None if it is not known.
    repeats : int
        Runs with different seeds whose mean is one evaluation.

    Examples
    --------
    >>> TestScope("drop", ["drop.rebound"], ["restitution"], seconds=2.0).parameters
    ('restitution',)
    """

    name: str
    targets: Sequence[str]
    parameters: Sequence[str]
    seconds: float | None = None
    repeats: int = 1

    # Keeps pytest from taking it for a class of tests.
    __test__ = False

    def __post_init__(self) -> None:
        if not isinstance(self.name, str):
            raise InputError(messages.NO_TEST_NAME.fault("test", given=self.name))
        set_plain(self, "repeats")
        InputError.raise_for(whole_number_faults({f"{self.name}.repeats": self.repeats}))
        for key in ("targets", "parameters"):
            names = getattr(self, key)
            is_list = isinstance(names, Sequence) and not isinstance(names, str)
            if not is_list or not names or not all(isinstance(name, str) for name in names):
                raise InputError(messages.NO_LIST_OF_NAMES.fault(f"{self.name}.{key}", given=names))
            object.__setattr__(self, key, tuple(names))
        if self.seconds is not None and not 0 < as_number(self.seconds) < math.inf:
            raise InputError(
                messages.NOT_ABOVE_ZERO.fault(f"{self.name}.seconds", given=repr(self.seconds))
            )
        make_floats(self, "seconds")


@dataclass(frozen=True)
class Relative(OneLine):
    """A cheaper relative of a test: the same test of softer or larger particles, for example.

    Its runs tell where those of the test are worth making; no verdict rests on them.

    Parameters
    ----------
    of : str
        Name of the test.
    cost : float, optional
        Computing time of its run, in runs of the test; above 0 and below 1. None where its runs
        are known from earlier calibrations: then no more are made.

    Examples
    --------
    >>> Relative("heap", cost=0.25).response_name("heap.angle")
    'heap (relative).angle'
    """

    of: str
    cost: float | None

    def __post_init__(self) -> None:
        if not isinstance(self.of, str):
            raise InputError(messages.NO_TEST_NAME.fault("relative", given=self.of))
        if self.cost is None:
            return
        if not 0 < as_number(self.cost) < 1:
            key = f"{self.of}.cost"
            raise InputError(messages.NOT_CHEAPER.fault(key, given=repr(self.cost)))
        make_floats(self, "cost")

    @property
    def name(self) -> str:
        """Name of its runs."""
        return relative_name(self.of)

    def response_name(self, target: str) -> str:
        """Return the name of its response for a target of the test."""
        return f"{self.name}.{target.removeprefix(f'{self.of}.')}"

    def scope(self, of: TestScope) -> TestScope:
        """Return the scope of its runs, with the targets of the test that it tells about."""
        return TestScope(self.name, of.targets, of.parameters)


def named_test(scope: str, tests: Iterable[str]) -> str:
    """Return the name of the test of a scope by that of the scope: of an only test it has none.

    Examples
    --------
    >>> named_test("", ["heap"]), named_test("drop", ["heap", "drop"])
    ('heap', 'drop')
    """
    return scope or next(iter(tests))


def cost_of_relatives(relatives: Sequence[Relative], tests: Iterable[str]) -> int:
    """Return the whole runs of tests that cost as much as those runs that are of relatives.

    Parameters
    ----------
    relatives : sequence of Relative
        The relatives of a problem. Runs of earlier calibrations cost nothing.
    tests : iterable of str
        Name of the test or the relative of each run.

    Examples
    --------
    >>> cost_of_relatives([Relative("heap", 0.1)], ["heap (relative)"] * 10 + ["heap"])
    1
    """
    costs = {one.name: one.cost or 0.0 for one in relatives}
    return math.floor(sum(costs.get(test, 0.0) for test in tests) + _ROUNDING)


def relative_faults(relatives: Sequence[Relative], tests: Sequence[TestScope]) -> Iterator[Fault]:
    """Yield the faults of the relatives of a problem with these tests."""
    names = [test.name for test in tests]
    for relative in relatives:
        if names and relative.of not in names:
            known = ", ".join(names)
            yield messages.RELATIVE_OF_NO_TEST.fault("relatives", of=relative.of, known=known)
    yield from repeated_names("test with a relative", [relative.of for relative in relatives])


def scope_faults(tests: Sequence[TestScope], parameters: Sequence[str]) -> Iterator[Fault]:
    """Yield the faults of the tests of a problem with these parameters."""
    for test in tests:
        for name in test.parameters:
            if name not in parameters:
                known = ", ".join(parameters)
                key = f"{test.name}.parameters"
                yield messages.NOT_A_PARAMETER.fault(key, name=name, known=known)
    yield from repeated_names("test", [test.name for test in tests])
    yield from repeated_names("target of a test", [name for test in tests for name in test.targets])


def repeated_names(kind: str, names: Sequence[str]) -> list[Fault]:
    """Return a fault for every name that is given more than once."""
    return [
        messages.GIVEN_TWICE.fault(name, kind=kind)
        for name in sorted({name for name in names if names.count(name) > 1})
    ]
