"""Read a table from a file: its headings, and its rows with their lines."""

from __future__ import annotations

import codecs
import stat
from dataclasses import dataclass, replace
from pathlib import Path

from grainfit.errors import Fault, InputError
from grainfit.files import LARGEST_TABLE, line_of, read_within
from grainfit.table_files import messages
from grainfit.table_files.dialects import NotCsvError, Row, split_table
from grainfit.table_files.headings import Heading, heading, with_units

_SHOWN = {"\t": "tab", " ": "blanks"}
_UTF_16 = (codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)


@dataclass(frozen=True)
class Table:
    """A table of texts.

    Parameters
    ----------
    path : Path
        The file.
    separator : str
        Character between its cells; a blank for any number of blanks.
    line : int
        Line of the headings, counted from 1.
    headings : tuple of Heading
        The headings, by column.
    rows : tuple of Row
        The rows below the headings, of any length.
    """

    path: Path
    separator: str
    line: int
    headings: tuple[Heading, ...]
    rows: tuple[Row, ...]

    @property
    def separator_shown(self) -> str:
        """The separator for people."""
        return _SHOWN.get(self.separator, f'"{self.separator}"')

    def of_rows(self, rows: tuple[Row, ...]) -> Table:
        """Return the table with some of its rows."""
        return replace(self, rows=rows)

    def cells_of(self, position: int) -> list[str]:
        """Return the cells of a column, of the rows that have it."""
        return [row.cells[position] for row in self.rows if position < len(row.cells)]


def read_table(
    path: Path,
    *,
    largest: int = LARGEST_TABLE,
    content: str = "a header and one line per run",
    has_header: bool = True,
) -> Table:
    """Read a table whose cells are separated by commas, semicolons, tabs or blanks.

    Cells that were written as `spreadsheet_text` have their original text.

    Parameters
    ----------
    path : Path
        A regular file, in UTF-8, or in UTF-16 with a byte order mark.
    largest : int
        Bytes above which a file is refused, without reading all of it.
    content : str
        What an empty file should hold.
    has_header : bool
        Whether its first row has the headings.

    Raises
    ------
    InputError
        The file cannot be read, is too large, is no table, or is empty.
    """
    try:
        dialect = split_table(_text(path, largest))
    except NotCsvError as error:
        fault = messages.NOT_CSV.fault(f"line {error.line}", reason=error)
        raise InputError(fault, str(path)) from error
    rows = dialect.rows
    if not rows:
        raise InputError(messages.EMPTY.fault("", content=content), str(path))
    if not has_header:
        return Table(path, dialect.separator, rows[0].line, (), rows)
    headings = tuple(heading(position, text) for position, text in enumerate(rows[0].cells))
    rows, line = rows[1:], rows[0].line
    if rows and not rows[0].has_number and (found := with_units(headings, rows[0].cells)):
        headings, rows = found, rows[1:]
    return Table(path, dialect.separator, line, headings, rows)


def _text(path: Path, largest: int) -> str:
    try:
        # A named pipe would keep the program waiting.
        if not stat.S_ISREG(path.stat().st_mode) and not path.is_dir():
            raise InputError(messages.NO_REGULAR_FILE.fault(""), str(path))
        return _decoded(read_within(path, largest, waiting=True), path)
    except OSError as error:
        raise _unreadable(path, error.strerror or str(error)) from error
    except ValueError as error:
        if isinstance(error, InputError):
            raise
        raise _unreadable(path, str(error)) from error


def _unreadable(path: Path, reason: str) -> InputError:
    return InputError(messages.CANNOT_BE_READ.fault("", reason=reason), str(path))


def _decoded(data: bytes, path: Path) -> str:
    encoding = "UTF-16" if data.startswith(_UTF_16) else "UTF-8"
    try:
        text = data.decode("utf-16" if encoding == "UTF-16" else "utf-8-sig")
        line = text.count("\n", 0, text.find("\0")) + 1 if "\0" in text else None
    except UnicodeDecodeError as error:
        line = line_of(error)
    if line is None:
        return text
    fault: Fault = messages.OTHER_ENCODING.fault(f"line {line}", encoding=encoding)
    raise InputError(fault, str(path))
