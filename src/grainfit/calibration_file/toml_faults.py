"""Faults of text that is not TOML, in the words of somebody who writes a calibration file."""

from __future__ import annotations

import re

from grainfit.formatting import plain

_POSITION = re.compile(r"\(at line (\d+), column \d+\)|\(at end of document\)")
_NUMBER = r"[+-]?[\d.]++(?:[eE][+-]?\d+)?+"
_BARE_QUANTITY = re.compile(
    rf"""=\s*(?P<quantity>{_NUMBER}\s*+[^\s\d#,;}}\]"'][^#,}}"']{{0,20}})"""
)
_BARE_INTERVAL = re.compile(rf"=\s*(?P<interval>{_NUMBER}\s*(?:\.\.+|-|–|to\b)\s*{_NUMBER})")
_BARE_WORD = re.compile(r"=\s*(?P<word>[A-Za-z_][\w .-]{0,40}?)\s*(?:[#,}\]]|$)")
_DECIMAL_COMMA = re.compile(r"=\s*(?P<number>[+-]?\d+,\d+)")
_SEMICOLON = re.compile(rf"=\s*(?P<number>{_NUMBER})\s*;")
_CURLY_QUOTE = re.compile(r"=\s*[“”„‘’‚«»]")
_TRUTH = ("true", "false", "yes", "no", "on", "off")
#: Beginnings of what `tomllib` says of a key or a section that is there already.
_GIVEN_TWICE = ("Cannot overwrite a value", "Duplicate inline table key", "Cannot declare")
_CLOSED_TABLE = "Cannot mutate immutable namespace"
NOT_TOML = "It must be a TOML file; docs/reference/calibration_file shows one."


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
    slip = _of_keys(words, written) or _of_value(written) or _of_brackets(written)
    return (*(slip or (f"is not valid TOML: {error}.", NOT_TOML)), line)


def _of_keys(words: str, written: str) -> tuple[str, str] | None:
    """Return message and remedy of a key or a section that is given twice."""
    if words.startswith(_CLOSED_TABLE):
        key, _, added = written.partition("=")[0].strip().rpartition(".")
        remedy = f"Write all keys of {key} there, or each in a line of its own, as here."
        return f"adds {added} to {key}, which is complete with the }} above.", remedy
    if not words.startswith(_GIVEN_TWICE):
        return None
    if written.startswith("["):
        return f"has the section {written} again.", "Put all of its keys below the first one."
    found = re.search(r"Duplicate inline table key '(.+?)'", words)
    key = found[1] if found else written.partition("=")[0].strip()
    return f"gives {key} again.", "Remove one of them, or add the missing [section] above this one."


def _of_value(written: str) -> tuple[str, str] | None:
    """Return message and remedy of a value that is written as elsewhere, but not in TOML."""
    if _CURLY_QUOTE.search(written):
        return f"has curly quotes, in <{written[:60]}>.", 'Write straight ones: "10 mm".'
    if comma := _DECIMAL_COMMA.search(written):
        point = comma["number"].replace(",", ".")
        return f"has the decimal comma {comma['number']}.", f"Write a decimal point: {point}."
    if ended := _SEMICOLON.search(written):
        return f"has a ; behind {ended['number']}.", "Remove it: a value ends with its line."
    if interval := _BARE_INTERVAL.search(written):
        remedy = "An interval is written { min = ..., max = ... }."
        return f"has {interval['interval']}.", remedy
    if bare := _BARE_QUANTITY.search(written):
        quantity = bare["quantity"].strip()
        return f"has {quantity} without quotes.", f'Write "{quantity}".'
    bare = _BARE_WORD.search(written)
    if bare is None or bare["word"] in ("true", "false", "nan", "inf"):
        return None
    word = bare["word"]
    if word.lower() in _TRUTH:
        return f"has {word}.", "Write true or false."
    return f"has {word} without quotes.", f'Write "{word}".'


def _of_brackets(written: str) -> tuple[str, str] | None:
    """Return message and remedy of brackets that do not belong together."""
    before = written.partition("#")[0].strip()
    if before.startswith("[") and not re.fullmatch(r"\[[^][]+\]|\[\[[^][]+\]\]", before):
        remedy = "Write [section] in one bracket on each side, and [[test]] in two."
        return f"has brackets that do not match, in <{written[:60]}>.", remedy
    if before.count("{") > before.count("}"):
        message = f"has a {{ that is not closed, in <{written[:60]}>."
        return message, "Write all from { to } in one line."
    return None


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
