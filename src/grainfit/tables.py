"""Short tables and sentences as plain text, and as HTML for a notebook."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from html import escape

from grainfit.formatting import plain

_GAP = "  "


@dataclass(frozen=True)
class TextTable:
    """A table of texts: the first column has names, the others have numbers with units.

    Parameters
    ----------
    header : tuple of str
        Column headings.
    rows : tuple of tuple of str
        Cells.
    caption : str
        Text below the table.
    """

    header: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    caption: str = ""

    def text(self) -> str:
        """Return the table in columns of equal width."""
        lines = [[plain(cell) for cell in line] for line in (self.header, *self.rows)]
        widths = [max(map(len, column)) for column in zip(*lines, strict=True)]
        shown = (
            _GAP.join([line[0].ljust(widths[0]), *map(str.rjust, line[1:], widths[1:])])
            for line in lines
        )
        return "\n".join([*map(str.rstrip, shown), *filter(None, [plain(self.caption)])])

    def html(self) -> str:
        """Return the table as HTML, every text escaped."""
        rows = "".join(f"<tr>{''.join(_cells('td', row))}</tr>" for row in self.rows)
        head = f"<thead><tr>{''.join(_cells('th', self.header))}</tr></thead>"
        below = f"<p><small>{_escaped(self.caption)}</small></p>" if self.caption else ""
        return f"<table>{head}<tbody>{rows}</tbody></table>{below}"


def _cells(tag: str, texts: Iterable[str]) -> Iterator[str]:
    for column, text in enumerate(texts):
        side = "right" if column else "left"
        yield f'<{tag} style="text-align: {side}">{_escaped(text)}</{tag}>'


def _escaped(text: str) -> str:
    return escape(plain(text))


def _lines(text: str) -> str:
    return "\n".join(plain(line) for line in text.split("\n"))


def as_text(parts: Iterable[str | TextTable]) -> str:
    """Return sentences and tables as plain text; tables have an empty line around them."""
    shown = [f"\n{p.text()}\n" if isinstance(p, TextTable) else _lines(p) for p in parts]
    return "\n".join(shown).replace("\n\n\n", "\n\n").strip("\n")


def _paragraph(text: str) -> str:
    return f"<p>{escape(_lines(text)).replace(chr(10), '<br>')}</p>"


def as_html(parts: Iterable[str | TextTable]) -> str:
    """Return sentences and tables as HTML, the first sentence bold."""
    shown = [p.html() if isinstance(p, TextTable) else _paragraph(p) for p in parts]
    if shown and shown[0].startswith("<p>"):
        shown[0] = f"<p><b>{shown[0][3:-4]}</b></p>"
    return f"<div>{''.join(shown)}</div>"


class Summary:
    """Shows tables and sentences by `print` and in a notebook."""

    def summary(self) -> tuple[str | TextTable, ...]:
        """Return the tables and the sentences that `print` and a notebook show."""
        raise NotImplementedError

    def __str__(self) -> str:
        return as_text(self.summary())

    def _repr_html_(self) -> str:
        return as_html(self.summary())
