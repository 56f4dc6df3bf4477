"""Advice: which further test would settle the parameters that the runs leave open."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np

from grainfit.analysis.further_tests import without_the_bench
from grainfit.analysis.information import (
    Knowledge,
    Measurable,
    Observation,
    in_relative_units,
    in_si_units,
)
from grainfit.analysis.intervals import interval_of
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
from grainfit.problem import Parameter
from grainfit.result import ParameterInterval
from grainfit.tables import TextTable, as_html, as_text

#: A test is worth doing if it narrows an open parameter at least to this share.
_WORTH_DOING = 0.9
#: Responses of a test that are named, best first.
_NAMED = 3


@dataclass(frozen=True)
class CandidateTest:
    """A test that could be measured, with what it tells.

    Parameters
    ----------
    name : str
        Its type, or its name in the file.
    seconds : float
        Estimated wall time of a run, s.
    responses : tuple of Measurable
        What it measures, and how that depends on the parameters.
    """

    name: str
    seconds: float
    responses: tuple[Measurable, ...]

    def by_signal(self, before: Knowledge) -> list[Measurable]:
        """Return the responses by span over error, the most telling one first."""
        return sorted(self.responses, key=lambda response: -response.signal(before))

    def observations(self, before: Knowledge, coarser: float = 1.0) -> list[Observation]:
        """Return what the test tells, with accuracies that are coarser by a factor.

        Of responses in one unit only the most telling one counts: angles of one surface say nearly
        the same, and slopes are not known well enough to make use of their differences.
        """
        ranked = reversed(self.by_signal(before))
        return [r.observation(coarser) for r in {r.unit: r for r in ranked}.values()]


@dataclass(frozen=True)
class Prospect:
    """The parameters as they would be known after one or more further tests.

    Parameters
    ----------
    tests : tuple of CandidateTest
        Tests to measure.
    intervals : mapping of str to ParameterInterval
        95 % interval of each open parameter, as wide as it is expected to be.
    shares : mapping of str to float
        Standard deviations of the open parameters over those of today.
    seconds : float
        Wall time of one parameter set in all tests, those of today included, s.
    """

    tests: tuple[CandidateTest, ...]
    intervals: Mapping[str, ParameterInterval]
    shares: Mapping[str, float]
    seconds: float

    @property
    def name(self) -> str:
        """Names of the tests."""
        return " + ".join(test.name for test in self.tests)

    @property
    def settled(self) -> tuple[str, ...]:
        """Open parameters that would be determined."""
        return tuple(
            name for name, left in self.intervals.items() if left.determination == "determined"
        )

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
class OpenParameters:
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
    """

    parameters: tuple[Parameter, ...]
    intervals: Mapping[str, ParameterInterval]
    values: Mapping[str, float]
    knowledge: Knowledge
    seconds: float

    def after(self, tests: Sequence[CandidateTest]) -> Prospect:
        """Return the parameters as they would be known after further tests."""
        observations = [seen for test in tests for seen in test.observations(self.knowledge)]
        then = self.knowledge.after(observations)
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
        return interval_of(parameter, *in_si_units(parameter, np.array([low, high])).tolist())


def _share(then: float, now: float) -> float:
    return then / now if now > 0 else 1.0


@dataclass(frozen=True)
class Advice:
    """Further tests, ranked by what they would settle.

    Parameters
    ----------
    today : OpenParameters
        The parameters that the runs leave open.
    prospects : tuple of Prospect
        One for each test that was simulated, best first.
    best_pair : Prospect, optional
        Two tests that settle more than the best one alone.
    remarks : tuple of str
        Sentences about tests that were not compared, or with other options than the usual ones.
    points, seeds : int
        Parameter sets that were simulated, and seeds of each.
    """

    today: OpenParameters
    prospects: tuple[Prospect, ...] = ()
    best_pair: Prospect | None = None
    remarks: tuple[str, ...] = ()
    points: int = 0
    seeds: int = 0

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
            return ("Every parameter is determined: no further test is needed.",)
        table = (self._table(),) if self.prospects else ()
        return (*table, *self._words(), *self.remarks)

    def __str__(self) -> str:
        return as_text(self.summary())

    def _repr_html_(self) -> str:
        return as_html(self.summary())

    def _table(self) -> TextTable:
        names = [p.name for p in self.today.parameters]
        now = tuple(_between(self.today.intervals[name]) for name in names)
        rows = [
            (
                prospect.name,
                *(_between(prospect.intervals[name]) for name in names),
                *_most_telling(prospect.tests[0], self.today.knowledge),
                duration(prospect.tests[0].seconds),
            )
            for prospect in self.prospects
        ]
        header = ("test", *short_names(names), "most telling", "over its error", "a run")
        return TextTable(
            header,
            (("today", *now, "", "", duration(self.today.seconds)), *rows),
            "95 % intervals that would be left. Most telling: the response that differs most among "
            "the parameter sets that fit, over its error. "
            f"{self.points} parameter sets, {counted(self.seeds, 'seed')} each.",
        )

    def _words(self) -> list[str]:
        if not self.prospects:
            return ["No further test could be compared."]
        words = [self._recommendation()]
        if self.best_pair is not None:
            left = _left_by(self.best_pair, self.today)
            words.append(f"{in_a_row([t.name for t in self.best_pair.tests])} leave {left}.")
        words += [
            f"None of these tests settles {name}. {without_the_bench(name)}".rstrip()
            for name in self.unsettled
        ]
        return words

    def _recommendation(self) -> str:
        best = self.best
        if best is None:
            return "None of these tests tells noticeably more than the runs do."
        test = best.tests[0]
        title = bulk_tests()[test.name].title if test.name in bulk_tests() else ""
        shown = f"{test.name} ({title})" if title else test.name
        return (
            f"Do next: {shown}. It would leave {_left_by(best, self.today)}. Measure "
            f"{in_a_row(_measured(test, self.today.knowledge))}."
        )


def advice(
    today: OpenParameters,
    candidates: Sequence[CandidateTest],
    remarks: Sequence[str],
    points: int,
    seeds: int,
) -> Advice:
    """Rank further tests by the parameters that they settle, and by information per effort.

    Parameters
    ----------
    today : OpenParameters
        The parameters that the runs leave open.
    candidates : sequence of CandidateTest
        Tests that were simulated.
    remarks : sequence of str
        Sentences about tests that were not, or with other options than the usual ones.
    points, seeds : int
        Parameter sets that were simulated, and seeds of each.

    Returns
    -------
    Advice
    """
    single = ranked([today.after([test]) for test in candidates])
    pairs = ranked([today.after(pair) for pair in combinations(candidates, 2)])
    pair = pairs[0] if pairs and len(pairs[0].settled) > len(single[0].settled) else None
    return Advice(today, single, pair, tuple(remarks), points, seeds)


def ranked(prospects: Sequence[Prospect]) -> tuple[Prospect, ...]:
    """Return prospects by merit, best first."""
    return tuple(sorted(prospects, key=lambda prospect: prospect.merit, reverse=True))


def _between(interval: ParameterInterval) -> str:
    return ends(interval.low, interval.high)


def _most_telling(test: CandidateTest, before: Knowledge) -> tuple[str, str]:
    best = test.by_signal(before)[0]
    return best.name.rpartition(".")[2], number(best.signal(before), 2)


def _measured(test: CandidateTest, before: Knowledge) -> list[str]:
    """Name the most telling responses with the accuracy that is assumed."""
    infos = bulk_tests()[test.name].responses if test.name in bulk_tests() else {}
    words = []
    for response in test.by_signal(before)[:_NAMED]:
        short = response.name.rpartition(".")[2]
        unit = infos[short].unit if short in infos else ""
        words.append(f"{short} to {response.accuracy.in_words(unit)}")
    return words


def _left_by(prospect: Prospect, today: OpenParameters) -> str:
    """Say what would be left of every open parameter, with the word for it."""
    words = []
    for parameter in today.parameters:
        left = prospect.intervals[parameter.name]
        between = with_unit(_between(left), unit_for_people(parameter.unit))
        words.append(f"{parameter.name} {between} ({left.determination})")
    return in_a_row(words)
