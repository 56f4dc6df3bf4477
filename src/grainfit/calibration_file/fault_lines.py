"""Lines of faults that were found after the calibration file had been read."""

from __future__ import annotations

import re
from collections.abc import Collection, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path

from grainfit.calibration_file.line_numbers import key_lines
from grainfit.errors import Fault, InputError
from grainfit.options.places import FileFault, Findings, KeyPath, dotted

_TEST = re.compile(r"test\[(\d+)\](?:\.|$)")


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
        located = [_located(fault, _lines(path), besides) for fault in error.faults]
        if not error.source and not all(isinstance(fault, FileFault) for fault in located):
            raise
        raise InputError(located, str(path)) from error


def _lines(path: Path) -> Mapping[KeyPath, int]:
    try:
        return key_lines(path.read_text(encoding="utf-8-sig"))
    except (OSError, ValueError):
        return {}


def _located(fault: Fault, lines: Mapping[KeyPath, int], besides: Collection[str]) -> Fault:
    """Return a fault with its line; unchanged when it has one, or its key is not in the file."""
    if isinstance(fault, FileFault) or fault.key in besides:
        return fault
    test, rest = _parts(fault.key)
    # A solver knows parameters by the names of its arguments, and a strategy its options.
    exact = [path for path in ((*test, *rest), rest, ("strategy", *rest)) if path in lines]
    if not exact and not test:
        return fault
    line = lines[exact[0]] if exact else Findings(Path(), lines).line_of(test)
    key = fault.key if test else dotted(exact[0])
    return FileFault(key, fault.message, fault.remedy, line)


def _parts(key: str) -> tuple[KeyPath, KeyPath]:
    """Return the test and the rest of a key; of several keys, of the first one."""
    found = _TEST.match(key)
    test: KeyPath = () if found is None else ("test", int(found[1]))
    rest = key[found.end() if found else 0 :].partition(", ")[0]
    return test, tuple(rest.split(".")) if rest else ()
