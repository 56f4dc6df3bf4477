"""Rows of calibrations side by side: parameters, responses, curves."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import combinations
from typing import Literal

from grainfit.formatting import counted, ends, interval, number, unit_for_people, with_unit
from grainfit.result import CurveResult

#: Of a calibration that does not have a row.
ABSENT = "–"


@dataclass(frozen=True)
class ComparedValue:
    """A value of one calibration: of a parameter, SI, or of a response, in its unit.

    A yield locus without an expected line has the measured value and no interval.

    Parameters
    ----------
    value : float
        The value at the answer; of a response, the expected one.
    low, high : float, optional
        Its 95 % interval, where it has one.
    unit : str
        As in the calibration file.
    is_fixed : bool
        Whether it is a parameter that was not free.
    measured, tolerance : float, optional
        Target of a response; of a yield locus, the measured value and half of its 95 % interval.
    verdict : str
        Of a response; of a parameter, how well it is determined.
    """

    value: float
    low: float | None = None
    high: float | None = None
    unit: str = ""
    is_fixed: bool = False
    measured: float | None = None
    tolerance: float | None = None
    verdict: str = ""

    @property
    def shown(self) -> str:
        """The value with its interval or its target in brackets, for people."""
        unit = unit_for_people(self.unit)
        if self.is_fixed:
            return f"{with_unit(number(self.value), unit)} (fixed)"
        if self.measured is not None and self.tolerance is not None:
            expected = ABSENT
            if self.high is not None:
                expected = with_unit(interval(self.value, self.high - self.value), unit)
            return f"{expected} ({with_unit(interval(self.measured, self.tolerance), unit)})"
        shown = with_unit(number(self.value), unit)
        if self.low is None or self.high is None:
            return shown
        return f"{shown} ({ends(self.low, self.high)})"


@dataclass(frozen=True)
class ComparedRow:
    """A parameter or a response in all calibrations; None where one does not have it."""

    name: str
    values: tuple[ComparedValue | None, ...]

    @property
    def verdict(self) -> Literal["agree", "differ", ""]:
        """Whether all pairs of intervals overlap; "" where fewer than two have one."""
        found = [(one.low, one.high) for one in self.values if one is not None]
        known = [(low, high) for low, high in found if low is not None and high is not None]
        if len(known) < 2:
            return ""
        apart = any(a[1] < b[0] or b[1] < a[0] for a, b in combinations(known, 2))
        return "differ" if apart else "agree"

    @property
    def shown(self) -> tuple[str, ...]:
        """The row of a table."""
        texts = (ABSENT if one is None else one.shown for one in self.values)
        return (self.name, *texts, self.verdict)


@dataclass(frozen=True)
class ComparedResponse(ComparedRow):
    """A response, or a number of a yield locus, in all calibrations.

    Parameters
    ----------
    test, response : str
        The test, by its type, or by its name where a calibration has several of the type; and the
        response without it. ``name`` has both, unless all rows are of one test.
    """

    test: str
    response: str


@dataclass(frozen=True)
class ComparedCurve:
    """How a curve of one calibration follows the measured one.

    Parameters
    ----------
    deviation : float
        Root mean square deviation of the expected curve, in standard uncertainties.
    points : int
        Number of measured points.
    probability : float
        Probability that it is within its tolerance.
    verdict : str
        As of a response.
    """

    deviation: float
    points: int
    probability: float
    verdict: str

    @classmethod
    def of(cls, found: CurveResult) -> ComparedCurve:
        """Return what is compared of a curve."""
        return cls(found.deviation, len(found.measured), found.probability, found.verdict)

    @property
    def shown(self) -> str:
        """Deviation and verdict, for people."""
        points = counted(self.points, "point")
        return f"{number(self.deviation, 2)} σ off {points}, {self.verdict}"


@dataclass(frozen=True)
class ComparedCurves:
    """A curve in all calibrations, as `ComparedResponse`; None where one does not have it."""

    name: str
    values: tuple[ComparedCurve | None, ...]
    test: str
    response: str

    @property
    def shown(self) -> tuple[str, ...]:
        """The row of a table."""
        return (self.name, *(ABSENT if one is None else one.shown for one in self.values))
