"""Edits of the text of a calibration file: one value or one test; all else stays as it is.

Every edit is read again and compared with what it was to do: an edit that would change anything
else is refused.
"""

from __future__ import annotations

import copy
import re
import tomllib
from typing import Any

from grainfit.errors import InputError
from grainfit.interview import messages

#: Keys and numbers of tests on the way to a value.
Path = tuple[str | int, ...]
_STRATEGY = re.compile(r"^\[strategy\]", re.MULTILINE)
_TEST = re.compile(r"^\s*\[\[\s*test\s*\]\]")
_HEADER = re.compile(r"^\s*\[")
_OF_TEST = re.compile(r"^\s*\[+\s*test\s*\.")
_NOTE = "# {name}: {value}"


def with_value(text: str, path: Path, toml: str) -> str:
    """Return the text with one value set, given as TOML; its tables are made.

    Raises
    ------
    InputError
        The text is written so that only a person can change it.
    """
    import tomlkit

    expected = _changed(text, path, tomllib.loads(f"value = {toml}")["value"])
    uncommented = _uncommented(text, path, toml)
    if uncommented and _data(uncommented) == expected:
        return uncommented
    document = tomlkit.parse(text)
    place: Any = document
    for step in path[:-1]:
        if isinstance(step, str) and step not in place:
            place[step] = tomlkit.table() if place is document else tomlkit.table(True)
        place = place[step]
    value = tomlkit.value(toml)
    was_free = isinstance(place.get(path[-1]), dict) and not isinstance(value, dict)
    place[path[-1]] = value
    if was_free and (trivia := place[path[-1]].trivia).comment == "# free":
        trivia.comment = trivia.comment_ws = ""
    return _verified(tomlkit.dumps(document), expected, path)


def without_value(text: str, path: Path) -> str:
    """Return the text without a value."""
    import tomlkit

    document = tomlkit.parse(text)
    place: Any = document
    data = tomllib.loads(text)
    inner: Any = data
    for step in path[:-1]:
        place, inner = place[step], inner[step]
    del place[path[-1]], inner[path[-1]]
    return _verified(tomlkit.dumps(document), data, path)


def with_test(text: str, block: str) -> str:
    """Return the text with one more test, before the strategy where that is possible."""
    expected = tomllib.loads(text)
    expected.setdefault("test", []).extend(tomllib.loads(block)["test"])
    found = _STRATEGY.search(text)
    if found is not None:
        changed = f"{text[: found.start()]}{block}\n{text[found.start() :]}"
        if tomllib.loads(changed) == expected:
            return changed
    return _verified(f"{text.rstrip()}\n\n{block}", expected, ("test",))


def without_test(text: str, number: int) -> str:
    """Return the text without a test, counted from zero, and without the comments in it."""
    expected = tomllib.loads(text)
    del expected["test"][number]
    if not expected["test"]:
        del expected["test"]
    lines = text.splitlines(keepends=True)
    start, end = _span(lines, ("test", number))
    # Comments right above the next section are its own.
    while end - 1 > start and lines[end - 1].lstrip().startswith("#") and end < len(lines):
        end -= 1
    return _verified("".join(lines[:start] + lines[end:]), expected, ("test",))


def _span(lines: list[str], path: Path) -> tuple[int, int]:
    """Return the lines of a section, from its heading; none if it is written otherwise."""
    if path[0] == "test":
        starts = [n for n, line in enumerate(lines) if _TEST.match(line)]
        starts = starts[int(path[1]) :]
    else:
        heading = re.compile(rf"^\s*\[\s*{re.escape(str(path[0]))}\s*\]")
        starts = [n for n, line in enumerate(lines) if heading.match(line)]
    if not starts:
        return 0, 0
    after = range(starts[0] + 1, len(lines))
    ends = (n for n in after if _HEADER.match(lines[n]) and not _OF_TEST.match(lines[n]))
    return starts[0], next(ends, len(lines))


def _uncommented(text: str, path: Path, toml: str) -> str:
    """Return the text with a value in place of the comment that has its key; empty without one."""
    lines = text.splitlines(keepends=True)
    key = ".".join(map(str, path[2:] if path[0] == "test" else path[1:]))
    comment = re.compile(rf"^# {re.escape(key)} = .*?(?P<remark>\s# .*)?$")
    for number in range(*_span(lines, path)):
        found = comment.match(lines[number].rstrip("\n"))
        if found is not None:
            line = f"{key} = {toml}"
            remark = (found["remark"] or "").strip()
            lines[number] = f"{line:<39} {remark}".rstrip() + "\n"
            return "".join(lines)
    return ""


def note(text: str, name: str) -> str:
    """Return what a comment of the form ``# name: value`` says; empty if there is none."""
    found = re.search(rf"^# {re.escape(name)}:(.*)$", text, re.MULTILINE)
    return found[1].strip() if found else ""


def with_note(text: str, name: str, value: str) -> str:
    r"""Return the text with such a comment, at the place of the earlier one or at the top.

    Examples
    --------
    >>> with_note("a = 1\n", "moisture", "12 %")
    '# moisture: 12 %\na = 1\n'
    """
    line = _NOTE.format(name=name, value=" ".join(value.split()))
    pattern = re.compile(rf"^# {re.escape(name)}:.*$", re.MULTILINE)
    if pattern.search(text):
        return pattern.sub(lambda _: line, text, count=1)
    # Below the first comments, which are about the file.
    lines = text.splitlines(keepends=True)
    head = next((n for n, one in enumerate(lines) if not one.startswith("#")), len(lines))
    return "".join([*lines[:head], f"{line}\n", *lines[head:]])


def _changed(text: str, path: Path, value: object) -> dict[str, Any]:
    data = tomllib.loads(text)
    place: Any = data
    for step in path[:-1]:
        place = place.setdefault(step, {}) if isinstance(step, str) else place[step]
    place[path[-1]] = copy.deepcopy(value)
    return data


def _verified(text: str, expected: dict[str, Any], path: Path) -> str:
    if _data(text) != expected:
        raise InputError(messages.NOT_BY_MACHINE.fault(".".join(map(str, path))))
    return text if text.endswith("\n") else f"{text}\n"


def _data(text: str) -> dict[str, Any] | None:
    try:
        return tomllib.loads(text)
    except ValueError:
        return None
