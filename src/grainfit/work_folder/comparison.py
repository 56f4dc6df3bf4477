"""Compare calibrations: two materials, or two calibrations of one material, side by side."""

from __future__ import annotations

import difflib
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any

from grainfit.errors import InputError
from grainfit.formatting import duration
from grainfit.tables import TextTable
from grainfit.verdict.messages import state_name
from grainfit.work_folder import messages
from grainfit.work_folder.compared_rows import (
    ABSENT,
    ComparedCurves,
    ComparedResponse,
    ComparedRow,
    ComparedValue,
)
from grainfit.work_folder.compared_tests import rows_of_tests
from grainfit.work_folder.saved_calibration import SavedCalibration, bulk_tests_of, read_answer


@dataclass(frozen=True)
class Comparison:
    """Calibrations side by side.

    Parameters
    ----------
    names : tuple of str
        Names of their folders.
    titles, states : tuple of str
        Their names and their states, as in result.json.
    parameters : tuple of ComparedRow
        All free parameters, and the fixed ones that are not the same or that one alone has.
    responses, yield_loci : tuple of ComparedResponse
        All responses that are numbers, and what the yield loci tell.
    curves : tuple of ComparedCurves
        All curves.
    circumstances : mapping of str to tuple of str
        Cost, solver, particle diameters, version, strategy and seed of each.
    file_differences : tuple of str
        What differs from the calibration file of the first to those of the others.
    """

    names: tuple[str, ...]
    titles: tuple[str, ...]
    states: tuple[str, ...]
    parameters: tuple[ComparedRow, ...]
    responses: tuple[ComparedResponse, ...]
    curves: tuple[ComparedCurves, ...]
    yield_loci: tuple[ComparedResponse, ...]
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
            *self._tables_of_tests(),
            TextTable(
                ("", *self.names), tuple((what, *of) for what, of in self.circumstances.items())
            ),
            *self.file_differences,
        ]

    def _tables_of_tests(self) -> Iterator[TextTable]:
        expected = "expected at the answer, with its 95 % confidence; measured in brackets"
        if self.responses or not self.curves:
            rows = tuple(row.shown for row in self.responses)
            yield TextTable(("response", *self.names, ""), rows, expected)
        if self.curves:
            off = (
                "root mean square deviation of the expected curve, in standard uncertainties σ of "
                "the measured points"
            )
            curves = tuple(row.shown for row in self.curves)
            yield TextTable(("curve", *self.names), curves, off)
        if self.yield_loci:
            loci = tuple(row.shown for row in self.yield_loci)
            yield TextTable(("yield locus", *self.names, ""), loci, expected)

    def document(self) -> dict[str, Any]:
        """Return all of it as plain data, with the verdict of each row."""
        found = asdict(self)
        for key in ("parameters", "responses", "yield_loci"):
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
    of_tests = rows_of_tests(saved)
    return Comparison(
        _names(saved),
        tuple(one.name for one in saved),
        tuple(one.state for one in saved),
        tuple(_parameter_rows(saved)),
        of_tests.responses,
        of_tests.curves,
        of_tests.yield_loci,
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


def _circumstances(saved: Sequence[SavedCalibration]) -> dict[str, tuple[str, ...]]:
    seconds = [sum(record.seconds for record in one.records.values()) for one in saved]
    return {
        "runs": tuple(str(len(one.records)) for one in saved),
        "time of simulation": tuple(map(duration, seconds)),
        "solver": tuple(_solvers(one) for one in saved),
        "particle diameters": tuple(_diameters(one) for one in saved),
        "version of grainfit": tuple(one.version or ABSENT for one in saved),
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
    return ABSENT if sizes is None else sizes.words


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
