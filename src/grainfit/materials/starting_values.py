"""Starting values of parameters, each with its source, as a calibration file takes them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True)
class StartingValue:
    """Value of one parameter, and its origin.

    Parameters
    ----------
    value : object
        As in a calibration file: a number, a text, or a table with ``min`` and ``max``.
    source : str
        Author, year and journal, or that there is none.
    """

    value: Any
    source: str

    @property
    def is_free(self) -> bool:
        """Whether it is an interval."""
        return isinstance(self.value, dict) and "min" in self.value

    @property
    def toml(self) -> str:
        """The value as TOML."""
        return _toml(self.value)


#: Parameters by section and key of the calibration file.
Sections = Mapping[str, Mapping[str, StartingValue]]


def _toml(value: Any) -> str:
    if isinstance(value, dict):
        return f"{{ {', '.join(f'{key} = {_toml(entry)}' for key, entry in value.items())} }}"
    if isinstance(value, list):
        return f"[{', '.join(map(_toml, value))}]"
    return f'"{value}"' if isinstance(value, str) else repr(value)
