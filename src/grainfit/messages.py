"""Texts for the user, each with a name: the catalogues of the rooms are modules ``messages``.

A catalogue keeps every text of its room in one place, so that texts read alike, and a test asks
for a message by its name. `tests/test_messages.py` compares the fields of every text with what the
code fills in.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from string import Formatter
from typing import Any

from grainfit.errors import Fault


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
    """

    text: str
    remedy: str = ""

    def __post_init__(self) -> None:
        assert self.text.strip(), "a message without text"

    def __call__(self, **values: Any) -> str:
        """Return the text with its remedy, filled in."""
        return f"{self.text} {self.remedy}".rstrip().format(**values)

    def fault(self, key: str, /, **values: Any) -> Fault:
        """Return the fault of a key of the user's input, ``""`` where it has none."""
        return Fault(key, self.text.format(**values), self.remedy.format(**values))

    @property
    def fields(self) -> frozenset[str]:
        """Names of all fields."""
        parts = Formatter().parse(f"{self.text} {self.remedy}")
        return frozenset(re.split(r"[.\[]", name)[0] for _, name, _, _ in parts if name)

    @property
    def pattern(self) -> str:
        """Regular expression that finds the text without its remedy, whatever fills it in."""
        parts = Formatter().parse(self.text)
        found = (_spaced(text) + ("" if name is None else "(?s:.*?)") for text, name, _, _ in parts)
        return "".join(found)

    def is_in(self, output: str) -> bool:
        """Return whether a text has this message, be its lines broken or not."""
        return re.search(self.pattern, output) is not None


def _spaced(literal: str) -> str:
    """Return a regular expression of a text that any white space may break."""
    return re.sub(r"(?:\\?\s)+", r"\\s+", re.escape(literal))
