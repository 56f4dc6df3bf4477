"""Compare calibrations: two materials, or two calibrations of one material, side by side."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from itertools import combinations, pairwise

from grainfit.errors import InputError
from grainfit.formatting import number, plain_ends, plain_interval, unit_for_people, with_unit
from grainfit.result import ParameterInterval
from grainfit.tables import TextTable
from grainfit.work_folder import messages
from grainfit.work_folder.saved_calibration import SavedCalibration

_ABSENT = "–"
#: Words of the last column.
AGREE, DIFFER = "agree", "differ"


def compare(saved: Sequence[SavedCalibration]) -> list[str | TextTable]:
    """Compare calibrations: verdicts, parameters with intervals, and responses.

    Parameters
    ----------
    saved : sequence of SavedCalibration
        Two or more calibrations.

    Returns
    -------
    list of str or TextTable
        A sentence for the verdict of each; a table of all parameters, free or fixed; and a table of
        all responses. Two values *agree* unless their 95 % intervals are apart, or, without
        intervals, unless they are different numbers.

    Raises
    ------
    InputError
        There are fewer than two, or one of them has no answer yet.
    """
    if len(saved) < 2:
        raise InputError(messages.ONE_CALIBRATION.fault(""))
    for one in saved:
        if one.result is None or not one.result.parameters:
            fault = messages.NO_ANSWER_TO_COMPARE.fault("", folder=str(one.folder), state=one.state)
            raise InputError(fault)
    names = _names(saved)
    return [
        *(f"{name}: {one.name}, {one.state}" for name, one in zip(names, saved, strict=True)),
        TextTable(
            ("parameter", *names, ""), tuple(_parameter_rows(saved)), "95 % intervals in brackets"
        ),
        TextTable(
            ("response", *names, ""),
            tuple(_response_rows(saved)),
            "expected at the answer, with its 95 % confidence; measured in brackets",
        ),
    ]


def _names(saved: Sequence[SavedCalibration]) -> list[str]:
    """Names of the folders, in full where two are called the same."""
    short = [one.folder.absolute().name for one in saved]
    return short if len(set(short)) == len(short) else [str(one.folder) for one in saved]


def _in_order(names: Iterable[Iterable[str]]) -> list[str]:
    return list(dict.fromkeys(name for some in names for name in some))


def _parameter_rows(saved: Sequence[SavedCalibration]) -> Iterable[tuple[str, ...]]:
    free = _in_order(one.result.parameters for one in saved if one.result)
    for name in [*free, *(n for n in _in_order(one.fixed for one in saved) if n not in free)]:
        found = [_Value.of_parameter(one, name) for one in saved]
        if name in free or not _same(found):
            yield (name, *(value.shown for value in found), _verdict(found))


def _response_rows(saved: Sequence[SavedCalibration]) -> Iterable[tuple[str, ...]]:
    for name in _in_order(one.result.responses for one in saved if one.result):
        found = [_Value.of_response(one, name) for one in saved]
        yield (name, *(value.shown for value in found), _verdict(found))


class _Value:
    """A value of one calibration, as it is shown, and the ends of its interval."""

    def __init__(self, shown: str = _ABSENT, ends: tuple[float, float] | None = None) -> None:
        self.shown = shown
        self.ends = ends

    @classmethod
    def of_parameter(cls, one: SavedCalibration, name: str) -> _Value:
        assert one.result is not None
        unit = unit_for_people(one.units.get(name, ""))
        if name in one.result.parameters:
            value = one.result.parameters[name]
            interval = one.intervals.get(name)
            shown = with_unit(number(value), unit)
            return cls(f"{shown} ({_between(interval)})" if interval else shown, _ends(interval))
        if name in one.fixed:
            value = one.fixed[name]
            return cls(f"{with_unit(number(value), unit)} (fixed)", (value, value))
        return cls()

    @classmethod
    def of_response(cls, one: SavedCalibration, name: str) -> _Value:
        assert one.result is not None
        found = one.result.responses.get(name)
        if found is None:
            return cls()
        value, half = found.expected
        unit = unit_for_people(found.unit)
        shown = with_unit(plain_interval(value, half), unit)
        measured = with_unit(plain_interval(found.target, found.tolerance), unit)
        return cls(f"{shown} ({measured})", (value - half, value + half))


def _ends(interval: ParameterInterval | None) -> tuple[float, float] | None:
    return None if interval is None else (interval.low, interval.high)


def _between(interval: ParameterInterval) -> str:
    return plain_ends(interval.low, interval.high)


def _same(found: Sequence[_Value]) -> bool:
    return all(first.shown == second.shown for first, second in pairwise(found))


def _verdict(found: Sequence[_Value]) -> str:
    """Say whether all pairs of intervals overlap; "" where one is missing."""
    ends = [value.ends for value in found if value.ends is not None]
    if len(ends) < len(found):
        return ""
    apart = any(a[1] < b[0] or b[1] < a[0] for a, b in combinations(ends, 2))
    return DIFFER if apart else AGREE
