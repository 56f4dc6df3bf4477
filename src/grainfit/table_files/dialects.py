"""Split the text of a table into cells, whatever separates them."""

from __future__ import annotations

import csv
import io
import re
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass

from grainfit.formatting import from_spreadsheet_text

#: Separators in the order of preference. A blank stands for any number of blanks.
SEPARATORS = (",", ";", "\t", " ")
#: A first line that names the separator, as Excel reads and writes it.
_STATED = re.compile(r'\s*"?sep=(?P<separator>[,;\t|])"?[,;\t| ]*(?=[\r\n]|$)', re.IGNORECASE)
_LINE_END = re.compile(r"\r\n|\r|\n")
#: A word, a unit in brackets or behind a slash included, or a quoted text.
_WORD = re.compile(
    r'"(?P<quoted>[^"]*)"|(?P<plain>[^\s"\[(]+(?:\s*\[[^\[\]]*\]|\s*\([^()]*\)|\s+/\s+\S+)?|\S+)'
)
#: A number with any decimal mark, and with separators of thousands.
_NUMBER = re.compile(r"[+-]?[0-9.,]*[0-9][0-9.,]*(?:[eE][+-]?[0-9]+)?")


@dataclass(frozen=True)
class Row:
    """A row of a table: its line in the file, counted from 1, and its cells."""

    line: int
    cells: tuple[str, ...]

    @property
    def has_number(self) -> bool:
        """Whether some cell is a number."""
        return any(map(is_numeric, self.cells))


@dataclass(frozen=True)
class Dialect:
    """A table as text: its separator, the rows, and whether the first one is a header."""

    separator: str
    rows: tuple[Row, ...]


class NotCsvError(Exception):
    """A text is no table; has the line and the reason."""

    def __init__(self, line: int, reason: str) -> None:
        super().__init__(reason)
        self.line = line


def is_numeric(text: str) -> bool:
    """Return whether a cell is a number in some notation."""
    return _NUMBER.fullmatch(text) is not None


def split_table(text: str) -> Dialect:
    """Split a text into rows of cells, without blank lines and comments.

    The separator is the one that a first line names, as in ``sep=;``, or else the one that gives
    all rows the same number of cells. Lines that begin with
    ``#`` are comments; the last one above the numbers is the header if it has a name for each
    column, as in ``# u f``.

    Raises
    ------
    NotCsvError
        Quotes that are not closed.
    """
    stated = _STATED.match(text)
    if stated is not None:
        lines = "\n" * len(_LINE_END.findall(stated.group()))
        text, separator = lines + text[stated.end() :], stated["separator"]
    text, comment = _without_comments(text)
    if stated is not None:
        return Dialect(separator, _with_header(_split(text, separator), comment, separator))
    found: list[tuple[tuple[float, ...], Dialect]] = []
    error: NotCsvError | None = None
    for separator in SEPARATORS:
        if not _may_separate(separator, text) or (
            separator == " " and not _may_be_words(text, comment, found)
        ):
            continue
        try:
            dialect = Dialect(separator, _with_header(_split(text, separator), comment, separator))
        except NotCsvError as failure:
            error = error or failure
            continue
        if dialect.rows and len(dialect.rows[0].cells) > 1:
            found.append((_score(dialect.rows), dialect))
    if found:
        best = max(score for score, _ in found)
        return next(dialect for score, dialect in found if score == best)
    if error is not None:
        raise error
    # No separator at all: one column.
    return Dialect(",", _with_header(_split(text, ","), comment, ","))


def _may_separate(separator: str, text: str) -> bool:
    """Return whether a separator is in the first line; a quoted cell may go on in the next one."""
    line = _LINE_END.split(text.lstrip("\r\n"), maxsplit=1)[0]
    return separator in line or separator == " " or '"' in line


def _may_be_words(
    text: str, comment: Row | None, found: Sequence[tuple[tuple[float, ...], Dialect]]
) -> bool:
    """Return whether blanks may separate the cells: of headings, they are usually a part."""
    has_dialect = comment is None and any(score[1] > 0 for score, _ in found)
    return not has_dialect and text.count('"') % 2 == 0


def _without_comments(text: str) -> tuple[str, Row | None]:
    """Return a text with blank lines for comments at its top, and the last one of these."""
    ends = [match.end() for match in _LINE_END.finditer(text)]
    start, last = 0, None
    for number, end in enumerate([*ends, len(text)], start=1):
        line = text[start:end].strip()
        if line and not line.startswith("#"):
            break
        if line:
            last = Row(number, (line.lstrip("#").strip(),))
        start = end
    if last is None or not text[start:].strip():
        return text, None
    return "\n" * len(_LINE_END.findall(text[:start])) + text[start:], last


def _with_header(rows: Sequence[Row], comment: Row | None, separator: str) -> tuple[Row, ...]:
    """Return rows with the comment above them as the header, where it is one, and no others."""
    if comment is not None and rows and rows[0].has_number:
        names = next(iter(_split(comment.cells[0], separator)), comment).cells
        if len(names) == len(rows[0].cells):
            rows = [Row(comment.line, names), *rows]
    width = len(rows[0].cells) if rows else 0
    return tuple(
        row
        for number, row in enumerate(rows)
        if number == 0
        or not row.cells[0].startswith("#")
        or (len(row.cells) == width and row.has_number)
    )


def _split(text: str, separator: str) -> list[Row]:
    lines = _words(text) if separator == " " else _csv(text, separator)
    return [Row(line, cells) for line, cells in lines if any(cells)]


def _csv(text: str, separator: str) -> Iterator[tuple[int, tuple[str, ...]]]:
    reader = csv.reader(io.StringIO(text, newline=""), delimiter=separator, strict=True)
    try:
        for cells in reader:
            yield reader.line_num, tuple(from_spreadsheet_text(cell.strip()) for cell in cells)
    except csv.Error as error:
        raise NotCsvError(reader.line_num, str(error)) from error


def _words(text: str) -> Iterator[tuple[int, tuple[str, ...]]]:
    for number, line in enumerate(_LINE_END.split(text), start=1):
        yield (
            number,
            tuple(
                from_spreadsheet_text((word["quoted"] or word["plain"] or "").strip())
                for word in _WORD.finditer(line)
            ),
        )


def _score(rows: Sequence[Row]) -> tuple[float, ...]:
    """Return how well rows fit together: shares of rows of the same width, and of numbers."""
    width = len(rows[0].cells)
    alike = [row.cells for row in rows[1:] if len(row.cells) == width]
    share = len(alike) / (len(rows) - 1) if len(rows) > 1 else 0.5
    return len(rows[0].cells) > 1, share, _numeric_share(alike[:1000], width)


def _numeric_share(rows: Iterable[Sequence[str]], width: int) -> float:
    columns = list(zip(*rows, strict=True))
    return sum(all(not c or is_numeric(c) for c in column) for column in columns) / width
