"""Find the columns of a sieve curve by their headings."""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass

from grainfit.errors import Fault, InputError
from grainfit.options.csv_points import stated_unit
from grainfit.options.places import show
from grainfit.units import UnitError, to_unit

#: By ISO 9276, Q3 is the cumulative passing, and q3 its density.
_PASSING = re.compile(r"(?i:pass|finer|undersize|under size)|\bQ_?3\b")
_RETAINED = re.compile(r"retain|residue|coarser|oversize|over size", re.IGNORECASE)
_OPENING = re.compile(r"opening|aperture|sieve|mesh|size|diameter|^[dx]\b", re.IGNORECASE)
#: Headings that are named in a message, at most.
_MOST_NAMED = 10


@dataclass(frozen=True)
class _Heading:
    """A column by its heading.

    Parameters
    ----------
    position : int
        Of the column.
    name, unit : str
        Heading without its unit, and the unit in it.
    """

    position: int
    name: str
    unit: str

    @property
    def is_retained(self) -> bool:
        return _RETAINED.search(self.name) is not None

    @property
    def is_passing(self) -> bool:
        return _PASSING.search(self.name) is not None

    @property
    def is_opening(self) -> bool:
        return _OPENING.search(self.name) is not None

    @property
    def is_percentage(self) -> bool:
        return "%" in self.unit or "%" in self.name

    def is_in(self, unit: str) -> bool:
        """Return whether its unit converts to another one."""
        try:
            to_unit(f"1 {self.unit}", unit)
        except UnitError:
            return False
        return bool(self.unit)


_Rank = Callable[[_Heading], bool]
#: Columns that hold the passing and the openings, those that say it most clearly first.
_PASSINGS: Sequence[_Rank] = (
    lambda heading: heading.name.lower() == "passing",
    lambda heading: heading.is_passing,
    lambda heading: heading.is_percentage,
)
_OPENINGS: Sequence[_Rank] = (
    lambda heading: heading.is_opening and heading.is_in("m"),
    lambda heading: heading.is_in("m"),
    lambda heading: heading.is_opening,
)


def sieve_columns(header: Sequence[str]) -> tuple[int, int]:
    """Return the positions of the openings and of what passes.

    Where two columns say nothing, they are taken in this order.

    Parameters
    ----------
    header : sequence of str
        Headings, with or without units.

    Raises
    ------
    InputError
        The headings leave open which column it is, or tell of other quantities.

    Examples
    --------
    >>> sieve_columns(["passing [%]", "mass [g]", "opening [mm]"])
    (2, 0)
    """
    headings = [_heading(position, text) for position, text in enumerate(header)]
    headings = [heading for heading in headings if not heading.is_retained]
    shares = [h for h in headings if not h.is_in("kg") and not h.is_in("m")]
    second = [h for h in shares if h.position == 1 and len(header) == 2]
    passing = _first_rank(shares, _PASSINGS) or second
    value = _only(passing, header, "cumulative passing", "passing [%]")
    others = [heading for heading in headings if heading.position != value]
    opening = _first_rank(others, _OPENINGS) or others[:1]
    return _only(opening, header, "opening", "opening [mm]"), value


def _heading(position: int, text: str) -> _Heading:
    unit = stated_unit(text)
    name = re.sub(r"\s*[\[(][^\[\]()]*[\])]\s*$", "", text)
    return _Heading(position, name, unit)


def _first_rank(headings: Sequence[_Heading], ranks: Sequence[_Rank]) -> list[_Heading]:
    """Return the headings of the first rank that any of them has."""
    found = ([h for h in headings if rank(h)] for rank in ranks)
    return next((some for some in found if some), [])


def _only(found: Sequence[_Heading], header: Sequence[str], meaning: str, example: str) -> int:
    """Return the position of the only column that was found.

    Raises
    ------
    InputError
        There is none, or more than one.
    """
    if len(found) == 1:
        return found[0].position
    there = ", ".join(show(text) for text in header[:_MOST_NAMED])
    count = "more than one of them may be" if found else "none of them is"
    remedy = f'Give one column the heading "{example}"'
    if not found and any(_RETAINED.search(text) for text in header):
        remedy += ": 100 % minus all that this sieve and the coarser ones retain"
    words = f"has the columns {there}, and {count} the {meaning}."
    raise InputError(Fault("", words, f"{remedy}."))
