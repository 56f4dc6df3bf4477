"""What a laboratory has at hand, and which tests can be measured with it."""

from __future__ import annotations

import tomllib
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cache
from importlib.resources import files
from pathlib import Path
from typing import Any

from grainfit.bulk_tests.instrument import instrument_names, read_instrument
from grainfit.bulk_tests.registry import BUILT_IN

_FILE = Path(__file__).with_name("equipment.toml")


@dataclass(frozen=True)
class Way:
    """A way to measure a bulk test.

    Parameters
    ----------
    name : str
        That of the test in a calibration file: its type, or that of an instrument.
    test : str
        Type of the test.
    responses : tuple of str
        Those that can be measured with what is at hand.
    options : tuple of str
        Options of the test that say how large the apparatus is and how it is operated.
    steps : tuple of str
        Sentences for the operator.
    apparatus : str
        Name of the instrument; empty without one.
    only : mapping of str to (str, str)
        Options that another option with a value leads to.
    """

    name: str
    test: str
    responses: tuple[str, ...]
    options: tuple[str, ...]
    steps: tuple[str, ...]
    apparatus: str = ""
    only: Mapping[str, Sequence[str]] = field(default_factory=dict)

    def options_of(self, test: Mapping[str, Any]) -> list[str]:
        """Return the options that the section of a test in a file leads to."""
        keys = {key.name: key for key in BUILT_IN[self.test].option_keys()}
        usual = {name: key.in_words().default.strip('"') for name, key in keys.items()}

        def applies(option: str) -> bool:
            other, value = self.only.get(option, ("", ""))
            return not other or test.get(other, usual[other]) == value

        return [name for name in self.options if name in keys and applies(name)]

    @property
    def drawing(self) -> str:
        """Drawing of the apparatus with its dimensions as SVG; empty where there is none."""
        drawing = files(BUILT_IN[self.test].__module__.rpartition(".")[0]) / "apparatus.svg"
        return drawing.read_text(encoding="utf-8") if drawing.is_file() else ""

    @property
    def title(self) -> str:
        """Name of test or instrument for people."""
        known = BUILT_IN[self.test].title
        return read_instrument(self.apparatus).title if self.apparatus else known


def equipment() -> dict[str, str]:
    """Return all that can be at hand, with a description: things first, then instruments."""
    instruments = {name: read_instrument(name).title for name in instrument_names()}
    return {**_things(), **instruments}


def ways(at_hand: Collection[str]) -> tuple[Way, ...]:
    """Return the tests that can be measured.

    Examples
    --------
    >>> [way.name for way in ways({"bucket", "scale", "funnel", "phone"})]
    ['funnel', 'packing']
    >>> ways({"granudrum"})[0].test
    'drum'
    """
    found = [way for test in _ways() if (way := _possible(test, at_hand)) is not None]
    return (*found, *(_of_instrument(name) for name in instrument_names() if name in at_hand))


def way_of(test: str, apparatus: str = "", name: str = "") -> Way | None:
    """Return the whole way to measure a test of a file; None where none is known.

    Parameters
    ----------
    test, apparatus, name : str
        Type, instrument and own name of the test.
    """
    if apparatus in instrument_names():
        known = _of_instrument(apparatus)
    elif test in _ways():
        known = _whole(test)
    else:
        return None
    return replace(known, name=name or test, test=test)


@cache
def _read() -> Mapping[str, Any]:
    return tomllib.loads(_FILE.read_text(encoding="utf-8"))


def _things() -> dict[str, str]:
    things: dict[str, str] = _read()["things"]
    return things


def _ways() -> Mapping[str, Mapping[str, Any]]:
    found: Mapping[str, Mapping[str, Any]] = _read()["ways"]
    return found


def _whole(test: str) -> Way:
    table = _ways()[test]
    responses, options, steps = (tuple(table[key]) for key in ("responses", "options", "steps"))
    return Way(test, test, responses, options, steps, only=table.get("only", {}))


def _possible(test: str, at_hand: Collection[str]) -> Way | None:
    table = _ways()[test]
    for need in table["needs"]:
        if not _has(at_hand, [need] if isinstance(need, str) else need):
            return None
    responses = tuple(name for name, by in table["responses"].items() if _has(at_hand, by))
    return replace(_whole(test), responses=responses) if responses else None


def _has(at_hand: Collection[str], tools: Sequence[str]) -> bool:
    return any(tool in at_hand for tool in tools)


def _of_instrument(name: str) -> Way:
    instrument = read_instrument(name)
    printed = dict.fromkeys(one.response for one in instrument.prints if one.response)
    responses = tuple(r for r in printed if r in BUILT_IN[instrument.type].responses)
    # What the instrument leaves to its operator.
    whole = _whole(instrument.type)
    options = tuple(key for key in whole.options if key not in instrument.options)
    steps = instrument.procedure
    return Way(name, instrument.type, responses, options, steps, name, whole.only)
