"""Faults of text that is not TOML, in the words of somebody who writes a calibration file."""

from __future__ import annotations

import re

from grainfit.formatting import plain

_POSITION = re.compile(r"\(at line (\d+), column \d+\)|\(at end of document\)")
_BARE_QUANTITY = re.compile(
    r"""=\s*(?P<quantity>[+-]?[\d.]+(?:[eE][+-]?\d+)?\s*[^\s\d#,}\]"'][^#,}"']{0,20})"""
)
_NOT_TOML = "It must be a TOML file; docs/calibration_file.md shows one."


def toml_fault(text: str, error: ValueError) -> tuple[str, str, int | None]:
    """Return message, remedy and line of a text that `tomllib` refuses.

    Parameters
    ----------
    text : str
        The whole text.
    error : ValueError
        As raised by `tomllib`.
    """
    words = str(error)
    position = _POSITION.search(words)
    line = int(position[1]) if position and position[1] else None
    if line is None:
        line = _line_of_open_quote(text, words)
    lines = text.split("\n")
    written = plain(lines[line - 1].strip()) if line is not None and line <= len(lines) else ""
    if _is_open_quote(words, written):
        message = f"has a quote that is not closed, in <{written[:60]}>."
        return message, 'Close it, as in diameter = "10 mm".', line
    bare = _BARE_QUANTITY.search(written)
    if bare is not None:
        quantity = bare["quantity"].strip()
        return f"has {quantity} without quotes.", f'Write "{quantity}".', line
    return f"is not valid TOML: {error}.", _NOT_TOML, line


def _is_open_quote(words: str, written: str) -> bool:
    ended = words.startswith(("Illegal character '\\n'", "Unterminated string", 'Expected "\'"'))
    return ended and bool(written)


def _line_of_open_quote(text: str, words: str) -> int | None:
    """Return the first line with an odd number of the quotes that are missing at the end."""
    quote = "'" if words.startswith('Expected "\'"') else '"'
    for number, line in enumerate(text.split("\n"), 1):
        if line.partition("#")[0].count(quote) % 2:
            return number
    return None
