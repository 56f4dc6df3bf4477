"""What the checks of a bulk test see: the test, and the calibration that it is part of."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass, field
from typing import Generic, TypeVar

_Test = TypeVar("_Test", covariant=True)


@dataclass(frozen=True)
class CheckedTest(Generic[_Test]):
    """A bulk test of a calibration before its first run: the context of its `checks`.

    A check yields keys of the table of the test, such as ``"plate_radius"``.

    Parameters
    ----------
    test : BulkTest
        The test.
    lowest, highest : mapping of str to float
        Material parameters that are known, at the lower and upper ends of the intervals.
    targets : mapping of str to float or None
        Measured values by response, None for a curve.
    walls : mapping of str to str
        Walls with a name, by the parts of the test that are made of them.
    of_instrument : collection of str
        Options that have the values of the instrument that the file names.
    """

    test: _Test
    lowest: Mapping[str, float]
    highest: Mapping[str, float]
    targets: Mapping[str, float | None]
    walls: Mapping[str, str] = field(default_factory=dict)
    of_instrument: Collection[str] = ()
