"""Columns that tell the spread of a measured mean: standard deviation, number, standard error."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

from grainfit.options.kinds import Quantity
from grainfit.student import student_factor
from grainfit.table_files import messages
from grainfit.table_files.dialects import Row
from grainfit.table_files.headings import WITHOUT_UNIT, Heading
from grainfit.table_files.reading import Reading, Wanted

_DEVIATION = re.compile(
    r"\b(?:standard[ _]?deviation|st\.?[ _]?dev(?:iation)?|stdev|stddev|std|s\.?d\.?)(?:\b|$)",
    re.IGNORECASE,
)
_ERROR = re.compile(
    r"standard[ _]?(?:error|uncertainty)|\bstd?\.?[ _]?err(?:or)?\b|\bs\.?e\.?m?\.?(?:\b|$)",
    re.IGNORECASE,
)
_COUNT = re.compile(r"n|(?i:count|repeats|repetitions|replicates|number of \w+)")


@dataclass(frozen=True)
class Spread:
    """Columns from which the standard errors of the values follow.

    Parameters
    ----------
    wanted : mapping of int to Wanted
        The columns by their positions.
    error, deviation, count : int, optional
        Position of the standard error; or else of the standard deviation, and of the number of
        measurements.
    """

    wanted: Mapping[int, Wanted]
    error: int | None = None
    deviation: int | None = None
    count: int | None = None

    def standard_errors(
        self, read: Sequence[Mapping[int, float | None]], reading: Reading, rows: Sequence[Row]
    ) -> list[float]:
        """Return the standard error of each row; note the numbers that give none.

        One from a deviation has Student's factor for few measurements.
        """
        if self.error is not None:
            return [row[self.error] or 0.0 for row in read]
        assert self.deviation is not None
        assert self.count is not None
        label = reading.table.headings[self.count].label
        errors = []
        for numbers, row in zip(read, rows, strict=True):
            deviation, count = numbers[self.deviation], numbers[self.count]
            if count is not None and (count < 2 or count != int(count)):
                where = f"line {row.line}, column {label}"
                reading.faults.note(messages.NO_COUNT.fault(where, count=count))
            elif deviation is not None and count is not None:
                errors.append(student_factor(int(count)) * deviation / math.sqrt(count))
        return errors


def kind_of_spread(heading: Heading) -> str:
    """Return which number on a mean a column has, by its heading; "" for none."""
    if _ERROR.search(heading.name):
        return "a standard error"
    if _DEVIATION.search(heading.name):
        return "a standard deviation"
    return "a number of measurements" if _COUNT.fullmatch(heading.name) else ""


def columns_of_spread(
    headings: Sequence[Heading], points: tuple[int, int], values: Wanted
) -> Spread | None:
    """Return the columns with the spread of the values; None where they do not tell it.

    That is one column with the standard error; or one with the standard deviation and one with the
    number of measurements.
    """
    kinds: dict[str, list[int]] = {}
    for heading in headings:
        if heading.position not in points:
            kinds.setdefault(kind_of_spread(heading), []).append(heading.position)
    least = Quantity(values.quantity.unit, lowest=0.0)
    size = replace(values, quantity=least, needs_unit=False)
    number = Wanted(Quantity(""))
    errors, deviations, counts = (
        kinds.get(kind, [])
        for kind in ("a standard error", "a standard deviation", "a number of measurements")
    )
    value = headings[points[1]]
    if len(errors) == 1:
        of_error = _in_unit_of(value, headings[errors[0]], size)
        return Spread({errors[0]: of_error}, error=errors[0])
    if len(deviations) == len(counts) == 1:
        of_deviation = _in_unit_of(value, headings[deviations[0]], size)
        wanted = {deviations[0]: of_deviation, counts[0]: number}
        return Spread(wanted, deviation=deviations[0], count=counts[0])
    return None


def _in_unit_of(values: Heading, spread: Heading, wanted: Wanted) -> Wanted:
    """Return a column of the spread, in the unit of the values unless it states one."""
    if spread.states_unit and wanted.unit:
        return replace(wanted, given=None)
    if wanted.given is not None:
        return wanted
    stated = values.unit if values.states_unit else None
    return replace(wanted, given="" if stated in (*WITHOUT_UNIT, wanted.unit) else stated or "")
