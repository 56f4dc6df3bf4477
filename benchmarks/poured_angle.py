"""Compare the angles that one material has in several tests: poured, lifted, in a drum.

A funnel that is raised, one that stands still at 12 d, one over a disc, the lifted cylinder and the
drum, with glass beads and with rough spheres without rolling damping. Finished runs are kept in
the file ``--kept`` and not repeated, so that the command can be stopped and started again.

    python benchmarks/poured_angle.py --kept benchmarks/data/poured_angle.jsonl [--seeds 8]
        [--table]

Prints the mean of each angle with its scatter from run to run, and the failed runs.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any, NamedTuple

from grainfit.bulk_tests.base import BulkTest
from grainfit.solvers.dem.lammps.program import Lammps
from grainfit.testing.materials import GLASS_BEADS, ROUGH_PLATE, ROUGH_SPHERES
from grainfit.tests import Drum, Funnel, Heap
from kept_runs import mean_and, measure, read, scatter, simulate

_D = {"diameter": "10 mm"}
TESTS: Mapping[str, tuple[BulkTest, str]] = {
    "funnel, raised": (Funnel(**_D, **ROUGH_PLATE), "angle_of_repose"),
    "funnel, raised, twice the volume": (
        Funnel(**_D, **ROUGH_PLATE, poured_volume="2700 cm^3"),
        "angle_of_repose",
    ),
    "funnel at 12 d": (
        Funnel(**_D, **ROUGH_PLATE, funnel_height="120 mm", raise_speed=0),
        "angle_of_repose",
    ),
    "funnel, raised, over a disc": (Funnel(**_D, **ROUGH_PLATE, base="disc"), "angle_of_repose"),
    "lifted cylinder": (Heap(**_D, **ROUGH_PLATE), "angle_of_repose"),
    "drum": (Drum(**_D), "surface_angle"),
}
_UNDAMPED = {f"particle_{partner}.rolling_damping": 0.0 for partner in ("particle", "wall")}
MATERIALS = {
    "glass beads": {**GLASS_BEADS, **_UNDAMPED},
    "rough spheres": {**ROUGH_SPHERES, **_UNDAMPED},
}


class Run(NamedTuple):
    """What is varied: test, material and seed."""

    test: str
    material: str
    seed: int


def record_of(run: Run) -> dict[str, Any]:
    """Simulate once."""
    return simulate(Lammps(TESTS[run.test][0], MATERIALS[run.material]), run.seed)


def table(records: Mapping[Run, dict[str, Any]]) -> Iterator[str]:
    """Yield the lines of the table in Markdown, one for every test."""
    yield f"| test | {' | '.join(f'{m}: angle, °' for m in MATERIALS)} | runs |"
    yield "|---" * (len(MATERIALS) + 2) + "|"
    for test, (_, response) in TESTS.items():
        cells, count = [], 0
        for material in MATERIALS:
            own = [r for run, r in records.items() if run[:2] == (test, material)]
            good = [r["responses"][response] for r in own if response in r.get("responses", {})]
            failed = f", {len(own) - len(good)} failed" if len(own) > len(good) else ""
            cells.append(f"{mean_and(scatter, good)}{failed}" if good else "")
            count = max(count, len(own))
        yield f"| {test} | {' | '.join(cells)} | {count} |"
    yield from (f"{run}: {r['why']}" for run, r in records.items() if "why" in r)


def main() -> None:
    """Make the runs that are missing, and print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--kept", type=Path, required=True)
    parser.add_argument("--seeds", type=int, default=8)
    parser.add_argument("--table", action="store_true", help="only print what is known")
    given = parser.parse_args()
    seeds = range(1, given.seeds + 1)
    if not given.table:
        runs = [
            Run(test, material, seed) for seed in seeds for material in MATERIALS for test in TESTS
        ]
        measure(runs, given.kept, record_of)
    print("\n".join(table(read(given.kept, Run))))


if __name__ == "__main__":
    main()
