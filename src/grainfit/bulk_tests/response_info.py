"""What is known of the responses of a bulk test before any run."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import ClassVar, Protocol

from grainfit.bulk_tests import messages
from grainfit.bulk_tests.recorded_trials import RecordedTrials
from grainfit.errors import Fault
from grainfit.formatting import value_with_unit
from grainfit.one_line import OneLine
from grainfit.options.kinds import Quantity

#: Share of the largest value of a measured curve that may be noise.
_NOISE = 0.05


@dataclass(frozen=True)
class MeasuredInfo:
    """Unit, symbol and description of a response of a bulk test.

    Parameters
    ----------
    unit : str
        SI unit, degrees for angles.
    symbol : str
        As in ``"ρ_b"``, what follows the first ``_`` being the index.
    description : str
        Name, colon, explanation.
    absent : str
        Why a valid run may be without it; empty if none may. A run that needs it has failed then.
    """

    unit: str
    symbol: str
    description: str
    absent: str = field(default="", kw_only=True)

    @property
    def words(self) -> str:
        """The description as the beginning of a sentence."""
        return self.description[:1].upper() + self.description[1:]


@dataclass(frozen=True)
class ResponseInfo(MeasuredInfo, OneLine):
    """A response of a bulk test that is one number.

    Parameters
    ----------
    unit, symbol, description : str
        As of a `MeasuredInfo`.
    example : str
        A target, as TOML.
    trials : RecordedTrials, optional
        Its scatter, and what a larger apparatus changes; None when that was not measured.
    lowest, highest : float
        Limits of what is physically possible.
    above_zero : bool
        Whether zero and negative values are impossible.
    why : str
        Why nothing else is possible, as a sentence.
    at_zero : str
        What a value of exactly 0 means, where it is easily taken for another one.
    """

    example: str
    trials: RecordedTrials | None = None
    lowest: float = -math.inf
    highest: float = math.inf
    above_zero: bool = True
    why: str = ""
    at_zero: str = ""

    @property
    def possible(self) -> Quantity:
        """Values that are physically possible."""
        return Quantity(self.unit, self.lowest, self.highest, self.above_zero, self.why)

    @property
    def limits(self) -> tuple[float | None, float | None]:
        """Smallest and largest value that is physically possible, zero included; None without."""
        lowest = max(self.lowest, 0.0) if self.above_zero else self.lowest
        low, high = (one if math.isfinite(one) else None for one in (lowest, self.highest))
        return low, high


@dataclass(frozen=True)
class CurveInfo(MeasuredInfo, OneLine):
    """A response of a bulk test over a coordinate.

    Parameters
    ----------
    unit, symbol, description : str
        Of the values, as of a `MeasuredInfo`.
    coordinate, coordinate_unit : str
        Name and SI unit of the coordinate.
    lowest, highest : float
        Limits of what is physically possible.
    rises : bool
        Whether a curve that is lower at its end than at its beginning is impossible.
    why : str
        Why nothing else is possible, and what such a curve may be, in sentences.
    """

    coordinate: str
    coordinate_unit: str
    lowest: float = -math.inf
    highest: float = math.inf
    rises: bool = False
    why: str = ""

    def impossible_point(self, values: Sequence[float]) -> tuple[int, Fault] | None:
        """Return the position of the first value that is physically impossible, and why.

        A little below its limit or the beginning of its curve, a value is noise of a measurement.
        """
        noise = _NOISE * max(map(abs, values))
        for position, value in enumerate(values):
            given = {"value": self._shown(value), "why": self.why}
            if value < self.lowest - noise:
                return position, messages.TOO_LOW.fault("", least=self._shown(self.lowest), **given)
            if value > self.highest:
                return position, messages.TOO_HIGH.fault(
                    "", most=self._shown(self.highest), **given
                )
        if not self.rises or values[-1] >= values[0] - noise:
            return None
        first, last = self._shown(values[0]), self._shown(values[-1])
        return len(values) - 1, messages.FALLS.fault("", first=first, last=last, why=self.why)

    def _shown(self, value: float) -> str:
        return value_with_unit(value, self.unit)


class _GivesResponses(Protocol):
    """A bulk test, or its class."""

    responses: ClassVar[Mapping[str, ResponseInfo]]
    curves: ClassVar[Mapping[str, CurveInfo]]


def absent_responses(test: _GivesResponses | type[_GivesResponses]) -> dict[str, str]:
    """Return the responses that a valid run of a test may be without, each with the reason."""
    known = {**test.responses, **test.curves}
    return {name: info.absent for name, info in known.items() if info.absent}
