"""Correlations of the targets of one test in the calibration file."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from grainfit.options.kinds import Kind, ListOf, Quantity, Schema, Text, note_wrong_kind
from grainfit.options.places import Place
from grainfit.options.tables import Key
from grainfit.problem.correlations import Correlation, correlation_faults

#: Its limits, which are no coefficients, are those of every interface: see `correlation_faults`.
_COEFFICIENT = Quantity("")


@dataclass(frozen=True)
class CorrelatedPair(Kind):
    """Two responses and the correlation of the errors of their measured values."""

    def read(self, value: Any, place: Place) -> Correlation | None:
        """Read two names and a coefficient."""
        if not isinstance(value, list) or len(value) != 3:
            remedy = 'Write ["first", "second", 0.8].'
            note_wrong_kind(value, place, "two responses and a coefficient", remedy)
            return None
        first, second = (Text().read(name, place.at(i)) for i, name in enumerate(value[:2]))
        coefficient = _COEFFICIENT.read(value[2], place.at(2))
        if first is None or second is None or coefficient is None:
            return None
        return first, second, coefficient

    def schema(self) -> Schema:
        """Return the JSON Schema of a pair."""
        coefficient = {**_COEFFICIENT.schema(), "exclusiveMinimum": -1, "exclusiveMaximum": 1}
        entries = [Text().schema(), Text().schema(), coefficient]
        return {"type": "array", "prefixItems": entries, "minItems": 3, "maxItems": 3}


CORRELATIONS = Key(
    "correlations",
    ListOf(CorrelatedPair()),
    "Correlations of the errors of the measured values of this test: pairs of responses, each with "
    "its coefficient between -1 and 1.",
    example='[["bulk_density", "angle_of_repose", 0.5]]',
)


def note_bad_correlations(
    correlations: Sequence[Correlation], responses: Sequence[str], place: Place
) -> bool:
    """Return whether correlations are not those of the responses, and note why."""
    faults = correlation_faults(responses, correlations, "")
    for fault in faults:
        index = fault.key.strip("[]")
        (place.at(int(index)) if index else place).fault(fault.message, fault.remedy)
    return bool(faults)
