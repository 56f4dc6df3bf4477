"""Threshold of a search that looks after every run: how much doubt may it stop with?

A search stops when its answer looks good, and looks after every run, so it looks better than it is.
Here the truth lies up to a quarter of a tolerance beyond the edge, and runs follow one another at
the answer. The threshold is such that after all looks together 5 % of such answers pass. It is
given as a share of the accepted doubt, the smallest over the scatter. `grainfit.verdict.looks` has
the first row. With ``--beyond 0`` the truth lies exactly on the edge.

    python benchmarks/stopping.py [--cases 100000] [--beyond 0.25]
"""

from __future__ import annotations

import argparse

import numpy as np
from numpy.typing import NDArray
from scipy.special import stdtr

from grainfit.verdict.looks import LOOKS

#: Scatter in tolerances; larger ones pass less often.
SCATTERS = (0.2, 0.3, 0.5, 0.7, 1.0, 1.5)
ACCEPTED = 0.05
#: Information at the first look, in runs at the answer, with its degrees of freedom.
STARTS = ((2, 3), (2, 6), (4, 8))


def smallest_doubts(
    scatter: float, start: tuple[int, int], looks: int, cases: int, beyond: float
) -> NDArray[np.float64]:
    """Smallest doubt of each case after 0 to so many further looks, shape (looks + 1, cases)."""
    random = np.random.default_rng(39)
    runs, freedom = start
    truth = 1.0 + beyond * random.random(cases)
    mean = truth + scatter * random.standard_normal(cases) / np.sqrt(runs)
    squares = scatter**2 * random.chisquare(freedom, cases)
    found = []
    for _ in range(looks + 1):
        error = np.sqrt(squares / freedom / runs)
        inside = stdtr(freedom, (1.0 - mean) / error) - stdtr(freedom, (-1.0 - mean) / error)
        found.append(1.0 - inside)
        value = truth + scatter * random.standard_normal(cases)
        squares += (value - mean) ** 2 * runs / (runs + 1)
        mean = (runs * mean + value) / (runs + 1)
        runs, freedom = runs + 1, freedom + 1
    return np.minimum.accumulate(found)


def shares(start: tuple[int, int], cases: int, beyond: float) -> list[float]:
    """Shares of the accepted doubt after each of `LOOKS`."""
    found = [smallest_doubts(scatter, start, max(LOOKS), cases, beyond) for scatter in SCATTERS]
    quantiles = np.quantile(found, ACCEPTED, axis=2).min(axis=0)
    return [float(min(quantiles[looks] / ACCEPTED, 1.0)) for looks in LOOKS]


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--cases", type=int, default=100_000)
    parser.add_argument("--beyond", type=float, default=0.25, help="farthest truth, in tolerances")
    given = parser.parse_args()
    print("| runs at the first look, degrees of freedom | " + " | ".join(map(str, LOOKS)) + " |")
    print("|---" * (len(LOOKS) + 1) + "|")
    for start in STARTS:
        found = shares(start, given.cases, given.beyond)
        print(f"| {start[0]}, {start[1]} | " + " | ".join(f"{one:.2f}" for one in found) + " |")


if __name__ == "__main__":
    main()
