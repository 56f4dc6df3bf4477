"""Compare discharges that end once their flow is known with the same ones that go on to rest.

Both are one run up to the earlier end, so that their mass flows differ by the part in which they
are measured alone. Finished runs are kept in the file ``--kept`` and not repeated.

    python benchmarks/flow_ends.py --kept benchmarks/data/flow_ends.jsonl [--seeds 20] [--table]

Prints the change of the mass flow with its 95 % interval, its scatter, and what a run costs.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator, Mapping
from itertools import product
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from scipy import stats

from grainfit.bulk_tests.discharge import Discharge
from grainfit.formatting import number
from grainfit.solvers.dem.lammps.program import Lammps
from grainfit.testing.materials import GLASS_BEADS, ROUGH_SPHERES
from kept_runs import measure, read, scatter, simulate

DIAMETER = 0.010
MATERIALS: Mapping[str, Mapping[str, float]] = {
    "glass beads, 0.36 MPa": GLASS_BEADS,
    "rough spheres, 0.36 MPa": ROUGH_SPHERES,
    "rough spheres, 10 MPa": {**ROUGH_SPHERES, "particle.youngs_modulus": 1e7},
}
ORIFICES, ENDS = ("slot", "round"), ("measured", "rest")


class Run(NamedTuple):
    """What is varied."""

    material: str
    orifice: str
    until: str
    seed: int


def record_of(run: Run) -> dict[str, Any]:
    """Simulate once."""
    test = Discharge(diameter=DIAMETER, orifice=run.orifice, flow_until=run.until)
    return simulate(Lammps(test, MATERIALS[run.material]), run.seed)


def table(records: Mapping[Run, dict[str, Any]]) -> Iterator[str]:
    """Yield the lines of the table in Markdown."""
    names = ("material", "orifice", "runs", "change of the mass flow", "scatter", "to rest")
    yield f"| {' | '.join((*names, 'CPU s a run', 'to rest'))} |"
    yield "|---" * 8 + "|"
    for material, orifice in product(MATERIALS, ORIFICES):
        own = {r[2:]: found for r, found in records.items() if r[:2] == (material, orifice)}
        seeds = [seed for until, seed in own if until == "rest" and ("measured", seed) in own]
        if len(seeds) < 2:
            continue
        runs = [[own[until, seed] for seed in seeds] for until in ENDS]
        flows = np.array([[run["responses"]["mass_flow"] for run in one] for one in runs])
        # In per cent of the mean flow to rest.
        measured, rest = 100 * flows / flows[1].mean()
        low, high = stats.ttest_rel(measured, rest).confidence_interval(0.95)
        cells = [
            *(material, orifice, str(len(seeds))),
            f"{(low + high) / 2:+.2f} ± {(high - low) / 2:.2f} %",
            *(f"{scatter(one):.1f} %" for one in (measured, rest)),
            *(number(float(np.mean([run["seconds"] for run in one])), 3) for one in runs),
        ]
        yield f"| {' | '.join(cells)} |"


def main() -> None:
    """Make the runs that are missing, and print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--kept", type=Path, required=True)
    parser.add_argument("--seeds", type=int, default=20)
    parser.add_argument("--table", action="store_true", help="only print what is known")
    given = parser.parse_args()
    seeds = range(1, given.seeds + 1)
    ways = product(ORIFICES, seeds, MATERIALS, ENDS)
    wanted = [Run(material, orifice, until, seed) for orifice, seed, material, until in ways]
    if not given.table:
        measure(wanted, given.kept, record_of)
    print("\n".join(table(read(given.kept, Run))))


if __name__ == "__main__":
    main()
