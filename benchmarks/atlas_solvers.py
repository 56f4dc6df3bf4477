"""Differences of other solvers from the LAMMPS of the atlas, by rows that both made.

    python benchmarks/atlas_solvers.py

Prints for every response the number of such rows, the mean difference with its 95 % interval, the
spread from material to material, and in how many rows the response lies within the 95 % interval
that the other rows and the LAMMPS run foretell. The last line sums that up for each solver.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from scipy.stats import t

from atlas_rows import Pairs, pairs_of
from grainfit.atlas.differences import FEWEST_PAIRS, REFERENCE, difference, relative_differences
from grainfit.atlas.row import rows_in
from grainfit.atlas.shelf import SHIPPED, Atlas, rows_of
from grainfit.atlas.strata import strata
from grainfit.solvers.registry import DEM_PROGRAMS


def table(atlas: Atlas, solver: str) -> Iterator[str]:
    """Yield the lines of the table of a solver."""
    yield "| stratum | response | rows | difference, % | spread, % | rows within 95 % |"
    yield "|---" * 6 + "|"
    inside = of_all = 0
    for name in atlas.strata:
        surrogate, stratum = atlas.require(name), strata()[name]
        rows = rows_in(rows_of(SHIPPED, name, solver))
        for response in surrogate.models:
            pairs = pairs_of(stratum, surrogate, rows, response)
            if (count := len(pairs.own)) < FEWEST_PAIRS:
                continue
            found = _inside(pairs)
            inside, of_all = inside + found, of_all + count
            told = difference(*pairs)
            yield (
                f"| {name} | {response} | {count} | {100 * told.mean:+.1f} ± "
                f"{100 * _half_width(pairs):.1f} | {100 * told.spread:.1f} | {found} |"
            )
    yield f"\n{solver}: {inside} of {of_all} within their 95 % intervals."


def _half_width(pairs: Pairs) -> float:
    """Return half of the 95 % interval of the mean difference."""
    shares = relative_differences(pairs.own, pairs.reference)
    deviation = shares.std(ddof=1) / np.sqrt(len(shares))
    return float(t.ppf(0.975, len(shares) - 1) * deviation)


def _inside(pairs: Pairs) -> int:
    """Return how many rows the others foretell."""
    shares, found = relative_differences(pairs.own, pairs.reference), 0
    for index in range(len(shares)):
        told = difference(*(np.delete(one, index) for one in pairs))
        deviation = np.hypot(told.spread, np.sqrt(2) * pairs.scatter[index])
        limit = t.ppf(0.975, len(shares) - 2) * deviation
        found += abs(shares[index] - told.mean) <= limit
    return found


def main() -> None:
    """Print the table of every solver that made rows."""
    atlas = Atlas()
    for solver in DEM_PROGRAMS:
        if solver != REFERENCE and any(rows_of(SHIPPED, n, solver).exists() for n in atlas.strata):
            print("\n".join(table(atlas, solver)))


if __name__ == "__main__":
    main()
