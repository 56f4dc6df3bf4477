"""Advice against the trials: which pairs of tests tell sliding from rolling friction.

Every bulk test is simulated at the same corners about one material (sliding friction 0.5, rolling
friction 0.2). From the slopes and the scatter, with the usual accuracies of a laboratory, follow
the standard deviations of both frictions for a heap alone and beside each other test, with the
particle density free and known. Runs are kept in the folder ``--kept``: stop the command and start
it again.

    python benchmarks/advice.py --kept advice.runs [--tests heap draw_down ...] [--seeds 3]
        [--workers 2] [--max-minutes 60]
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations
from pathlib import Path

import numpy as np

from grainfit.bulk_tests.accuracy import Accuracy, usual_accuracy
from grainfit.bulk_tests.parameter_names import (
    DENSITY,
    MODULUS,
    RESTITUTION,
    ROLLING,
    SLIDING,
    WALL_SLIDING,
)
from grainfit.bulk_tests.registry import bulk_tests
from grainfit.bulk_tests.response_info import ResponseInfo
from grainfit.problem import Parameter
from grainfit.solvers.base import Solver
from grainfit.solvers.dem.lammps.program import Lammps
from grainfit.testing.materials import ROUGH_PLATE, ROUGH_SPHERES
from grainfit.which_test.candidate import Candidate
from grainfit.which_test.knowledge import Knowledge
from grainfit.which_test.simulation import Simulation, candidates_from_runs
from grainfit.which_test.slopes import Cloud, corners

#: The material of the trials: value, factor of the corners, standard deviation of the logarithm
#: before any test.
PARAMETERS = {
    DENSITY: (2100.0, 1.3, 1.0),
    SLIDING: (0.5, 1.5, 1.0),
    ROLLING: (0.2, 2.0, 1.5),
    RESTITUTION: (0.6, 1.25, 0.17),
    WALL_SLIDING: (0.4, 1.5, 0.03),
}
#: Compression needs E / stress >= 1000; the others are cheap with the paper's modulus.
MODULI = {"compression": 10e6}
#: Responses of a heap that the trials did not have.
LEFT_OUT = ("base_radius", "heap_height")
DENSITY_KNOWN = 0.005
BESIDE = "heap"


def solver(name: str) -> Solver:
    """Return the test on LAMMPS, with the modulus that it needs."""
    fixed = {n: v for n, v in ROUGH_SPHERES.items() if n not in PARAMETERS}
    fixed[MODULUS] = MODULI.get(name, ROUGH_SPHERES[MODULUS])
    return Lammps(
        bulk_tests()[name](diameter="10 mm", **(ROUGH_PLATE if name == "heap" else {})), fixed
    )


def simulated(names: Sequence[str], simulation: Simulation) -> list[Candidate]:
    """Return the tests with their slopes, from new and known runs."""
    free = [
        Parameter(n, value / factor, value * factor, "log")
        for n, (value, factor, _) in PARAMETERS.items()
    ]
    positions = np.vstack([np.zeros(len(free)), corners(len(free))]) / 2 + 0.5
    points = [
        {p.name: p.from_unit(float(x)) for p, x in zip(free, position, strict=True)}
        for position in positions
    ]
    values = np.array([list(point.values()) for point in points])
    solvers = {name: solver(name) for name in names}
    evaluations = simulation.run(solvers, points)
    cloud = Cloud.of(free, values)
    found, failed = candidates_from_runs(solvers, cloud, points, evaluations, accuracy)
    for name, why in failed.items():
        print(f"{name}: {why}", file=sys.stderr)
    return found


def accuracy(test: str, name: str, info: ResponseInfo) -> Accuracy | None:
    """Return the usual accuracy; None for responses that the trials did not have."""
    return None if test == "heap" and name in LEFT_OUT else usual_accuracy(name, info.unit)


def before(density: float) -> Knowledge:
    """Return what is known before any test, given that of the particle density."""
    known = {name: deviation for name, (_, _, deviation) in PARAMETERS.items()} | {DENSITY: density}
    return Knowledge(tuple(known), np.diag([d**2 for d in known.values()]))


@dataclass(frozen=True)
class Deviations:
    """Standard deviations of both frictions in percent, for a combination of tests."""

    tests: tuple[str, ...]
    free: str
    known: str


def deviations(tests: Sequence[Candidate]) -> Deviations:
    """Return those with the particle density free, and known."""
    seen = [r for test in tests for r in test.responses]
    errors = np.diag([r.variance() for r in seen])
    cells = []
    for density in (PARAMETERS[DENSITY][2], DENSITY_KNOWN):
        then = before(density).after([r.slopes for r in seen], errors)
        cells.append(" / ".join(f"{100 * then.deviation(n):.0f}" for n in (SLIDING, ROLLING)))
    return Deviations(tuple(test.name for test in tests), *cells)


def table(tests: Sequence[Candidate]) -> str:
    """Return slopes and standard deviations as tables in Markdown."""
    slopes = [
        f"| {r.name} | {r.value:.4g} | {100 * r.scatter:.1f} % | "
        + " | ".join(f"{r.slopes[name]:+.2f}" for name in PARAMETERS)
        + " |"
        for test in tests
        for r in test.responses
    ]
    alone = [(test,) for test in tests]
    pairs = [pair for pair in combinations(tests, 2) if BESIDE in {t.name for t in pair}]
    rows = [deviations(chosen) for chosen in [*alone, *pairs]]
    frictions = [f"| {' + '.join(row.tests)} | {row.known} | {row.free} |" for row in rows]
    return "\n".join(
        [
            f"| response | mean | from run to run | {' | '.join(PARAMETERS)} |",
            "|---|" + "---|" * (2 + len(PARAMETERS)),
            *slopes,
            "",
            "| tests | sliding / rolling (%), density known to 0.5 % | density free |",
            "|---|---|---|",
            *frictions,
        ]
    )


def main() -> None:
    """Simulate, and print the tables."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--kept", type=Path, required=True)
    parser.add_argument("--tests", nargs="+", choices=bulk_tests(), default=list(bulk_tests()))
    parser.add_argument("--seeds", type=int, default=3)
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--max-minutes", type=float)
    options = parser.parse_args()
    simulation = Simulation(
        options.kept,
        options.workers,
        options.seeds,
        None if options.max_minutes is None else 60 * options.max_minutes,
        on_start=lambda work: print(work, file=sys.stderr),
        on_progress=lambda done, count: print(f"{done} of {count} sets", file=sys.stderr),
    )
    print(table(simulated(options.tests, simulation)))


if __name__ == "__main__":
    main()
