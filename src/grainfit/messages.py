"""Texts for the user, each with a name: the catalogues of the rooms are modules ``messages``.

A catalogue keeps every text of its room in one place, so that texts read alike, and a test asks
for a message by its name. `tests/test_messages.py` compares the fields of every text with what the
code fills in.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from string import Formatter
from typing import Any

from grainfit.errors import Fault

#: Regular expressions of what fills in a field, and of white space.
_ANYTHING, _SPACE = r"(?s:.*?)", r"\s+"
_FULL_STOP = re.compile(r"\.(?=\s|$)")
_TWO_ENDS = re.compile(r"[.?!]\.")


@dataclass(frozen=True)
class Message:
    r"""Text for the user with fields to fill in, and what to do about it.

    Parameters
    ----------
    text : str
        Template in the syntax of `str.format`, its fields named.
    remedy : str, optional
        What to do: a template, too.

    Examples
    --------
    >>> TOO_LARGE = Message("is {value:g} mm.", "Give {limit:g} mm at most.")
    >>> TOO_LARGE(value=5, limit=3)
    'is 5 mm. Give 3 mm at most.'
    >>> str(TOO_LARGE.fault("radius", value=5, limit=3))
    'radius: is 5 mm. Give 3 mm at most.'
    >>> TOO_LARGE.is_in("radius: is 5 mm. Give\n    3 mm at most.")
    True
    >>> TOO_LARGE.is_in("radius: is 5 mm. Give 3 mm at most.", limit=4)
    False
    >>> Message("cannot be read: {why}.")(why="Is it empty?")
    'cannot be read: Is it empty?'
    """

    text: str
    remedy: str = ""

    def __post_init__(self) -> None:
        assert self.text.strip(), "a message without text"

    def __call__(self, **values: Any) -> str:
        """Return the text with its remedy, filled in."""
        return _filled(f"{self.text} {self.remedy}".rstrip(), values)

    def fault(self, key: str, /, **values: Any) -> Fault:
        """Return the fault of a key of the user's input, ``""`` where it has none."""
        return Fault(key, _filled(self.text, values), _filled(self.remedy, values))

    @property
    def fields(self) -> frozenset[str]:
        """Names of all fields."""
        return _fields(f"{self.text} {self.remedy}")

    @property
    def pattern(self) -> str:
        """Regular expression that finds the text without its remedy, whatever fills it in."""
        return self.matching()

    def matching(self, **values: Any) -> str:
        """Return a regular expression of the text with these values, whatever fills in the rest.

        The remedy is looked for as well where a value fills in the remedy alone.
        """
        assert values.keys() <= self.fields, values.keys() - self.fields
        is_of_text = values.keys() <= _fields(self.text)
        template = self.text if is_of_text else f"{self.text} {self.remedy}"
        found = shown = ""
        for text, name, form, conversion in Formatter().parse(template):
            found += _spaced(_behind(shown, text))
            shown = ""
            if name is not None and _root(name) in values:
                shown = _shown(name, form, conversion, values)
                found += _spaced(shown)
            elif name is not None:
                found += _ANYTHING
        # A field at the end may be empty, and the space before it is gone then.
        found = found.removesuffix(_ANYTHING).removesuffix(_SPACE)
        assert found, "a text of fields alone is in every output"
        return found

    def is_in(self, output: str, **values: Any) -> bool:
        """Return whether a text has this message with these values, be its lines broken or not."""
        return re.search(self.matching(**values), output) is not None


def _filled(template: str, values: Mapping[str, Any]) -> str:
    """Fill in a template; after a value that ends a sentence there is no full stop."""
    found = template.format(**values)
    if _TWO_ENDS.search(found) is None:
        return found
    found = shown = ""
    for text, name, form, conversion in Formatter().parse(template):
        found += _behind(shown, text)
        shown = "" if name is None else _shown(name, form, conversion, values)
        found += shown
    return found


def _shown(name: str, form: str | None, conversion: str | None, values: Mapping[str, Any]) -> str:
    field = f"{name}!{conversion}" if conversion else name
    return f"{{{field}:{form}}}".format(**values)


def _behind(shown: str, text: str) -> str:
    """Return the text behind a value, without its full stop where the value ends a sentence."""
    return text[1:] if shown.endswith((".", "?", "!")) and _FULL_STOP.match(text) else text


def _fields(template: str) -> frozenset[str]:
    return frozenset(_root(name) for _, name, _, _ in Formatter().parse(template) if name)


def _root(name: str) -> str:
    return re.split(r"[.\[]", name)[0]


def _spaced(literal: str) -> str:
    """Return a regular expression of a text that any white space may break."""
    return re.sub(r"(?:\\?\s)+", lambda _: _SPACE, re.escape(literal))
