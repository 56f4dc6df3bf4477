"""Equations of a contact law in plain text, and the meaning of their symbols."""

from __future__ import annotations

import re
from dataclasses import dataclass

from grainfit.one_line import OneLine

#: Symbols of the motion of two bodies 1 and 2.
SYMBOLS = {
    "R": "radius of a body, infinite of a wall",
    "m": "mass of a body, infinite of a wall",
    "d": "distance of the centres",
    "delta": "overlap",
    "v_n": "speed of approach",
    "v_t": "tangential speed of the surfaces at the contact",
    "xi": "tangential displacement since the contact began, as far as it sticks",
    "theta": "rolling angle since the contact began, as far as it is elastic",
    "omega_r": "rolling speed, 1/s",
}
#: Names in formulas that are no symbols.
FUNCTIONS = frozenset({"sqrt", "ln", "exp", "max", "min", "abs", "pi"})
_NAME = re.compile(r"[A-Za-z]\w*\*?")
#: A symbol before its meaning, in a remark.
_EXPLAINED = re.compile(r"(\w+): ")
#: Number of a body at the end of a symbol.
_BODY = re.compile("_[12]$")


@dataclass(frozen=True)
class Equation(OneLine):
    """An equation of one term of a contact law.

    Products have a space between their factors, powers a ^, effective values a star (``R*``).

    Parameters
    ----------
    term : str
        Name of the term, such as "rolling limit".
    formula : str
        The equation, or the inequality of a limit.
    remark : str
        Conditions, and the meaning of symbols that are in no other place (``"h: a number"``).
    """

    term: str
    formula: str
    remark: str = ""

    @property
    def words(self) -> str:
        """Term, formula and remark in a line."""
        return f"{self.term}: {self.formula}" + (f"; {self.remark}" if self.remark else "")

    @property
    def symbols(self) -> set[str]:
        """Symbols of the formula, those of the bodies without their number."""
        return {_BODY.sub("", name) for name in _NAME.findall(self.formula)} - FUNCTIONS

    @property
    def symbols_explained(self) -> set[str]:
        """The symbol that the formula gives, and those that the remark explains."""
        given, _, _ = self.formula.partition(" = ")
        return {given, *_EXPLAINED.findall(self.remark)}


@dataclass(frozen=True)
class Convention:
    """Meaning of a parameter in the equations.

    Parameters
    ----------
    key : str
        Key of the parameter in its section of the calibration file.
    symbol : str
        In the equations.
    meaning : str
        What it is a multiple of, in a line.
    """

    key: str
    symbol: str
    meaning: str
