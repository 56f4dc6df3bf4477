"""Where a calibration comes from: kept with its runs, so that a report can say how to repeat it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any


@dataclass(frozen=True)
class Provenance:
    """The file that a calibration was started from, and what it says of the material.

    Nothing of it changes what is simulated.

    Parameters
    ----------
    file, text : str
        Name of the calibration file, without its folder, and what stood in it.
    fixed : mapping of str to float
        Parameters that are not free, by name, in SI units.
    units : mapping of str to str
        SI units of parameters, where they have one.
    """

    file: str = ""
    text: str = ""
    fixed: Mapping[str, float] = field(default_factory=dict)
    units: Mapping[str, str] = field(default_factory=dict)

    @classmethod
    def from_json(cls, data: Mapping[str, Any]) -> Provenance:
        """Read what was kept; what an older version did not keep is empty."""
        return cls(
            file=str(data.get("file", "")),
            text=str(data.get("text", "")),
            fixed={str(name): float(value) for name, value in data.get("fixed", {}).items()},
            units={str(name): str(unit) for name, unit in data.get("units", {}).items()},
        )
