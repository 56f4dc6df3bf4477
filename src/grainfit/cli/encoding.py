"""Characters that the encoding of a terminal lacks, such as ± in ASCII: others stand for them."""

from __future__ import annotations

import codecs
import sys
import unicodedata
from io import TextIOWrapper

_HANDLER = "grainfit.plain"
_PLAIN = {
    "±": "+-", "…": "...", "–": "-", "—": "-", "−": "-", "×": "x", "·": "*", "⋅": "*",
    "✓": "ok", "✗": "x", "→": "->", "←": "<-", "≤": "<=", "≥": ">=", "≈": "~", "∞": "inf",
    "─": "-", "━": "-", "│": "|", "┃": "|", "‑": "-",
    "°": "deg", "µ": "u", "“": '"', "”": '"', "‘": "'", "’": "'",
}  # fmt: skip


def lose_no_output() -> None:
    """Make the standard streams print plain characters for those that their encoding lacks."""
    codecs.register_error(_HANDLER, _replace)
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, TextIOWrapper):
            stream.reconfigure(errors=_HANDLER)


def _replace(error: UnicodeError) -> tuple[str, int]:
    if not isinstance(error, UnicodeEncodeError):
        raise error
    return "".join(map(_plain, error.object[error.start : error.end])), error.end


def _plain(character: str) -> str:
    """Return ASCII for a character: its look, its name where it is Greek, or a question mark."""
    if character in _PLAIN:
        return _PLAIN[character]
    name = unicodedata.name(character, "")
    if name.startswith("GREEK ") and " LETTER " in name:
        return name.partition(" LETTER ")[2].partition(" ")[0].lower()
    known = unicodedata.normalize("NFKD", character).encode("ascii", "ignore").decode()
    return known or "?"
