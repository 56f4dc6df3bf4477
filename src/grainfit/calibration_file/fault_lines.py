"""Lines of faults that were found after the calibration file had been read."""

from __future__ import annotations

import re
from collections.abc import Collection, Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from grainfit.calibration_file.line_numbers import key_lines
from grainfit.checks import Finding
from grainfit.errors import Fault, InputError
from grainfit.options.places import FileFault, Findings, KeyPath, dotted

_TEST = re.compile(r"(test|holdout)\[(\d+)\](?:\.|$)")
#: Before the key of a fault of one of several tests.
_NAME = re.compile(r"test \w+, ")


@contextmanager
def with_lines(path: Path, besides: Collection[str] = ()) -> Iterator[None]:
    """Name the file and the line in faults that are raised within.

    Parameters
    ----------
    path : Path
        The calibration file.
    besides : collection of str
        Keys that were given elsewhere, so that no line of the file is at fault.
    """
    try:
        yield
    except InputError as error:
        if error.source not in ("", str(path)):
            raise
        found = faults_with_lines(path, error.faults, besides)
        if not error.source and not all(map(_has_line, found)):
            raise
        raise InputError(found, str(path)) from error


def faults_with_lines(
    path: Path, faults: Iterable[Fault], besides: Collection[str] = ()
) -> list[Fault]:
    """Return faults with their lines, as far as their keys are in the file.

    Parameters
    ----------
    path, besides
        As in `with_lines`.
    faults : iterable of Fault
        Keys are dotted, ``test[0].`` or ``test NAME, `` before them; of an option of the only test
        or of a strategy, the option alone.
    """
    lines = _lines(path)
    return [
        fault if _has_line(fault) or fault.key in besides else _located(fault, lines)
        for fault in faults
    ]


@dataclass(frozen=True)
class FileFinding(Finding):
    """A finding of a check, with the line of its key; None where the file does not have it."""

    line: int | None = None


def with_key_lines(path: Path, findings: Iterable[Finding]) -> tuple[FileFinding, ...]:
    """Return findings with the lines of their keys.

    Parameters
    ----------
    path : Path
        The calibration file.
    findings : iterable of Finding
        What checks found.
    """
    lines = _lines(path)
    found = []
    for one in findings:
        located = _located(Fault(one.key, one.text), lines) if one.key else None
        line = located.line if isinstance(located, FileFault) else None
        found.append(FileFinding(one.check, one.severity, one.text, one.key, line))
    return tuple(found)


def _has_line(fault: Fault) -> bool:
    return isinstance(fault, FileFault) and fault.line is not None


def _lines(path: Path) -> Mapping[KeyPath, int]:
    try:
        return key_lines(path.read_text(encoding="utf-8-sig"))
    except (OSError, ValueError):
        return {}


def _located(fault: Fault, lines: Mapping[KeyPath, int]) -> Fault:
    """Return a fault with the line of its key; unchanged when the file does not have it."""
    named = _NAME.match(fault.key)
    test, rest = _parts(fault.key[named.end() if named else 0 :])
    place = next((path for path in _places(test, rest, lines) if path in lines), test)
    if not place:
        return fault
    key = fault.key if test or named else dotted(place)
    line = Findings(Path(), lines).line_of(place)
    return FileFault(key, fault.message, fault.remedy, line)


def _parts(key: str) -> tuple[KeyPath, KeyPath]:
    """Return the test and the rest of a key; of several keys, of the first one."""
    found = _TEST.match(key)
    test: KeyPath = () if found is None else (found[1], int(found[2]))
    rest = key[found.end() if found else 0 :].partition(", ")[0]
    return test, tuple(rest.split(".")) if rest else ()


def _places(test: KeyPath, rest: KeyPath, lines: Mapping[KeyPath, int]) -> Iterator[KeyPath]:
    """Yield where the key of a fault may be in the file."""
    yield (*test, *rest)
    if not test:
        # A strategy and a solver know options by their own names.
        yield ("strategy", *rest)
        of_tests = [path for path in lines if path[0] == "test" and path[2:] == rest]
        yield from of_tests if rest and len(of_tests) == 1 else ()
    elif rest and str(rest[0]).partition("_")[0] in ("particle", "wall"):
        yield rest
