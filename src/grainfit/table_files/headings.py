"""Headings of a table: names of its columns, and the units that they state."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, replace

from grainfit.options.places import show
from grainfit.units import is_unit

#: Ways to say that a number has no unit.
WITHOUT_UNIT = ("", "-", "–", "1")
_IN_BRACKETS = re.compile(r"(?P<name>[^\[\]]*?)\s*\[\s*(?P<unit>[^\[\]]*?)\s*\]")
#: As a remark may stand there as well, this is a unit only if it reads as one.
_PERHAPS = (
    re.compile(r"(?P<name>.*?\S)\s*\(\s*(?P<unit>[^()]+?)\s*\)"),
    re.compile(r"(?P<name>.*?\S)\s+/\s*(?P<unit>\S+)|(?P<other>.*?\S)/\s+(?P<its_unit>\S+)"),
)
_BEHIND_WORD = re.compile(r"(?P<name>.*?\S)(?:,\s*|\s+in\s+)(?P<unit>[^\s,]+)")
#: One letter may be a quantity: "F/A".
_BEHIND_SLASH = re.compile(r"(?P<name>[^\s/]+)/(?P<unit>\S{2,})")
_WORD = re.compile(r"[a-z]{3,}")
#: Words that are units behind a name: "mass", "strain" and "point" are units, too.
_UNITS = {
    *("bar", "mbar", "deg", "degree", "degrees", "rad", "rpm", "min", "hour", "hours"),
    *("psi", "lbf", "kgf", "inch", "mol", "ppm", "percent"),
}
#: A unit in brackets.
_BRACKETS = re.compile(r"^[\[(]\s*(.*?)\s*[\])]$")
_LONGEST_SHOWN = 60


@dataclass(frozen=True)
class Heading:
    """The heading of a column.

    Parameters
    ----------
    position : int
        Of the column, from 0.
    text : str
        The heading as it is written.
    name : str
        The heading without its unit.
    unit : str or None
        Unit that it states; None where it states none.
    """

    position: int
    text: str
    name: str
    unit: str | None = None

    @property
    def label(self) -> str:
        """Name of the column for messages; its number where it has none."""
        if not self.name:
            return str(self.position + 1)
        short = len(self.name) <= _LONGEST_SHOWN and self.name.isprintable()
        return self.name if short else show(self.name)

    @property
    def states_unit(self) -> bool:
        """Whether the unit that it states is one, and no remark in brackets."""
        return self.unit is not None and (is_unit(self.unit) or not _is_remark(self.unit))


def _is_remark(text: str) -> bool:
    return len(text.split()) > 1


def heading(position: int, text: str) -> Heading:
    """Read a heading.

    Examples
    --------
    >>> [heading(0, text).unit for text in ("u [mm]", "u (mm)", "u / mm", "u (left)")]
    ['mm', 'mm', 'mm', None]
    >>> [heading(0, text).unit for text in ("u in mm", "u, mm", "load/kN", "u/strain", "l/min")]
    ['mm', 'mm', 'kN', None, None]
    """
    found = _IN_BRACKETS.fullmatch(text)
    if found is not None:
        return Heading(position, text, found["name"], found["unit"])
    for pattern in _PERHAPS:
        found = pattern.fullmatch(text)
        if found is None:
            continue
        name, unit = [part for part in found.groups() if part]
        if is_unit(unit) or unit in WITHOUT_UNIT:
            return Heading(position, text, name, unit)
    found = _BEHIND_WORD.fullmatch(text)
    # "l/min" is a unit as a whole.
    if found is None and not is_unit(text):
        found = _BEHIND_SLASH.fullmatch(text)
    if found is not None and _is_tail(found["unit"]):
        return Heading(position, text, found["name"], found["unit"])
    return Heading(position, text, text)


def _is_tail(text: str) -> bool:
    return is_unit(text) and (text in _UNITS or _WORD.fullmatch(text) is None)


def with_units(headings: Sequence[Heading], cells: Sequence[str]) -> tuple[Heading, ...] | None:
    """Return headings with the units that a row below them has; None if it is no row of units.

    In a row of units each cell is empty, a unit, or a sign for no unit; below a heading that states
    its unit it is that one or empty.

    Examples
    --------
    >>> found = with_units([heading(0, "stress"), heading(1, "strain [%]")], ["[kPa]", ""])
    >>> [one.unit for one in found or ()]
    ['kPa', '%']
    """
    units = [_BRACKETS.sub(r"\1", cell) for cell in cells]
    if len(units) != len(headings) or not any(map(is_unit, filter(None, units))):
        return None
    if not all(unit in WITHOUT_UNIT or is_unit(unit) for unit in units):
        return None
    pairs = list(zip(headings, units, strict=True))
    if any(one.unit is not None and unit not in ("", one.unit) for one, unit in pairs):
        return None
    return tuple(replace(one, unit=one.unit or unit or None) for one, unit in pairs)


def named(headings: Sequence[Heading], name: str) -> list[Heading]:
    """Return the headings that are a name, or else those that are it beside a unit."""
    written = [one for one in headings if one.text == name]
    return written or [one for one in headings if one.name == name]
