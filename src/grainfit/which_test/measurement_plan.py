"""Plan of laboratory measurements: combinations of tests that determine the free parameters."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import chain, combinations

from grainfit.bulk_tests.registry import response_info
from grainfit.formatting import duration, in_a_row, number, short_names
from grainfit.tables import Summary, TextTable
from grainfit.which_test import messages
from grainfit.which_test.candidate import Candidate, knowledge_after, names_of
from grainfit.which_test.determining_tests import other_measurement
from grainfit.which_test.knowledge import Knowledge

#: Most tests of a combination.
MOST_TESTS = 3
#: Factors on all accuracies that are tried.
_FINEST, _COARSEST = 0.05, 20.0
_HALVINGS = 20
_SHOWN = 8


@dataclass(frozen=True)
class Combination:
    """Tests that are measured together, and what they leave.

    Parameters
    ----------
    tests : tuple of Candidate
        One to three tests.
    half_widths : mapping of str to float
        Half the width of the 95 % interval of each free parameter, a share of its value.
    coarser : float
        Largest factor on the accuracies with which the wanted interval is still reached; 0 if none
        is fine enough.
    """

    tests: tuple[Candidate, ...]
    half_widths: Mapping[str, float]
    coarser: float

    @property
    def name(self) -> str:
        """Names of the tests."""
        return names_of(self.tests)

    @property
    def seconds(self) -> float:
        """Estimated wall time of one parameter set in all its tests, s."""
        return sum(test.seconds for test in self.tests)


@dataclass(frozen=True, repr=False)
class MeasurementPlan(Summary):
    """Combinations of tests, ranked by whether they determine the parameters, and by cost.

    Parameters
    ----------
    wanted : float
        Wanted half-width of 95 % intervals, a share of the value.
    before : Knowledge
        The parameters before any test.
    combinations : tuple of Combination
        Those that reach the wanted interval first, fewest tests and cheapest first, without those
        that only add a test to one of them; then the others, nearest to it first.
    remarks : tuple of str
        Sentences about tests that were not compared, or with other options than the usual ones.
    source : str
        Origin of the slopes, for readers.
    taken_as_known : tuple of str
        Free parameters that are not counted, because nothing is known of their effect.
    """

    wanted: float
    before: Knowledge
    combinations: tuple[Combination, ...]
    remarks: tuple[str, ...] = ()
    source: str = ""
    taken_as_known: tuple[str, ...] = ()

    def __repr__(self) -> str:
        best = self.best.name if self.best else None
        return f"MeasurementPlan(wanted={self.wanted}, best={best!r})"

    @property
    def best(self) -> Combination | None:
        """The cheapest combination that reaches the wanted interval; None if none does."""
        first = next(iter(self.combinations), None)
        return first if first is not None and first.coarser >= 1 else None

    def out_of_reach(self) -> tuple[str, ...]:
        """Return the parameters that no combination determines as wanted."""
        return tuple(
            name
            for name in self.before.names
            if all(c.half_widths[name] > self.wanted for c in self.combinations)
        )

    def summary(self) -> tuple[str | TextTable, ...]:
        """Return the table and the sentences that `print` and a notebook show."""
        if not self.combinations:
            return (messages.NO_TEST_COMPARED(), *self.remarks)
        wanted = _share(self.wanted)
        missed = [
            messages.NOT_SETTLED_TO(name=name, wanted=wanted, otherwise=other_measurement(name))
            for name in self.out_of_reach()
        ]
        return (self._table(), self._recommendation(), *map(str.rstrip, missed), *self.remarks)

    def _table(self) -> TextTable:
        names = self.before.names
        rows = [
            (
                c.name,
                *(_percent(c.half_widths[name]) for name in names),
                _factor(c.coarser),
                duration(c.seconds),
            )
            for c in self.combinations[:_SHOWN]
        ]
        now = (_percent(self.before.half_width(name)) for name in names)
        return TextTable(
            ("tests", *short_names(names), "accuracy factor", "a run"),
            (("none", *now, "", ""), *rows),
            "± half of the 95 % interval that is left. Accuracy factor: how many times coarser "
            f"than assumed measurements may be for ± {_share(self.wanted)}; below 1, they must be "
            f"finer. {self.source}",
        )

    def _recommendation(self) -> str:
        every = f"every {'other ' if self.taken_as_known else ''}free parameter"
        wanted = f"{every} to ± {_share(self.wanted)}"
        if self.best is not None:
            tests = in_a_row([_with_accuracies(test) for test in self.best.tests])
            return messages.SETTLED_BY(tests=tests, wanted=wanted)
        first = max(self.combinations, key=lambda c: c.coarser)
        if first.coarser > 0:
            tests = in_a_row([_with_accuracies(test, first.coarser) for test in first.tests])
            return messages.SETTLED_IF_FINER(wanted=wanted, tests=tests)
        return messages.NOT_SETTLED(wanted=wanted)


def rank_combinations(
    candidates: Sequence[Candidate],
    before: Knowledge,
    wanted: float,
    remarks: Sequence[str],
    source: str,
    taken_as_known: Sequence[str] = (),
) -> MeasurementPlan:
    """Rank combinations of one to three tests by what they leave and what they cost.

    Parameters
    ----------
    candidates : sequence of Candidate
        Tests that could be measured.
    before, wanted, remarks, source, taken_as_known
        As for `MeasurementPlan`.
    """
    sizes = range(1, min(MOST_TESTS, len(candidates)) + 1)
    chosen = chain.from_iterable(combinations(candidates, size) for size in sizes)
    found = [_combination(tests, before, wanted) for tests in chosen]
    enough = [{t.name for t in c.tests} for c in found if c.coarser >= 1]
    found = [c for c in found if not any(tests < {t.name for t in c.tests} for tests in enough)]
    found.sort(key=lambda c: _order(c, wanted))
    return MeasurementPlan(
        wanted, before, tuple(found), tuple(remarks), source, tuple(taken_as_known)
    )


def _combination(tests: tuple[Candidate, ...], before: Knowledge, wanted: float) -> Combination:
    return Combination(tests, _half_widths(tests, before, 1.0), _coarsest(tests, before, wanted))


def _half_widths(tests: Sequence[Candidate], before: Knowledge, coarser: float) -> dict[str, float]:
    then = knowledge_after(before, tests, coarser)
    return {name: then.half_width(name) for name in before.names}


def _coarsest(tests: Sequence[Candidate], before: Knowledge, wanted: float) -> float:
    """Return the largest factor on the accuracies at which every interval is as wanted."""

    def is_reached(factor: float) -> bool:
        return max(_half_widths(tests, before, factor).values()) <= wanted

    if not is_reached(_FINEST):
        return 0.0
    low, high = _FINEST, _COARSEST
    if is_reached(high):
        return high
    for _ in range(_HALVINGS):
        middle = math.sqrt(low * high)
        low, high = (middle, high) if is_reached(middle) else (low, middle)
    return low


def _order(combination: Combination, wanted: float) -> tuple[float, ...]:
    if combination.coarser >= 1:
        return (0.0, len(combination.tests), combination.seconds)
    missing = sum(max(math.log(w / wanted), 0.0) for w in combination.half_widths.values() if w > 0)
    return (1.0, missing, combination.seconds)


def _share(share: float) -> str:
    return f"{number(100 * share, 2)} %"


def _percent(half_width: float) -> str:
    return f"± {_share(half_width)}" if half_width < 1 else "open"


def _factor(coarser: float) -> str:
    if not coarser:
        return "none"
    return f"> {_COARSEST:.0f}" if coarser >= _COARSEST else number(coarser, 2)


def _with_accuracies(test: Candidate, factor: float = 1.0) -> str:
    parts = []
    for response in test.responses:
        info = response_info(response.short_name)
        accuracy = response.accuracy.times(factor).in_words(info.unit if info else "")
        parts.append(f"{response.short_name} to {accuracy}")
    return f"{test.name} ({', '.join(parts)})"
