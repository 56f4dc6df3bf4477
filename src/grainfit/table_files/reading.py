"""Take numbers from the columns of a table: noting all faults, with line and column."""

from __future__ import annotations

import difflib
import math
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

from grainfit.errors import Fault, InputError
from grainfit.options.kinds import Quantity
from grainfit.options.places import Findings, Place, show
from grainfit.table_files import messages
from grainfit.table_files.dialects import Row, is_numeric
from grainfit.table_files.headings import WITHOUT_UNIT, Heading, named
from grainfit.table_files.numbers import decimal_mark, parse_number
from grainfit.table_files.table import Table
from grainfit.units import UnitError, is_unit, to_unit

MOST_FAULTS = 20
_MOST_NAMED = 10
#: Resemblance from which on the name of an ignored column is taken for a slip.
_ALIKE = 0.9


@dataclass(frozen=True)
class Wanted:
    """Numbers that a reader wants from a column.

    Parameters
    ----------
    quantity : Quantity
        Unit to convert to, and limits; its unit is None where nothing says which one is wanted.
    key : str
        Name of the column in remedies.
    given : str or None
        Unit of its numbers where the user has named it; empty for the wanted one. None where the
        heading may state it.
    unit_key : str
        Key of the calibration file that names the unit, if there is one.
    needs_unit : bool
        Whether a heading without a unit is a fault, unless the unit is given.
    own_unit : str
        Name of the wanted unit where it is no unit that can be converted.
    may_be_empty : bool
        Whether a cell may be empty.
    is_checked : bool
        Whether the quantity has limits; without it, any finite number will do.
    """

    quantity: Quantity
    key: str = ""
    given: str | None = None
    unit_key: str = ""
    needs_unit: bool = False
    own_unit: str = ""
    may_be_empty: bool = False
    is_checked: bool = True

    @property
    def unit(self) -> str:
        """Unit to convert to; empty where there is none, or where it is not known."""
        return self.quantity.unit or ""

    def convert(self, number: float, written: str) -> float:
        """Return a number of the column in the wanted unit."""
        return to_unit(f"{number!r} {written}", self.unit) if written else number

    def scale(self, written: str) -> float:
        """Return the factor of conversion of a difference."""
        return self.convert(1.0, written) - self.convert(0.0, written)


class TableFaults:
    """Faults of one table; of many, the first ones are kept."""

    def __init__(self, most: int = MOST_FAULTS) -> None:
        self.found: list[Fault] = []
        self._most = most

    def note(self, fault: Fault) -> None:
        """Note a fault."""
        self.found.append(fault)

    @property
    def first(self) -> list[Fault]:
        """The first faults, and the number of the others."""
        more = len(self.found) - self._most
        rest = [messages.MORE_FAULTS.fault("", count=more)] if more > 0 else []
        return self.found[: self._most] + rest

    def require_none(self, source: str) -> None:
        """Raise `InputError` if there are any."""
        if self.found:
            raise InputError(self.first, source)


class Reading:
    """Numbers of a table by column.

    Parameters
    ----------
    table : Table
        The table.
    wanted : mapping of int to Wanted
        Columns by their positions.
    faults : TableFaults
        Where faults are noted.
    texts : collection of int
        Positions of columns that are read as texts.
    """

    def __init__(
        self,
        table: Table,
        wanted: Mapping[int, Wanted],
        faults: TableFaults,
        texts: Sequence[int] = (),
    ) -> None:
        self.table = table
        self.faults = faults
        self._wanted = wanted
        self._texts = tuple(texts)
        self._note_repeated()
        self.units = {at: self._unit(table.headings[at], one) for at, one in wanted.items()}
        self.mark = decimal_mark(cell for at in wanted for cell in table.cells_of(at))
        self._remarks = self._columns_of_remarks()

    # --- headings ----------------------------------------------------------------------------

    def _note_repeated(self) -> None:
        count = Counter(one.text for one in self.table.headings)
        for name in dict.fromkeys(self.table.headings[at].text for at in self._wanted):
            if name and count[name] > 1:
                label = next(one.label for one in self.table.headings if one.text == name)
                self.faults.note(messages.REPEATED.fault(self.of_heading(label)))

    def of_heading(self, label: str) -> str:
        """Return the place of a heading."""
        return f"line {self.table.line}, column {label}"

    def _unit(self, heading: Heading, wanted: Wanted) -> str:
        """Return the unit to convert from; "" where there is nothing to convert."""
        where, stated = self.of_heading(heading.label), heading.unit
        if wanted.given is not None:
            is_known = wanted.quantity.unit is not None
            if stated and heading.states_unit and is_known:
                self._note_other_unit(where, stated, wanted)
            return wanted.given
        if stated is None or stated == wanted.own_unit or not heading.states_unit:
            if wanted.needs_unit:
                fault = messages.NO_UNIT.fault(where, name=wanted.key, unit=wanted.unit)
                self.faults.note(fault)
            return ""
        return self._stated_unit(where, stated, wanted)

    def _note_other_unit(self, where: str, stated: str, wanted: Wanted) -> None:
        if stated in WITHOUT_UNIT:
            return
        taken = wanted.given or wanted.unit
        try:
            one = wanted.convert(1.0, wanted.given or "")
            if math.isclose(to_unit(f"1 {stated}", wanted.unit), one):
                return
        except UnitError:
            pass
        written = (
            f'Write {wanted.unit_key} = "{stated}", or correct' if wanted.unit_key else "Correct"
        )
        self.faults.note(
            messages.STATES_OTHER_UNIT.fault(
                where,
                stated=show(stated),
                taken=f"in {taken}" if taken else "as they are, without a unit",
                correct=written,
            )
        )

    def _stated_unit(self, where: str, stated: str, wanted: Wanted) -> str:
        if stated in WITHOUT_UNIT:
            if wanted.unit:
                fault = messages.SAID_TO_BE_WITHOUT_UNIT.fault(where, unit=wanted.unit)
                self.faults.note(fault)
            return ""
        if wanted.quantity.unit is None:
            self.faults.note(messages.UNIT_OF_MODEL_UNKNOWN.fault(where, stated=stated))
            return ""
        try:
            to_unit(f"1 {stated}", wanted.unit)
        except UnitError as error:
            fault = (
                messages.WRONG_UNIT.fault(
                    where, stated=show(stated), name=wanted.key, unit=wanted.unit
                )
                if wanted.needs_unit
                else Fault(where, error.message, error.remedy)
            )
            self.faults.note(fault)
            return ""
        return "" if stated == wanted.unit else stated

    @property
    def ignored(self) -> list[Heading]:
        """Headings of the columns with some content that are not read."""
        read = {*self._wanted, *self._texts}
        others = [one for one in self.table.headings if one.position not in read]
        return [one for one in others if any(self.table.cells_of(one.position))]

    def note_slips(self, absent: Iterable[str]) -> None:
        """Note ignored columns whose names resemble optional ones that are not there."""
        names = {one.name for one in self.table.headings}
        missing = [name for name in absent if name not in names]
        for one in self.ignored:
            close = difflib.get_close_matches(one.name[:100], missing, n=1, cutoff=_ALIKE)
            # The standard error of another response is no slip.
            of = one.name.rpartition(".")[0]
            if close and (of not in names or close[0].startswith(f"{of}.")):
                where = self.of_heading(one.label)
                self.faults.note(messages.RESEMBLES.fault(where, meant=close[0]))

    # --- rows --------------------------------------------------------------------------------

    def _columns_of_remarks(self) -> set[int]:
        """Return columns without a number in any row: a row may end before them."""
        others = range(len(self.table.headings))
        unread = [at for at in others if at not in self._wanted and at not in self._texts]
        return {at for at in unread if not any(map(is_numeric, self.table.cells_of(at)))}

    def rows(self) -> list[Row]:
        """Return the rows that have a cell for each heading; note the others."""
        return [row for row in self.table.rows if self._fits(row)]

    def _fits(self, row: Row) -> bool:
        count, width = len(row.cells), len(self.table.headings)
        if count == width or (self._remarks.issuperset(range(count, width)) and count < width):
            return True
        if count > width:
            where = f"line {row.line}, column {width + 1}"
            self.faults.note(messages.TOO_LONG.fault(where, count=count, width=width))
        else:
            where = f"line {row.line}, column {self.table.headings[count].label}"
            self.faults.note(messages.TOO_SHORT.fault(where, count=count, width=width))
        return False

    def number(self, row: Row, position: int) -> float | None:
        """Return the number in a cell, converted; None after noting its fault, or if empty."""
        wanted = self._wanted[position]
        text = row.cells[position]
        if not wanted.is_checked and not self.units[position] and self.mark != ",":
            number = _plain_number(text)
            if number is not None:
                return number
        where = f"line {row.line}, column {self.table.headings[position].label}"
        if not text:
            if not wanted.may_be_empty:
                self.faults.note(messages.NO_VALUE.fault(where))
            return None
        found = parse_number(text, self.mark, where)
        if isinstance(found, Fault):
            is_below_headings = row is self.table.rows[0] and not row.has_number
            if is_below_headings and is_unit(text):
                name = self.table.headings[position].name
                found = messages.UNIT_BELOW_HEADING.fault(where, name=name, unit=text)
            self.faults.note(found)
            return None
        return self._checked(found, where, wanted, self.units[position])

    def _checked(self, number: float, where: str, wanted: Wanted, unit: str) -> float | None:
        if not math.isfinite(number):
            self.faults.note(messages.NOT_FINITE.fault(where, number=number))
            return None
        try:
            value = wanted.convert(number, unit)
        except UnitError as error:
            self.faults.note(Fault(where, error.message, error.remedy))
            return None
        if not wanted.is_checked:
            return value
        findings = Findings()
        wanted.quantity.read_converted(value, Place(findings))
        for fault in findings.faults:
            self.faults.note(Fault(where, fault.message, fault.remedy))
        return None if findings.faults else value

    # --- the table for people ----------------------------------------------------------------

    def describe(self) -> str:
        """Return how the table was understood, in one line.

        Such as ``sieve.csv: separator ";", decimal ",", columns: size [mm], passing [%] (ignored:
        remark), 12 rows``.
        """
        table = self.table
        decimal = f', decimal "{self.mark}"' if self.mark else ""
        names = [self._shown(at) for at in self._wanted]
        names += [table.headings[at].label for at in self._texts]
        others = [one.label for one in self.ignored]
        ignored = f" (ignored: {_some(others)})" if others else ""
        count = len(table.rows)
        return (
            f"{show(table.path.name)[1:-1]}: separator {table.separator_shown}{decimal}, columns: "
            f"{_some(names)}{ignored}, {count} {'row' if count == 1 else 'rows'}"
        )

    def _shown(self, position: int) -> str:
        wanted, heading = self._wanted[position], self.table.headings[position]
        unit = self.units[position] or wanted.unit or wanted.own_unit
        return f"{heading.label} [{unit}]" if unit else heading.label


def _plain_number(text: str) -> float | None:
    """Return a finite number without a comma; None for all else. Large tables are full of them."""
    try:
        number = float(text)
    except ValueError:
        return None
    return number if math.isfinite(number) and "_" not in text else None


def _some(names: Sequence[str]) -> str:
    more = len(names) - _MOST_NAMED
    return ", ".join([*names[:_MOST_NAMED], *([f"{more} more"] if more > 0 else [])])


def column_of(table: Table, name: str) -> int | None:
    """Return the position of the column with a name; None if there is none."""
    return next((one.position for one in named(table.headings, name)), None)


def find_column(table: Table, name: str, faults: TableFaults) -> int | None:
    """Return the position of the column with a name; None after noting that there is none."""
    if (position := column_of(table, name)) is not None:
        return position
    names = [one.label for one in table.headings if one.name]
    there = _some(names)
    close = difflib.get_close_matches(name[:64], names, n=1)
    remedy = f'Is it "{close[0]}"? Name it "{name}".' if close else f"There are: {there}."
    faults.note(messages.MISSING.fault(f"line {table.line}, column {name}", remedy=remedy))
    return None


def require_headings(table: Table) -> None:
    """Raise `InputError` for a table of one column, or of numbers alone."""
    names = [one.text for one in table.headings]
    where = f"line {table.line}"
    if all(map(is_numeric, names)):
        raise InputError(messages.NO_HEADINGS.fault(where), str(table.path))
    if len(names) == 1:
        fault = messages.ONE_COLUMN.fault(where, name=show(names[0]))
        raise InputError(fault, str(table.path))
