"""Simulate a drum with a measured angle: 26 degrees, of Lethe's examples.

Spheres of 5.95 mm and 1768 kg/m^3 in a drum of 69 mm radius at 2.198 rad/s; restitution 0.9,
sliding friction 0.3, rolling friction 0.02, no rolling dashpot. The drum of the example holds
6,000 of them; here it is a slice of six diameters without end walls. Fill level, wall and Young's
modulus are assumptions: 0.4 unless given, lined or smooth, and 0.5 MPa, 4,800 times the weight of a
particle on its cross-section. Runs are kept in the file ``--kept`` and not repeated, so that the
command can be stopped and started again.

    python benchmarks/lethe_drum.py --kept drum.jsonl [--solver lammps] [--seeds 3]
        [--fill-levels 0.4] [--walls lined smooth]
"""

from __future__ import annotations

import argparse
import itertools
import json
import sys
import tempfile
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import numpy as np

from grainfit.bulk_tests.drum import Drum
from grainfit.errors import GrainfitError
from grainfit.evaluation import scalars
from grainfit.solvers.base import Workspace
from grainfit.solvers.registry import DEM_PROGRAMS
from grainfit.testing.materials import GLASS_BEADS

#: Measured angle, degrees.
MEASURED = 26.0
MATERIAL = {
    **GLASS_BEADS,
    "particle.youngs_modulus": 5e5,
    "particle.poissons_ratio": 0.3,
    "particle.density": 1768.0,
    **{
        f"{pair}.{name}": value
        for pair in ("particle_particle", "particle_wall")
        for name, value in (
            ("sliding_friction", 0.3),
            ("rolling_friction", 0.02),
            ("restitution", 0.9),
            ("rolling_damping", 0.0),
        )
    },
}
Record = dict[str, Any]


def run(solver: str, wall: str, fill_level: float, seed: int) -> Record:
    """Simulate the drum once; return its angles, or why there are none."""
    record: Record = {"solver": solver, "wall": wall, "fill_level": fill_level, "seed": seed}
    drum = Drum(
        diameter="5.95 mm",
        drum_radius="69 mm",
        rotational_speed="2.198 rad/s",
        fill_level=fill_level,
        lining=wall == "lined",
        discarded_turns=0.4,
    )
    with tempfile.TemporaryDirectory() as folder:
        try:
            found = DEM_PROGRAMS[solver](drum, MATERIAL).run({}, seed, Workspace(Path(folder)))
        except GrainfitError as error:
            return record | {"why": str(error)}
    angles = {name: [r.value, r.standard_error] for name, r in scalars(found).items()}
    return record | {"angles": angles}


def table(records: Iterable[Record]) -> str:
    """Return means and standard deviations over seeds as a table in Markdown."""
    records = list(records)
    lines = [
        "| solver | wall | fill level | seeds | angle | degrees | minus 26 |",
        "|---" * 7 + "|",
    ]
    cases = dict.fromkeys((r["solver"], r["wall"], r["fill_level"]) for r in records)
    for case in cases:
        own = [r for r in records if (r["solver"], r["wall"], r["fill_level"]) == case]
        measured = [r["angles"] for r in own if "angles" in r]
        for name in measured[0] if measured else ():
            values = np.array([angles[name][0] for angles in measured])
            scatter = f" ± {values.std(ddof=1):.2f}" if len(values) > 1 else ""
            cells = [*map(str, case), str(len(values)), name]
            cells += [f"{values.mean():.2f}{scatter}", f"{values.mean() - MEASURED:+.2f}"]
            lines.append("| " + " | ".join(cells) + " |")
        lines += [f"{case}, seed {r['seed']}: {r['why']}" for r in own if "why" in r]
    return "\n".join(lines)


def main() -> None:
    """Make the runs that are missing, and print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--kept", type=Path, required=True)
    parser.add_argument("--solver", choices=sorted(DEM_PROGRAMS), default="lammps")
    parser.add_argument("--seeds", type=int, default=3)
    parser.add_argument("--fill-levels", type=float, nargs="+", default=[0.4])
    parser.add_argument("--walls", nargs="+", choices=("lined", "smooth"), default=["lined"])
    given = parser.parse_args()
    lines = given.kept.read_text().splitlines() if given.kept.exists() else []
    records = [json.loads(line) for line in lines]
    known = {(r["solver"], r["wall"], r["fill_level"], r["seed"]) for r in records}
    seeds = range(1, given.seeds + 1)
    for seed, wall, level in itertools.product(seeds, given.walls, given.fill_levels):
        job = (given.solver, wall, level, seed)
        if job in known:
            continue
        records.append(run(*job))
        with given.kept.open("a") as file:
            file.write(json.dumps(records[-1]) + "\n")
        print(records[-1], file=sys.stderr, flush=True)
    print(table(records))


if __name__ == "__main__":
    main()
