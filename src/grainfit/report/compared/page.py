"""Page of calibrations side by side: intervals over each other on one scale."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from math import log
from pathlib import Path
from typing import NamedTuple

from grainfit.files import write_atomically
from grainfit.formatting import plain
from grainfit.plots.labels import Label, label_of_parameter, response_label
from grainfit.report.package_page import package_page
from grainfit.verdict.messages import state_name
from grainfit.work_folder.compared_rows import ComparedResponse, ComparedRow, ComparedValue
from grainfit.work_folder.comparison import Comparison
from grainfit.work_folder.saved_calibration import SavedCalibration

#: Ends of intervals whose ratio is larger are drawn on a logarithmic scale.
_LOGARITHMIC = 20.0
#: Narrowest bar, percent of the scale.
_NARROWEST = 0.5


@dataclass(frozen=True)
class Bar:
    """A value as it is drawn: percentages of the scale of its row."""

    name: str
    shown: str
    verdict: str
    at: float
    left: float
    width: float
    target: tuple[float, float] | None


class _Table(NamedTuple):
    """Rows with bars: label, verdict, and a bar for each calibration."""

    title: str
    heading: str
    told: str
    rows: Sequence[tuple[Label, str, Sequence[Bar | None]]]


_EXPECTED = (
    "Bars are the expected {} with their 95 % intervals, the band behind a bar is the measured "
    "value with its {}."
)
#: Title of each table, heading of its rows, and what its bars are.
_WORDS = (
    (
        "Parameters",
        "Parameter",
        "Bars are 95 % intervals, marks the values; values differ if intervals of theirs are "
        "apart.",
    ),
    ("Responses", "Response", _EXPECTED.format("responses", "tolerance")),
    ("Yield loci", "Yield locus", _EXPECTED.format("values", "95 % interval")),
)


def write_compared_page(found: Comparison, saved: Sequence[SavedCalibration], path: Path) -> None:
    """Write the page of a comparison: one file that works offline.

    Parameters
    ----------
    found : Comparison
        The comparison.
    saved : sequence of SavedCalibration
        The calibrations that are compared.
    path : Path
        The file to write.
    """
    labelled: tuple[list[tuple[Label, ComparedRow]], ...] = (
        [(_label(saved, row.name), row) for row in found.parameters],
        [(_label_of_response(row), row) for row in found.responses],
        [(_label_of_response(row), row) for row in found.yield_loci],
    )
    tables = [
        _Table(*words, [(label, row.verdict, _bars(found.names, row)) for label, row in rows])
        for words, rows in zip(_WORDS, labelled, strict=True)
        if rows
    ]
    states = [plain(state_name(state)) for state in found.states]
    page = package_page("grainfit.report.compared", found=found, states=states, tables=tables)
    write_atomically(path, page)


def _label(saved: Sequence[SavedCalibration], name: str) -> Label:
    labels = [label_of_parameter(one, name) for one in saved]
    return max(labels, key=lambda label: len(label.unit))


def _label_of_response(row: ComparedResponse) -> Label:
    return response_label(row.name, next(one.unit for one in row.values if one is not None))


def _bars(names: Sequence[str], row: ComparedRow) -> list[Bar | None]:
    ends = [end for one in row.values if one is not None for end in _ends(one)]
    if not ends:
        return [None for _ in names]
    low, high = min(ends), max(ends)
    is_logarithmic = low > 0 and high / low > _LOGARITHMIC

    def place(value: float) -> float:
        if low == high:
            return 50.0
        share = (
            log(value / low) / log(high / low) if is_logarithmic else (value - low) / (high - low)
        )
        return round(4.0 + 92.0 * share, 2)

    return [
        None if one is None else _bar(name, one, place)
        for name, one in zip(names, row.values, strict=True)
    ]


def _ends(one: ComparedValue) -> Iterator[float]:
    """Yield what the scale of a row has room for."""
    yield one.value
    yield from (end for end in (one.low, one.high) if end is not None)
    if one.measured is not None and one.tolerance is not None:
        yield from (one.measured - one.tolerance, one.measured + one.tolerance)


def _bar(name: str, one: ComparedValue, place: Callable[[float], float]) -> Bar:
    left = place(one.value if one.low is None else one.low)
    right = place(one.value if one.high is None else one.high)
    target = None
    if one.measured is not None and one.tolerance is not None:
        start, end = (place(one.measured + sign * one.tolerance) for sign in (-1, 1))
        target = (start, round(end - start, 2))
    return Bar(
        name,
        one.shown,
        one.verdict,
        place(one.value),
        left,
        round(max(right - left, _NARROWEST), 2),
        target,
    )
