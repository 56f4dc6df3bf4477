"""Time a run on one core alone, two of them at once, and one shared by two MPI ranks, on LAMMPS.

The apparatus grows with the number of particles. Run it on an idle machine of two cores. Measured
rows are kept in the file ``--kept`` and not repeated.

    python benchmarks/ranks.py --kept benchmarks/data/ranks.jsonl [--tests packing heap]
        [--particles 500 1500 5000 15000 50000] [--repeats 3] [--table]

Prints medians of the wall times, how many times as fast two ranks are as one, and how many times
as many runs two at once finish as one after the other by two ranks.
"""

from __future__ import annotations

import argparse
import os
import tempfile
import time
from collections.abc import Iterator, Mapping
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from statistics import median
from typing import Any, NamedTuple

os.environ["OMP_NUM_THREADS"] = "1"

from grainfit.bulk_tests.registry import bulk_tests
from grainfit.bulk_tests.size import resized
from grainfit.formatting import number
from grainfit.solvers.base import Workspace
from grainfit.solvers.registry import DEM_PROGRAMS
from grainfit.testing.materials import ROUGH_SPHERES, rough_plate_of
from kept_runs import measure, read

#: How many runs at once, on how many ranks.
WAYS = {"alone": (1, 1), "two at once": (2, 1), "two ranks": (1, 2)}


class Run(NamedTuple):
    """What is timed."""

    repeat: int
    test: str
    particles: int
    way: str


def wall_time(run: Run) -> dict[str, Any]:
    """Time the runs of a way until the last of them ends, s."""
    at_once, ranks = WAYS[run.way]
    usual = bulk_tests()[run.test](diameter="10 mm", **rough_plate_of(run.test))
    test = resized(usual, run.particles / usual.number_of_particles)
    program = DEM_PROGRAMS["lammps"](test, ROUGH_SPHERES, ranks=ranks)

    def simulate(seed: int) -> None:
        with tempfile.TemporaryDirectory() as folder:
            program.run({}, seed, Workspace(Path(folder)))

    begin = time.perf_counter()
    with ThreadPoolExecutor(at_once) as pool:
        list(pool.map(simulate, range(1, at_once + 1)))
    return {"seconds": round(time.perf_counter() - begin, 3), "made": test.number_of_particles}


def table(records: Mapping[Run, dict[str, Any]]) -> Iterator[str]:
    """Yield the lines of the table in Markdown, one for every test and number of particles."""
    yield (
        "| test | particles | alone, s | two at once, s | two ranks, s "
        "| two ranks over one | two at once over two ranks |"
    )
    yield "|---" * 7 + "|"
    for test, particles in sorted({(run.test, run.particles) for run in records}):
        own = {
            way: [
                one["seconds"]
                for run, one in records.items()
                if (run.test, run.particles, run.way) == (test, particles, way)
            ]
            for way in WAYS
        }
        if not all(own.values()):
            continue
        alone, both, shared = (median(own[way]) for way in WAYS)
        times = " | ".join(number(one, 3) for one in (alone, both, shared))
        gain, throughput = number(alone / shared, 3), number(2 * shared / both, 3)
        yield f"| {test} | {particles:,} | {times} | {gain} | {throughput} |"


def main() -> None:
    """Time, and print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--kept", type=Path, required=True)
    parser.add_argument("--tests", nargs="+", choices=bulk_tests(), default=["packing", "heap"])
    parser.add_argument(
        "--particles", nargs="+", type=int, default=[500, 1500, 5000, 15_000, 50_000]
    )
    parser.add_argument("--repeats", type=int, default=3)
    parser.add_argument("--table", action="store_true", help="only print what is known")
    given = parser.parse_args()
    if not given.table:
        runs = [
            Run(repeat, test, particles, way)
            for repeat in range(given.repeats)
            for particles in given.particles
            for test in given.tests
            for way in WAYS
        ]
        measure(runs, given.kept, wall_time)
    print("\n".join(table(read(given.kept, Run))))


if __name__ == "__main__":
    main()
