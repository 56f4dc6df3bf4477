"""Kinds of option: the values that it accepts, in a calibration file and in Python.

A kind does two things: it reads a value, noting every fault, and it describes the values that it
accepts as JSON Schema. So the reader and the published schema cannot disagree on the keys.
"""

from __future__ import annotations

import difflib
import math
import re
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from functools import partial
from typing import Any

from grainfit.errors import Fault
from grainfit.one_line import OneLine
from grainfit.options import messages
from grainfit.options.places import Place, kind_of, show
from grainfit.units import UnitError, example_with, how_to_write, to_unit
from grainfit.validation import is_computable, is_whole

Schema = dict[str, Any]

NAME_PATTERN = r"[A-Za-z_][A-Za-z0-9_]{0,63}"
_NAME_REMEDY = "Use up to 64 letters (a to z), digits and _, not starting with a digit."
_LONGEST_TEXT = 200
_LARGEST_WHOLE = 2**31 - 1


class Kind(ABC):
    """A kind of value: reads it, and describes it as JSON Schema."""

    @abstractmethod
    def read(self, value: Any, place: Place) -> Any:
        """Return the value as the program uses it; None after noting its faults."""

    @abstractmethod
    def schema(self) -> Schema:
        """Return the JSON Schema of the accepted values."""


def note_wrong_kind(value: Any, place: Place, expected: str, remedy: str = "") -> None:
    """Note that a value is, for example, a list where a number is expected."""
    place.fault(
        messages.WRONG_KIND,
        given=show(value),
        kind=kind_of(value),
        expected=expected,
        remedy=remedy,
    )


@dataclass(frozen=True)
class Text(Kind):
    """One line of text."""

    def read(self, value: Any, place: Place) -> str | None:
        """Read one line of text."""
        if not isinstance(value, str):
            note_wrong_kind(value, place, "a text", 'Write it in quotes: "...".')
        elif not value.strip() or len(value) > _LONGEST_TEXT or not value.isprintable():
            place.fault(messages.NOT_ONE_LINE, given=show(value), longest=_LONGEST_TEXT)
        else:
            return value
        return None

    def schema(self) -> Schema:
        """Return the JSON Schema of one line of text."""
        return {"type": "string", "minLength": 1, "maxLength": _LONGEST_TEXT}


@dataclass(frozen=True)
class Name(Kind):
    """A text that names something, in file names, templates and tables too."""

    def read(self, value: Any, place: Place) -> str | None:
        """Read a name."""
        if not isinstance(value, str):
            note_wrong_kind(value, place, "a text", 'Write it in quotes: "...".')
        elif note_bad_name(value, place):
            return value
        return None

    def schema(self) -> Schema:
        """Return the JSON Schema of a name."""
        return {"type": "string", "pattern": f"^{NAME_PATTERN}$"}


def note_bad_name(name: str, place: Place) -> bool:
    """Return whether a text can be a name, and note it when it cannot."""
    good = re.fullmatch(NAME_PATTERN, name) is not None
    if not good:
        place.fault(messages.BAD_NAME, name=show(name), remedy=_NAME_REMEDY)
    return good


@dataclass(frozen=True)
class Choice(Kind):
    """One of a few words.

    Parameters
    ----------
    options : tuple of str
        The words.
    elsewhere : callable, optional
        Returns what to use for another word that users expect here; empty where it does not know.
    """

    options: tuple[str, ...]
    elsewhere: Callable[[object], str] | None = field(default=None, compare=False)

    def read(self, value: Any, place: Place) -> str | None:
        """Read one of the words."""
        if isinstance(value, str) and value in self.options:
            return value
        door = self.elsewhere(value) if self.elsewhere else ""
        place.fault(
            messages.NOT_A_CHOICE,
            given=show(value),
            remedy=door or suggest(value, self.options, "Possible here"),
        )
        return None

    def schema(self) -> Schema:
        """Return the JSON Schema of the words."""
        return {"enum": list(self.options)}


def suggest(wrong: object, known: Iterable[str], otherwise: str) -> str:
    """Return a sentence that suggests the closest known word, or lists all known words."""
    options = list(known)
    close = difflib.get_close_matches(str(wrong)[:64], options, n=1)
    if close:
        return messages.MEANT(name=close[0])
    return f"{otherwise}: {', '.join(options)}."


@dataclass(frozen=True)
class Flag(Kind):
    """True or false."""

    def read(self, value: Any, place: Place) -> bool | None:
        """Read true or false."""
        if isinstance(value, bool):
            return value
        note_wrong_kind(value, place, "true or false", "Write true or false, without quotes.")
        return None

    def schema(self) -> Schema:
        """Return the JSON Schema of true and false."""
        return {"type": "boolean"}


@dataclass(frozen=True)
class Whole(Kind):
    """A whole number."""

    lowest: int
    highest: int = _LARGEST_WHOLE

    def read(self, value: Any, place: Place) -> int | None:
        """Read a whole number."""
        if not is_whole(value):
            example = min(max(self.lowest, 4), self.highest)
            note_wrong_kind(value, place, "a whole number", f"For example {example}.")
        elif not self.lowest <= value <= self.highest:
            limits = self.limits() if value < self.lowest else self._both_limits()
            place.fault(messages.COUNT_OUT_OF_LIMITS, given=show(value), limits=limits)
        else:
            return value
        return None

    def limits(self) -> str:
        """Return the possible values in words."""
        if self.highest == _LARGEST_WHOLE:
            return f"at least {self.lowest}"
        return self._both_limits()

    def _both_limits(self) -> str:
        return f"from {self.lowest} to {self.highest}"

    def schema(self) -> Schema:
        """Return the JSON Schema of the whole numbers in range."""
        return {"type": "integer", "minimum": self.lowest, "maximum": self.highest}


@dataclass(frozen=True)
class Quantity(Kind, OneLine):
    """A number with a unit.

    Parameters
    ----------
    unit : str or None
        SI unit (degrees for angles) that plain numbers are in; ``""`` when dimensionless; None
        when only the user's own model knows, so that nothing can be converted.
    lowest, highest : float
        Inclusive limits.
    above_zero : bool
        Zero and negative values are faults.
    why : str
        Why nothing else is possible, as a sentence.
    """

    unit: str | None
    lowest: float = -math.inf
    highest: float = math.inf
    above_zero: bool = False
    why: str = ""

    def read(self, value: Any, place: Place) -> float | None:
        """Read a plain number or a quantity with a unit; the result is in `unit`."""
        number = self._number(value, place)
        if number is None:
            return None
        return self._checked(number, self._shown(value), partial(self._hint, value), place)

    def read_converted(self, number: float, place: Place) -> float | None:
        """Check a number that is in `unit` already, such as one of a column with a unit."""
        return self._checked(number, show(number), str, place)

    def _checked(
        self, number: float, shown: str, hint: Callable[[], str], place: Place
    ) -> float | None:
        if not math.isfinite(number):
            place.fault(messages.NOT_FINITE, given=number)
        elif not is_computable(number):
            place.fault(messages.NO_SUCH_SIZE, given=shown)
        elif self.above_zero and number <= 0:
            place.fault(messages.NOT_ABOVE_ZERO, given=shown)
        elif not self._accepts(number):
            why = f" {self.why}" if self.why else ""
            place.fault(
                messages.OUT_OF_LIMITS, given=shown, limits=self.limits(), why=why, hint=hint()
            )
        else:
            return number
        return None

    def _number(self, value: Any, place: Place) -> float | None:
        if isinstance(value, (int, float)) and not isinstance(value, bool):
            try:
                return float(value)
            except OverflowError:
                return math.inf
        if not isinstance(value, str):
            note_wrong_kind(value, place, self._words(), self._how_to_write())
            return None
        if self.unit is None:
            place.fault(messages.UNIT_OF_MODEL_UNKNOWN, given=show(value))
            return None
        try:
            return to_unit(value, self.unit)
        except UnitError as error:
            self._unreadable(error, place)
            return None

    def _unreadable(self, error: UnitError, place: Place) -> None:
        # An error of units knows no limits: its example may be outside of them.
        is_usual = error.remedy == how_to_write(self.unit or "")
        remedy = self._how_to_write() if is_usual else error.remedy
        place.refuse(Fault("", error.message, remedy))

    def _how_to_write(self) -> str:
        return "" if self.unit is None else how_to_write(self.unit, self._example())

    def _example(self) -> str:
        """Return the usual example of the unit, or a value within the limits."""
        unit = self.unit or ""
        usual = example_with(unit)
        if self._accepts(to_unit(usual, unit)):
            return usual
        within = (2 * self.lowest, self.highest / 2, self.lowest, self.highest)
        found = (f"{number:.2g}" for number in within if math.isfinite(number))
        return next((f"{one} {unit}".rstrip() for one in found if self._accepts(float(one))), usual)

    def _accepts(self, number: float) -> bool:
        return self.lowest <= number <= self.highest and not (self.above_zero and number <= 0)

    def _may_lack_unit(self, value: Any) -> bool:
        """Return whether a value may have been meant in another unit; of angles nobody does."""
        return self.unit not in (None, "", "deg") and not isinstance(value, str)

    def _shown(self, value: Any) -> str:
        """Return a value with the unit that it has as a plain number."""
        words = f", a plain number, which is in {self.unit}" if self._may_lack_unit(value) else ""
        return f"{show(value)}{words}"

    def _hint(self, value: Any) -> str:
        """Return how to write a plain number that was meant in another unit."""
        if not self.unit or not self._may_lack_unit(value):
            return ""
        return f' Give it with its unit, such as "{self._example()}".'

    def _words(self) -> str:
        return f"a number or a quantity in {self.unit}" if self.unit else "a number"

    def limits(self) -> str:
        """Return the possible values in words."""
        unit = f" {self.unit}" if self.unit else ""
        if self.above_zero:
            most = f", and at most {self.highest:g}" if math.isfinite(self.highest) else ""
            return f"above 0{most}{unit}"
        if math.isinf(self.highest):
            return f"at least {self.lowest:g}{unit}"
        return f"from {self.lowest:g} to {self.highest:g}{unit}"

    def schema(self) -> Schema:
        """Return the JSON Schema of a number, or of a text when the quantity has a unit."""
        number: Schema = {"type": "number"}
        if self.above_zero:
            number["exclusiveMinimum"] = 0
        if math.isfinite(self.lowest):
            number["minimum"] = self.lowest
        if math.isfinite(self.highest):
            number["maximum"] = self.highest
        return {"anyOf": [number, {"type": "string", "pattern": r"^\s*[+-]?[0-9.]"}]}


#: How to write a share.
_SHARE = 'Give a share above 0 and at most 100 %, such as "25 %".'


@dataclass(frozen=True)
class Share(Quantity):
    """A share, above zero and at most one: a percentage in quotes, or a plain number."""

    unit: str | None = ""
    highest: float = 1.0
    above_zero: bool = True

    def _checked(
        self,
        number: float,
        shown: str,
        hint: Callable[[], str],  # noqa: ARG002
        place: Place,
    ) -> float | None:
        if 0 < number <= self.highest:
            return number
        place.fault(messages.NO_SHARE, given=shown, remedy=_SHARE)
        return None

    def _unreadable(self, error: UnitError, place: Place) -> None:
        place.refuse(Fault("", error.message, _SHARE))


@dataclass(frozen=True)
class ListOf(Kind):
    """A list of values of one kind."""

    kind: Kind
    shortest: int = 1

    def read(self, value: Any, place: Place) -> tuple[Any, ...] | None:
        """Read all entries; None when one of them is faulty."""
        if not isinstance(value, list):
            note_wrong_kind(value, place, "a list", "Write it in square brackets: [...].")
            return None
        entries = tuple(self.kind.read(entry, place.at(i)) for i, entry in enumerate(value))
        if len(entries) < self.shortest:
            count = "1 entry" if len(entries) == 1 else f"{len(entries)} entries"
            place.fault(messages.TOO_FEW_ENTRIES, count=count, shortest=self.shortest)
            return None
        return None if None in entries else entries

    def schema(self) -> Schema:
        """Return the JSON Schema of the list."""
        return {"type": "array", "items": self.kind.schema(), "minItems": self.shortest}


@dataclass(frozen=True)
class OneOrMore(Kind):
    """A value, or a list of values of its kind."""

    kind: Kind

    def read(self, value: Any, place: Place) -> tuple[Any, ...] | None:
        """Read one or all entries; None when one of them is faulty."""
        if isinstance(value, list):
            return ListOf(self.kind).read(value, place)
        found = self.kind.read(value, place)
        return None if found is None else (found,)

    def schema(self) -> Schema:
        """Return the JSON Schema of a value or a list."""
        return {"anyOf": [self.kind.schema(), ListOf(self.kind).schema()]}
