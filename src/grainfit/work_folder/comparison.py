"""Compare calibrations: two materials, or two calibrations of one material, side by side."""

from __future__ import annotations

import difflib
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass
from itertools import combinations
from typing import Any, Literal

from grainfit.errors import InputError
from grainfit.formatting import (
    duration,
    ends,
    interval,
    number,
    unit_for_people,
    with_unit,
)
from grainfit.tables import TextTable
from grainfit.verdict.messages import state_name
from grainfit.work_folder import messages
from grainfit.work_folder.saved_calibration import SavedCalibration, bulk_tests_of, read_answer

_ABSENT = "–"
#: Words of the last column.
AGREE, DIFFER = "agree", "differ"


@dataclass(frozen=True)
class ComparedValue:
    """A value of one calibration: of a parameter, SI, or of a response, in its unit.

    Parameters
    ----------
    value : float
        The value at the answer; of a response, the expected one.
    low, high : float, optional
        Its 95 % interval, where it has one.
    unit : str
        As in the calibration file.
    is_fixed : bool
        Whether it is a parameter that was not free.
    measured, tolerance : float, optional
        Target of a response.
    verdict : str
        Of a response; of a parameter, how well it is determined.
    """

    value: float
    low: float | None = None
    high: float | None = None
    unit: str = ""
    is_fixed: bool = False
    measured: float | None = None
    tolerance: float | None = None
    verdict: str = ""

    @property
    def shown(self) -> str:
        """The value with its interval or its target in brackets, for people."""
        unit = unit_for_people(self.unit)
        if self.is_fixed:
            return f"{with_unit(number(self.value), unit)} (fixed)"
        if self.measured is not None and self.tolerance is not None and self.high is not None:
            expected = with_unit(interval(self.value, self.high - self.value), unit)
            return f"{expected} ({with_unit(interval(self.measured, self.tolerance), unit)})"
        shown = with_unit(number(self.value), unit)
        if self.low is None or self.high is None:
            return shown
        return f"{shown} ({ends(self.low, self.high)})"


@dataclass(frozen=True)
class ComparedRow:
    """A parameter or a response in all calibrations; None where one does not have it."""

    name: str
    values: tuple[ComparedValue | None, ...]

    @property
    def verdict(self) -> Literal["agree", "differ", ""]:
        """Whether all pairs of intervals overlap; "" where fewer than two have one."""
        found = [(one.low, one.high) for one in self.values if one is not None]
        known = [(low, high) for low, high in found if low is not None and high is not None]
        if len(known) < 2:
            return ""
        apart = any(a[1] < b[0] or b[1] < a[0] for a, b in combinations(known, 2))
        return "differ" if apart else "agree"

    @property
    def shown(self) -> tuple[str, ...]:
        """The row of a table."""
        texts = (_ABSENT if one is None else one.shown for one in self.values)
        return (self.name, *texts, self.verdict)


@dataclass(frozen=True)
class Comparison:
    """Calibrations side by side.

    Parameters
    ----------
    names : tuple of str
        Names of their folders.
    titles, states : tuple of str
        Their names and their states, as in result.json.
    parameters, responses : tuple of ComparedRow
        All free parameters, the fixed ones that are not the same or that one alone has, and all
        responses.
    circumstances : mapping of str to tuple of str
        Cost, solver, particle diameters, version, strategy and seed of each.
    file_differences : tuple of str
        What differs from the calibration file of the first to those of the others.
    """

    names: tuple[str, ...]
    titles: tuple[str, ...]
    states: tuple[str, ...]
    parameters: tuple[ComparedRow, ...]
    responses: tuple[ComparedRow, ...]
    circumstances: Mapping[str, tuple[str, ...]]
    file_differences: tuple[str, ...]

    def parts(self) -> list[str | TextTable]:
        """Return sentences and tables, and the lines of the files that differ."""
        told = zip(self.names, self.titles, self.states, strict=True)
        return [
            *(f"{name}: {title}, {state_name(state)}" for name, title, state in told),
            TextTable(
                ("parameter", *self.names, ""),
                tuple(row.shown for row in self.parameters),
                "95 % intervals in brackets",
            ),
            TextTable(
                ("response", *self.names, ""),
                tuple(row.shown for row in self.responses),
                "expected at the answer, with its 95 % confidence; measured in brackets",
            ),
            TextTable(
                ("", *self.names), tuple((what, *of) for what, of in self.circumstances.items())
            ),
            *self.file_differences,
        ]

    def document(self) -> dict[str, Any]:
        """Return all of it as plain data, with the verdict of each row."""
        found = asdict(self)
        for key in ("parameters", "responses"):
            rows: tuple[ComparedRow, ...] = getattr(self, key)
            for plain_row, row in zip(found[key], rows, strict=True):
                plain_row["verdict"] = row.verdict or None
        return found


def compare(saved: Sequence[SavedCalibration]) -> Comparison:
    """Compare calibrations: verdicts, parameters with intervals, responses, cost, file.

    Values *agree* unless their 95 % intervals are apart, or, where both are fixed, unless they
    are different numbers.

    Parameters
    ----------
    saved : sequence of SavedCalibration
        Two or more calibrations.

    Raises
    ------
    InputError
        There are fewer than two, or one of them has no answer yet.
    StoreError
        The result of one is damaged.
    """
    if len(saved) < 2:
        raise InputError(messages.ONE_CALIBRATION.fault(""))
    for one in saved:
        read_answer(one)
    return Comparison(
        _names(saved),
        tuple(one.name for one in saved),
        tuple(one.state for one in saved),
        tuple(_parameter_rows(saved)),
        tuple(
            ComparedRow(name, tuple(_response(one, name) for one in saved))
            for name in _in_order(one.result.responses for one in saved if one.result)
        ),
        _circumstances(saved),
        tuple(_file_differences(saved)),
    )


def _names(saved: Sequence[SavedCalibration]) -> tuple[str, ...]:
    """Names of the folders, in full where two are called the same."""
    short = tuple(one.folder.absolute().name for one in saved)
    return short if len(set(short)) == len(short) else tuple(str(one.folder) for one in saved)


def _in_order(names: Iterable[Iterable[str]]) -> list[str]:
    return list(dict.fromkeys(name for some in names for name in some))


def _parameter_rows(saved: Sequence[SavedCalibration]) -> Iterator[ComparedRow]:
    free = _in_order(one.result.parameters for one in saved if one.result)
    for name in _in_order([free, *(one.fixed for one in saved)]):
        values = tuple(_parameter(one, name) for one in saved)
        known = [one.shown for one in values if one is not None]
        if name in free or len(known) == 1 or len(set(known)) > 1:
            yield ComparedRow(name, values)


def _parameter(one: SavedCalibration, name: str) -> ComparedValue | None:
    assert one.result is not None
    unit = one.units.get(name, "")
    if name in one.result.parameters:
        value, found = one.result.parameters[name], one.intervals.get(name)
        if found is None:
            return ComparedValue(value, unit=unit)
        return ComparedValue(value, found.low, found.high, unit, verdict=found.determination)
    if name in one.fixed:
        value = one.fixed[name]
        return ComparedValue(value, value, value, unit, is_fixed=True)
    return None


def _response(one: SavedCalibration, name: str) -> ComparedValue | None:
    found = one.result.responses.get(name) if one.result else None
    if found is None:
        return None
    value, half = found.expected
    return ComparedValue(
        value,
        value - half,
        value + half,
        found.unit,
        measured=found.target,
        tolerance=found.tolerance,
        verdict=found.verdict,
    )


def _circumstances(saved: Sequence[SavedCalibration]) -> dict[str, tuple[str, ...]]:
    seconds = [sum(record.seconds for record in one.records.values()) for one in saved]
    return {
        "runs": tuple(str(len(one.records)) for one in saved),
        "time of simulation": tuple(map(duration, seconds)),
        "solver": tuple(_solvers(one) for one in saved),
        "particle diameters": tuple(_diameters(one) for one in saved),
        "version of grainfit": tuple(one.version or _ABSENT for one in saved),
        "strategy": tuple(one.strategy for one in saved),
        "seed": tuple(str(one.seed) for one in saved),
    }


def _solvers(one: SavedCalibration) -> str:
    models = (record.definition.model for record in one.records.values())
    found = (f"{m.get('solver', '')} {m.get('version', '')}".strip() for m in models)
    return ", ".join(dict.fromkeys(filter(None, found))) or "own model"


def _diameters(one: SavedCalibration) -> str:
    of_tests = (test.sizes for test in bulk_tests_of(one).values())
    sizes = next(of_tests, one.sizes)
    return _ABSENT if sizes is None else sizes.words


def _file_differences(saved: Sequence[SavedCalibration]) -> Iterator[str]:
    """Yield the lines of the calibration files that differ, with - and +."""
    first, *others = saved
    for other in others:
        yield from difflib.unified_diff(
            first.source_text.splitlines(),
            other.source_text.splitlines(),
            f"{first.folder.absolute().name}/{first.source}",
            f"{other.folder.absolute().name}/{other.source}",
            n=1,
            lineterm="",
        )
