"""Notes on tests of a calibration file that simulate the same and differ in their evaluation."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from itertools import combinations
from typing import Any

from grainfit.calibration_file.content import TestSpecification

#: Keys of a test that leave its simulation as it is.
_EVALUATION = frozenset({"evaluate", "responses", "measure", "timeout"})


def same_simulation_notes(tests: Sequence[TestSpecification]) -> Iterator[str]:
    """Yield a note for each pair of tests that would simulate the same twice.

    Parameters
    ----------
    tests : sequence of TestSpecification
        The tests of the file.
    """
    for one, other in combinations(tests, 2):
        if one.type == other.type and _simulation(one) == _simulation(other):
            yield (
                f"Tests {one.name} and {other.name} differ at most in their evaluation, but each "
                "simulation is made for one of them only. Make them one [[test]] with the "
                f"targets of both{_remedy(one)}."
            )


def _simulation(test: TestSpecification) -> Mapping[str, Any]:
    return {key: value for key, value in test.options.items() if key not in _EVALUATION}


def _remedy(test: TestSpecification) -> str:
    for key in ("evaluate", "measure"):
        if key in test.options:
            return f": let the function in {key} return all their responses"
    return ""
