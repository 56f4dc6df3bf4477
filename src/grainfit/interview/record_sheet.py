"""A sheet for the laboratory: what to do, and blank lines for what is measured."""

from __future__ import annotations

import textwrap
from collections.abc import Iterable, Iterator, Mapping
from typing import Any

from grainfit.bulk_tests.registry import BUILT_IN
from grainfit.formatting import unit_for_people
from grainfit.interview.equipment import Way

_WIDTH, _REPEATS = 78, 5
_BLANK = "________"
#: Units that are read off, where those of the responses are too large.
_USUAL = {"m": "mm", "kg/s": "g/s"}


def record_sheet(
    material: str, moisture: str, tests: Iterable[tuple[Way, Mapping[str, Any]]]
) -> str:
    """Return the sheet as text of 78 columns.

    Parameters
    ----------
    material, moisture : str
        Of the sample; empty if it is not known.
    tests : iterable of (Way, mapping)
        The tests, each with its section of the calibration file.
    """
    return "\n".join(line.rstrip() for line in _lines(material, moisture, tests)) + "\n"


def _lines(
    material: str, moisture: str, tests: Iterable[tuple[Way, Mapping[str, Any]]]
) -> Iterator[str]:
    yield f"RECORD SHEET: {material}"
    yield f"Moisture: {moisture or _BLANK}   Sample: {_BLANK}   Date: {_BLANK}   By: {_BLANK}"
    for way, test in tests:
        yield from ("", "=" * _WIDTH, f"{way.name}: {way.title}", "")
        for number, step in enumerate(way.steps, 1):
            yield from textwrap.wrap(
                step, _WIDTH, initial_indent=f"{number}. ", subsequent_indent="   "
            )
        yield ""
        keys = {key.name: key for key in BUILT_IN[way.test].option_keys()}
        for option in way.options:
            given = test.get(option, "")
            words = keys[option].description.partition(". ")[0].rstrip(".")
            yield f"{option.replace('_', ' ')}: {given if given != '' else _BLANK}"
            yield from textwrap.wrap(words, _WIDTH, initial_indent="    ", subsequent_indent="    ")
        yield ""
        yield f"{'':32}{''.join(f'{n:<9}' for n in range(1, _REPEATS + 1))}"
        for response in way.responses:
            unit = BUILT_IN[way.test].responses[response].unit
            unit = unit_for_people(_USUAL.get(unit, unit))
            label = f"{response.replace('_', ' ')}{f', {unit}' if unit else ''}"
            yield f"{label:<32}{f'{_BLANK} ' * _REPEATS}"
