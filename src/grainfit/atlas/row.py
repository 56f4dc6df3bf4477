"""Rows of the atlas: one simulated run of a bulk test each, in natural units."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

#: Rows from this number on, up to twice it, repeat those before with other seeds.
REPEATS = 2048


@dataclass(frozen=True)
class Row:
    """One run of a bulk test in natural units: length d, time sqrt(d/g), mass rho d^3.

    Parameters
    ----------
    number : int
        Of the point of the design; of a repeat, `REPEATS` more.
    seed : int
        Of the packing.
    inputs : mapping of str to float
        Dimensionless numbers by name.
    test : str
        Hash of the simulated test: another one today has other dimensions at these inputs.
    responses : mapping of str to tuple of float
        Value and standard error by response, in natural units, angles in degrees; a response that
        could not be measured is not in it.
    why : str
        Why responses are missing; empty where none is.
    seconds : float
        Processor time of the run, s.
    program : str
        Solver and version.
    """

    number: int
    seed: int
    inputs: Mapping[str, float]
    test: str
    responses: Mapping[str, tuple[float, float]]
    why: str
    seconds: float
    program: str

    @property
    def point(self) -> int:
        """Number of the point of the design."""
        return self.number - REPEATS if self.is_repeat else self.number

    @property
    def is_repeat(self) -> bool:
        """Whether it repeats another row with another seed."""
        return REPEATS <= self.number < 2 * REPEATS

    def to_text(self) -> str:
        """Return the row as a line of JSON."""
        return json.dumps(asdict(self), separators=(",", ":"))

    @classmethod
    def from_text(cls, text: str) -> Row:
        """Return the row of `to_text`; errors are those of `from_plain`."""
        return cls.from_plain(json.loads(text))

    @classmethod
    def from_plain(cls, plain: Mapping[str, Any]) -> Row:
        """Return the row of parsed JSON.

        Raises
        ------
        KeyError, TypeError, ValueError
            It is no row.
        """
        responses = {n: (float(v), float(e)) for n, (v, e) in plain["responses"].items()}
        inputs = {name: float(value) for name, value in plain["inputs"].items()}
        return cls(**{**plain, "inputs": inputs, "responses": responses})


def rows_in(path: Path) -> list[Row]:
    """Return the rows of a file in the order of the design; a line that was cut off is no row."""
    lines = path.read_text(encoding="utf-8").splitlines() if path.exists() else []
    found = {}
    for line in lines:
        try:
            row = Row.from_text(line)
        except (KeyError, TypeError, ValueError, AttributeError):
            continue
        found[row.number] = row
    return [found[number] for number in sorted(found)]
