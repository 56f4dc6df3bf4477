"""Advice: the next test, for the parameters that the runs leave open."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np

from grainfit.bulk_tests.registry import bulk_tests
from grainfit.formatting import (
    counted,
    duration,
    ends,
    in_a_row,
    number,
    short_names,
    unit_for_people,
    with_unit,
)
from grainfit.one_line import OneLine, as_call
from grainfit.problem import Parameter
from grainfit.result import ParameterInterval
from grainfit.tables import Summary, TextTable
from grainfit.which_test import messages
from grainfit.which_test.candidate import Candidate, knowledge_after, names_of
from grainfit.which_test.determination import interval_of
from grainfit.which_test.determining_tests import other_measurement
from grainfit.which_test.knowledge import Knowledge, in_relative_units, in_si_units

#: A test is worth doing if it narrows an open parameter at least to this share.
_WORTH_DOING = 0.9
#: Responses of a test that are named, best first.
_NAMED = 3


@dataclass(frozen=True)
class Prospect:
    """The parameters as they would be known after one or more further tests.

    Parameters
    ----------
    tests : tuple of Candidate
        Tests to measure.
    intervals : mapping of str to ParameterInterval
        95 % interval of each open parameter, as wide as it is expected to be.
    shares : mapping of str to float
        Standard deviations of the open parameters over those of today.
    seconds : float
        Wall time of one parameter set in all tests, those of today included, s.
    """

    tests: tuple[Candidate, ...]
    intervals: Mapping[str, ParameterInterval]
    shares: Mapping[str, float]
    seconds: float

    @property
    def name(self) -> str:
        """Names of the tests."""
        return names_of(self.tests)

    @property
    def settled(self) -> tuple[str, ...]:
        """Open parameters that would be determined."""
        return tuple(name for name, left in self.intervals.items() if left.is_determined)

    @property
    def merit(self) -> tuple[int, float]:
        """Number of parameters settled, then information on the open parameters per effort."""
        gained = -sum(math.log(max(share, 1e-9)) for share in self.shares.values())
        return len(self.settled), gained / max(self.seconds, 1e-9)

    @property
    def is_worth_doing(self) -> bool:
        """Whether an open parameter would be known noticeably better."""
        return min(self.shares.values(), default=1.0) <= _WORTH_DOING


@dataclass(frozen=True)
class OpenParameters(OneLine):
    """Parameters of a calibration as they are known today.

    Parameters
    ----------
    parameters : tuple of Parameter
        Free parameters that the runs leave open.
    intervals : mapping of str to ParameterInterval
        Their 95 % intervals.
    values : mapping of str to float
        Medians, about which the intervals after further tests are shown.
    knowledge : Knowledge
        Covariance of all free parameters.
    seconds : float
        Wall time of one parameter set in the tests of today, s.
    measured : tuple of str
        Names of the targets that there are.
    """

    parameters: tuple[Parameter, ...]
    intervals: Mapping[str, ParameterInterval]
    values: Mapping[str, float]
    knowledge: Knowledge
    seconds: float
    measured: tuple[str, ...] = ()

    def after(self, tests: Sequence[Candidate]) -> Prospect:
        """Return the parameters as they would be known after further tests."""
        then = knowledge_after(self.knowledge, tests)
        shares = {
            p.name: _share(then.deviation(p.name), self.knowledge.deviation(p.name))
            for p in self.parameters
        }
        left = {p.name: self._left(p, then.half_width(p.name)) for p in self.parameters}
        seconds = self.seconds + sum(test.seconds for test in tests)
        return Prospect(tuple(tests), left, shares, seconds)

    def _left(self, parameter: Parameter, half_width: float) -> ParameterInterval:
        """Return an interval of this half-width about the value, within that of today."""
        now = self.intervals[parameter.name]
        ends = [now.low, self.values[parameter.name], now.high]
        first, value, last = in_relative_units(parameter, np.array(ends)).tolist()
        low = max(min(value - half_width, last - 2 * half_width), first)
        high = min(low + 2 * half_width, last)
        low, high = in_si_units(parameter, np.array([low, high])).tolist()
        return interval_of(parameter, low, high, now.bias)


def _share(then: float, now: float) -> float:
    return then / now if now > 0 else 1.0


@dataclass(frozen=True, repr=False)
class Advice(Summary):
    """Further tests, ranked by what they would settle.

    Parameters
    ----------
    today : OpenParameters
        The parameters that the runs leave open.
    prospects : tuple of Prospect
        One for each test that was compared, best first.
    best_pair : Prospect, optional
        Two tests that settle more than the best one alone.
    remarks : tuple of str
        Sentences about tests that were not compared, or with other options than the usual ones.
    points, seeds : int
        Parameter sets that were simulated, and seeds of each; 0 where the atlas was asked.
    """

    today: OpenParameters
    prospects: tuple[Prospect, ...] = ()
    best_pair: Prospect | None = None
    remarks: tuple[str, ...] = ()
    points: int = 0
    seeds: int = 0

    def __repr__(self) -> str:
        best = self.best.name if self.best else None
        return as_call("Advice", {"best": best, "unsettled": self.unsettled})

    @property
    def best(self) -> Prospect | None:
        """The test to do next; None if none is worth it."""
        first = next(iter(self.prospects), None)
        return first if first is not None and first.is_worth_doing else None

    @property
    def unsettled(self) -> tuple[str, ...]:
        """Open parameters that none of the tests settles, alone or in the best pair."""
        looked_at = [*self.prospects, *([self.best_pair] if self.best_pair else [])]
        settled = {name for prospect in looked_at for name in prospect.settled}
        return tuple(p.name for p in self.today.parameters if p.name not in settled)

    def summary(self) -> tuple[str | TextTable, ...]:
        """Return the table and the sentences that `print` and a notebook show."""
        if not self.today.parameters:
            return (messages.ALL_DETERMINED(),)
        if not self.prospects:
            return (messages.NO_FURTHER_TEST_COMPARED(), *self.remarks)
        return (self._table(), *self._sentences(), *self.remarks)

    def _table(self) -> TextTable:
        names = [p.name for p in self.today.parameters]
        now = tuple(_between(self.today.intervals[name]) for name in names)
        rows = [
            (
                prospect.name,
                *(_between(prospect.intervals[name]) for name in names),
                *self._most_telling(prospect.tests[0]),
                duration(prospect.tests[0].seconds),
            )
            for prospect in self.prospects
        ]
        units = (unit_for_people(p.unit) for p in self.today.parameters)
        shown = (
            f"{name}, {unit}" if unit else name
            for name, unit in zip(short_names(names), units, strict=True)
        )
        header = ("test", *shown, "most telling", "over its error", "a run")
        return TextTable(
            header,
            (("today", *now, "", "", duration(self.today.seconds)), *rows),
            "95 % intervals that would be left. Most telling: the response that differs most among "
            f"the parameter sets that fit, over its error. {self._source()}",
        )

    def _source(self) -> str:
        if not self.points:
            return messages.NEXT_BY_ATLAS()
        return f"{self.points} parameter sets, {counted(self.seeds, 'seed')} each."

    def _most_telling(self, test: Candidate) -> tuple[str, str]:
        best = test.by_signal(self.today.knowledge)[0]
        return best.short_name, number(best.signal_to_noise(self.today.knowledge), 2)

    def _sentences(self) -> list[str]:
        sentences = [self._recommendation()]
        if self.best_pair is not None:
            tests = in_a_row([t.name for t in self.best_pair.tests])
            sentences.append(messages.PAIR_LEAVES(tests=tests, left=self._left_by(self.best_pair)))
        sentences += [
            messages.NOT_SETTLED_BY_ANY(
                name=name, otherwise=other_measurement(name, self.today.measured)
            ).rstrip()
            for name in self.unsettled
        ]
        return sentences

    def _recommendation(self) -> str:
        best = self.best
        if best is None:
            return messages.NOTHING_WORTH_DOING()
        test = best.tests[0]
        title = bulk_tests()[test.name].title if test.name in bulk_tests() else ""
        return messages.DO_NEXT(
            test=f"{test.name} ({title})" if title else test.name,
            left=self._left_by(best),
            responses=in_a_row(self._named(test)),
        )

    def _named(self, test: Candidate) -> list[str]:
        """Name the most telling responses with the accuracy that is assumed."""
        infos = bulk_tests()[test.name].responses if test.name in bulk_tests() else {}
        return [
            f"{r.short_name} to "
            + r.accuracy.in_words(infos[r.short_name].unit if r.short_name in infos else "")
            for r in test.by_signal(self.today.knowledge)[:_NAMED]
        ]

    def _left_by(self, prospect: Prospect) -> str:
        """Say what would be left of every open parameter, with the word for it."""
        left = [(p, prospect.intervals[p.name]) for p in self.today.parameters]
        return in_a_row(
            [
                f"{p.name} {with_unit(_between(found), unit_for_people(p.unit))} "
                f"({found.determination})"
                for p, found in left
            ]
        )


def rank_tests(
    today: OpenParameters,
    candidates: Sequence[Candidate],
    remarks: Sequence[str],
    points: int = 0,
    seeds: int = 0,
) -> Advice:
    """Rank further tests by the parameters that they settle, and by information per effort.

    Parameters
    ----------
    today, remarks, points, seeds
        As for `Advice`.
    candidates : sequence of Candidate
        Tests that are compared.
    """
    single = _ranked([today.after([test]) for test in candidates])
    pairs = _ranked([today.after(pair) for pair in combinations(candidates, 2)])
    pair = pairs[0] if pairs and len(pairs[0].settled) > len(single[0].settled) else None
    return Advice(today, single, pair, tuple(remarks), points, seeds)


def _ranked(prospects: Sequence[Prospect]) -> tuple[Prospect, ...]:
    return tuple(sorted(prospects, key=lambda prospect: prospect.merit, reverse=True))


def _between(interval: ParameterInterval) -> str:
    return ends(interval.low, interval.high)
