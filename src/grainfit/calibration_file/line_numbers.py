"""Find the line of every key in a TOML text; `tomllib` does not report it."""

from __future__ import annotations

import contextlib
import re
import tomllib

from grainfit.options.places import KeyPath

_STRING = re.compile(
    r'"""(?:\\.|[^\\])*?"{3,5}|\'\'\'.*?\'{3,5}|"(?:\\.|[^"\\\n])*"|\'[^\'\n]*\'', re.DOTALL
)
_SPACE = re.compile(r"[ \t]*")
_SPACE_AND_COMMENTS = re.compile(r"(?:[ \t\r\n]|#[^\n]*)*")
_BARE = re.compile(r"[A-Za-z0-9_-]+")
_PLAIN_VALUE = re.compile(r"[^,\]}#\n]+")


def key_lines(text: str) -> dict[KeyPath, int]:
    """Return the line, counted from 1, of every key and list entry.

    Parameters
    ----------
    text : str
        Valid TOML; of anything else, only the lines up to the first surprise are found.
    """
    finder = _Finder(text)
    # A wrong line number is a nuisance, a traceback instead of the fault's message is worse.
    with contextlib.suppress(_UnexpectedTextError, RecursionError):
        finder.document()
    return finder.lines


class _UnexpectedTextError(Exception):
    pass


class _Finder:
    def __init__(self, text: str) -> None:
        self.text = text
        self.position = 0
        self.lines: dict[KeyPath, int] = {}
        self._line = 1
        self._counted = 0
        self._table_counts: dict[KeyPath, int] = {}

    def document(self) -> None:
        table: KeyPath = ()
        self._match(_SPACE_AND_COMMENTS)
        while self.position < len(self.text):
            if self._peek("["):
                table = self._header()
            else:
                self._pair(table)
            self._match(_SPACE_AND_COMMENTS)

    def _header(self) -> KeyPath:
        line = self._current_line()
        brackets = 2 if self._peek("[[") else 1
        self.position += brackets
        parts = self._dotted_key()
        self.position += brackets
        if brackets == 1:
            path = self._inside_latest(parts)
        else:
            tables = self._inside_latest(parts[:-1]) + parts[-1:]
            self.lines.setdefault(tables, line)
            self._table_counts[tables] = self._table_counts.get(tables, 0) + 1
            path = (*tables, self._table_counts[tables] - 1)
        self.lines.setdefault(path, line)
        return path

    def _inside_latest(self, parts: KeyPath) -> KeyPath:
        """Add to every list of tables on the way the position of its latest table."""
        path: KeyPath = ()
        for part in parts:
            path = (*path, part)
            if path in self._table_counts:
                path = (*path, self._table_counts[path] - 1)
        return path

    def _pair(self, table: KeyPath) -> None:
        line = self._current_line()
        path = table
        for part in self._dotted_key():
            path = (*path, part)
            self.lines.setdefault(path, line)
        self._expect("=")
        self._value(path)

    def _dotted_key(self) -> KeyPath:
        parts: list[str] = []
        while True:
            self._match(_SPACE)
            quoted = _STRING.match(self.text, self.position)
            if quoted:
                self.position = quoted.end()
                parts.append(tomllib.loads(f"key = {quoted.group()}")["key"])
            else:
                parts.append(self._match(_BARE))
            self._match(_SPACE)
            if not self._peek("."):
                return tuple(parts)
            self.position += 1

    def _value(self, path: KeyPath) -> None:
        self._match(_SPACE)
        string = _STRING.match(self.text, self.position)
        if string:
            self.position = string.end()
        elif self._peek("["):
            self._list(path)
        elif self._peek("{"):
            self._inline_table(path)
        else:
            self._match(_PLAIN_VALUE)

    def _list(self, path: KeyPath) -> None:
        self.position += 1
        index = 0
        self._match(_SPACE_AND_COMMENTS)
        while not self._peek("]"):
            self._note((*path, index))
            self._value((*path, index))
            self._match(_SPACE_AND_COMMENTS)
            if self._peek(","):
                self.position += 1
                self._match(_SPACE_AND_COMMENTS)
            index += 1
        self.position += 1

    def _inline_table(self, path: KeyPath) -> None:
        self.position += 1
        self._match(_SPACE_AND_COMMENTS)
        while not self._peek("}"):
            self._pair(path)
            self._match(_SPACE_AND_COMMENTS)
            if self._peek(","):
                self.position += 1
                self._match(_SPACE_AND_COMMENTS)
        self.position += 1

    def _note(self, path: KeyPath) -> None:
        self.lines.setdefault(path, self._current_line())

    def _current_line(self) -> int:
        self._line += self.text.count("\n", self._counted, self.position)
        self._counted = self.position
        return self._line

    def _peek(self, start: str) -> bool:
        return self.text.startswith(start, self.position)

    def _expect(self, character: str) -> None:
        if not self._peek(character):
            raise _UnexpectedTextError
        self.position += 1

    def _match(self, pattern: re.Pattern[str]) -> str:
        match = pattern.match(self.text, self.position)
        if match is None:
            raise _UnexpectedTextError
        self.position = match.end()
        return match.group()
