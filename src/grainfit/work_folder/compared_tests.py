"""What the tests of several calibrations gave, in rows: numbers, curves, yield loci."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

from grainfit.evaluation import Response
from grainfit.result import ResponseResult, YieldLocus, YieldLocusResult
from grainfit.student import NORMAL_QUANTILE
from grainfit.work_folder.compared_rows import (
    ComparedCurve,
    ComparedCurves,
    ComparedResponse,
    ComparedValue,
)
from grainfit.work_folder.lined_up import (
    Place,
    lined_up,
    place_of,
    shown_names,
    told_by_name,
    types_of_tests,
)
from grainfit.work_folder.saved_calibration import SavedCalibration, read_answer


@dataclass(frozen=True)
class RowsOfTests:
    """What the tests gave, in rows."""

    responses: tuple[ComparedResponse, ...]
    curves: tuple[ComparedCurves, ...]
    yield_loci: tuple[ComparedResponse, ...]


def rows_of_tests(saved: Sequence[SavedCalibration]) -> RowsOfTests:
    """Return what the tests of calibrations gave, by type of the test and response.

    Raises
    ------
    InputError
        One of them has no answer yet.
    StoreError
        The result of one is damaged.
    """
    results = [read_answer(one) for one in saved]
    types = [types_of_tests(one) for one in saved]
    by_name = told_by_name(of.values() for of in types)
    responses, curves = [], []
    for of, result in zip(types, results, strict=True):
        responses.append({place_of(of, n): _response(r) for n, r in result.responses.items()})
        curves.append({place_of(of, n): ComparedCurve.of(c) for n, c in result.curves.items()})
    numbers, lines = [*lined_up(responses, by_name)], [*lined_up(curves, by_name)]
    names = shown_names([place for place, _ in (*numbers, *lines)])
    return RowsOfTests(
        _compared(numbers, names),
        tuple(ComparedCurves(names[p], values, p.title, p.response) for p, values in lines),
        _locus_rows(saved, types),
    )


def _locus_rows(
    saved: Sequence[SavedCalibration], types: Sequence[Mapping[str, str]]
) -> tuple[ComparedResponse, ...]:
    loci = [one.yield_loci for one in saved]
    kinds = [
        [of.get(locus.tests[0], "") for locus in own] for own, of in zip(loci, types, strict=True)
    ]
    rows = [*lined_up([*map(_parts_of_loci, loci, kinds)], told_by_name(kinds))]
    return _compared(rows, shown_names([place for place, _ in rows]))


def _compared(
    rows: Sequence[tuple[Place, tuple[ComparedValue | None, ...]]], names: Mapping[Place, str]
) -> tuple[ComparedResponse, ...]:
    return tuple(ComparedResponse(names[p], values, p.title, p.response) for p, values in rows)


def _parts_of_loci(
    loci: Sequence[YieldLocusResult], kinds: Sequence[str]
) -> dict[Place, ComparedValue]:
    return {
        Place(kind, ", ".join(locus.tests), name): _part_of_locus(unit, measured, expected)
        for locus, kind in zip(loci, kinds, strict=True)
        for name, unit, measured, expected in _lines_of_locus(locus)
    }


def _part_of_locus(unit: str, measured: Response, expected: Response | None) -> ComparedValue:
    found = ComparedValue(
        measured.value, unit=unit, measured=measured.value, tolerance=_half_interval(measured)
    )
    if expected is None:
        return found
    value, half = expected.value, _half_interval(expected)
    return replace(found, value=value, low=value - half, high=value + half)


def _response(found: ResponseResult) -> ComparedValue:
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


def _lines_of_locus(
    found: YieldLocusResult,
) -> Iterator[tuple[str, str, Response, Response | None]]:
    """Yield name and unit of what a yield locus tells, measured and expected."""
    expected = found.expected
    for name, unit in (("cohesion", "Pa"), ("internal_friction_angle", "deg")):
        yield name, unit, _part(found.measured, name), _part(expected, name) if expected else None


def _part(line: YieldLocus, name: str) -> Response:
    found: Response = getattr(line, name)
    return found


def _half_interval(found: Response) -> float:
    """Return half of the 95 % interval of a response."""
    return NORMAL_QUANTILE * found.standard_error
