"""Sentinels: rows that a new release of LAMMPS makes again before rows of it are admitted.

A release that gives the same within the errors of the rows is as good as the one before.
"""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import chain, zip_longest
from typing import Any

import numpy as np
from scipy.stats import norm

from grainfit.atlas.row import Row
from grainfit.atlas.shelf import Atlas
from grainfit.atlas.strata import strata
from grainfit.atlas.surrogate import points_of

#: Number of sentinels, and the chance that a release that changes nothing is refused.
COUNT, ERROR = 20, 0.01


@dataclass(frozen=True)
class Comparison:
    """Rows that a release made again, beside the rows of the atlas.

    Parameters
    ----------
    program : str
        Solver and version that made them again.
    runs : int
        Their number.
    deviations : mapping of str to float
        Differences over the standard deviation that two runs differ by, by test, row and response.
    missing : tuple of str
        Responses that rows of the atlas have, and those of the release do not.
    """

    program: str
    runs: int
    deviations: Mapping[str, float]
    missing: tuple[str, ...]

    @property
    def largest(self) -> float:
        """Largest deviation of a response."""
        return max(map(abs, self.deviations.values()), default=math.inf)

    @property
    def limit(self) -> float:
        """Largest deviation that a release that changes nothing has, but for half of `ERROR`."""
        return _limit(len(self.deviations))

    @property
    def shifts(self) -> dict[str, float]:
        """Mean deviations by test and response, in their standard errors."""
        found = defaultdict(list)
        for name, deviation in self.deviations.items():
            test, _, response = name.split(" ")
            found[f"{test}.{response}"].append(deviation)
        return {name: sum(own) / math.sqrt(len(own)) for name, own in found.items()}

    @property
    def agrees(self) -> bool:
        """Whether no response is missing, deviates, or is shifted in the mean of its runs."""
        shifts = self.shifts
        return (
            self.runs >= COUNT
            and not self.missing
            and self.largest <= self.limit
            and max(map(abs, shifts.values())) <= _limit(len(shifts))
        )

    def to_plain(self) -> dict[str, Any]:
        """Return the outcome as JSON, for `atlas_rows.record`."""
        return {
            "program": self.program,
            "agrees": self.agrees,
            "runs": self.runs,
            "largest": round(self.largest, 3),
            "limit": round(self.limit, 3),
            "shifts": {name: round(one, 3) for name, one in self.shifts.items()},
            "missing": list(self.missing),
        }


def _limit(count: int) -> float:
    """Return the limit of so many normal deviations: one is beyond it with half of `ERROR`."""
    return float(norm.isf(ERROR / 4 / max(count, 1)))


def sentinels(atlas: Atlas) -> list[tuple[str, Row]]:
    """Return the rows that a release makes again: the cheapest whole ones of all strata in turn.

    Another apparatus of a test has nothing of its own in the program; some strata have two rows.
    """
    cheapest = []
    for name in sorted(one for one in atlas.strata if not strata()[one].varied.name):
        surrogate = atlas.of_stratum(name)
        rows = [row for row in surrogate.rows if not row.why] if surrogate else []
        cheapest.append([(name, row) for row in sorted(rows, key=lambda r: (r.seconds, r.number))])
    in_turn = chain.from_iterable(zip_longest(*cheapest))
    return [one for one in in_turn if one is not None][:COUNT]


def compare(atlas: Atlas, again: Sequence[tuple[str, Row]]) -> Comparison:
    """Compare rows that a release made again with those of the atlas.

    Two runs with another rounding differ as two packings do: by the root of two times the scatter
    of a run.

    Parameters
    ----------
    atlas : Atlas
        The atlas.
    again : sequence of (str, Row)
        Name of the stratum, and the row made again; at least one.
    """
    deviations: dict[str, float] = {}
    missing = []
    for name, row in again:
        stratum, surrogate = strata()[name], atlas.of_stratum(name)
        if surrogate is None:
            continue
        [known] = [one for one in surrogate.rows if one.number == row.number]
        at = points_of([known], stratum.ranges)
        for response, model in surrogate.models.items():
            if response not in known.responses:
                continue
            key = f"{name} {row.number} {response}"
            if response not in row.responses:
                missing.append(key)
                continue
            proportion = stratum.proportion(response, known.inputs)
            scatter = float(model.scatter(at)[0]) * proportion
            values = np.array([row.responses[response], known.responses[response]])
            error = max(math.sqrt(2) * scatter, math.hypot(*values[:, 1]))
            deviations[key] = float(values[0, 0] - values[1, 0]) / error
    [program] = {row.program for _, row in again}
    return Comparison(program, len(again), deviations, tuple(missing))
