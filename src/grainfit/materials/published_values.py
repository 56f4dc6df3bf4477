"""Published values of materials: what a public text says, with its spread and where it stands."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from grainfit.formatting import unit_for_people, with_unit
from grainfit.units import to_unit

#: Quantities that may be published: unit, and name in words.
QUANTITIES: Mapping[str, tuple[str, str]] = {
    "diameter": ("mm", "diameter"),
    "density": ("kg/m^3", "density of the solid"),
    "bulk_density": ("kg/m^3", "bulk density"),
    "angle_of_repose": ("deg", "angle of repose"),
    "internal_friction_angle": ("deg", "angle of internal friction"),
    "sliding_friction": ("", "sliding friction between particles, in a DEM model"),
    "rolling_friction": ("", "rolling friction between particles, in a DEM model"),
    "restitution": ("", "coefficient of restitution"),
    "wall_friction": ("", "sliding friction on a wall of metal"),
}


@dataclass(frozen=True)
class PublishedValue:
    """A published value, or the range that a text gives.

    Parameters
    ----------
    low : float or None
        Lower end, in `unit`; None where a text has the upper end alone.
    high : float
        Upper end, the same as `low` where a text has one number.
    unit : str
        That of its quantity in `QUANTITIES`.
    source : str
        Author or title, year, journal or address, and place in it.
    text : str
        Words of the source, in short.
    """

    low: float | None
    high: float
    unit: str
    source: str
    text: str

    @property
    def middle(self) -> float:
        """Middle of the range; half of an upper end that stands alone."""
        return ((self.low or 0.0) + self.high) / 2

    @property
    def words(self) -> str:
        """The range with its unit, as calibration files have it."""
        return f"{self._range} {self.unit}".rstrip()

    @property
    def shown(self) -> str:
        """The range with its unit as readers expect it."""
        return with_unit(self._range, unit_for_people(self.unit))

    @property
    def _range(self) -> str:
        if self.low is None:
            return f"at most {self.high:.4g}"
        return f"{self.low:.4g}" if self.low == self.high else f"{self.low:.4g} to {self.high:.4g}"


def read_published(tables: Mapping[str, Any]) -> dict[str, PublishedValue]:
    """Return published values by quantity, in the order of `QUANTITIES`.

    Parameters
    ----------
    tables : mapping of str to object
        By quantity: ``value`` (a number or text, or a table with ``min`` and ``max``, or with
        ``max``), ``source`` and ``text``.
    """
    return {name: _read(tables[name], QUANTITIES[name][0]) for name in QUANTITIES if name in tables}


def _read(entry: Mapping[str, Any], unit: str) -> PublishedValue:
    value = entry["value"]
    low, high = (value.get("min"), value["max"]) if isinstance(value, dict) else (value, value)
    ends = [None if end is None else _number(end, unit) for end in (low, high)]
    return PublishedValue(ends[0], float(ends[1] or 0), unit, entry["source"], entry["text"])


def _number(value: object, unit: str) -> float:
    return to_unit(value, unit) if isinstance(value, str) else float(str(value))
