"""What the softness of particles does to a drum at several speeds.

Rough spheres in the usual drum on LAMMPS. Finished runs are kept in the file ``--kept`` and not
repeated.

    python benchmarks/soft_drums.py --kept benchmarks/data/soft_drums.jsonl [--seeds 2]

Prints a table in Markdown: for every modulus the stiffness number, and at each Froude number the
mean dynamic angle and its change from the stiffest; then the mean change over all speeds.
"""

from __future__ import annotations

import argparse
import os
from collections import defaultdict
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

os.environ["OMP_NUM_THREADS"] = "1"

import numpy as np

from grainfit.bulk_tests.drum.bulk_test import Drum
from grainfit.bulk_tests.parameter_names import MODULUS
from grainfit.bulk_tests.stiffness import stiffness_number
from grainfit.bulk_tests.time_steps import usual_time_step_fraction
from grainfit.formatting import number
from grainfit.solvers.dem.lammps.program import Lammps
from grainfit.testing.materials import ROUGH_SPHERES
from kept_runs import measure, read, simulate

FROUDES = (0.005, 0.02, 0.05, 0.1)
MODULI = (0.36e6, 1.44e6, 5.76e6, 23e6)
_UNDAMPED = {"particle_particle.rolling_damping": 0.0, "particle_wall.rolling_damping": 0.0}


class Run(NamedTuple):
    """One drum."""

    froude: float
    modulus: float
    seed: int


def material_of(modulus: float) -> dict[str, float]:
    """Return rough spheres of a modulus, without a rolling dashpot."""
    return {**ROUGH_SPHERES, **_UNDAMPED, MODULUS: modulus}


def drum_of(froude: float, modulus: float) -> Drum:
    """Return the usual drum at a speed, with the time step that is safe for the modulus."""
    usual = Drum(diameter=0.01, froude_number=froude)
    ends = {name: (value, value) for name, value in material_of(modulus).items()}
    fraction = usual_time_step_fraction(usual, ends)
    return Drum(diameter=0.01, froude_number=froude, time_step_fraction=fraction)


def _made(run: Run) -> dict[str, Any]:
    return simulate(Lammps(drum_of(run.froude, run.modulus), material_of(run.modulus)), run.seed)


def table(kept: Path) -> Iterator[str]:
    """Yield the lines of the table."""
    found = defaultdict(list)
    for run, record in read(kept, Run).items():
        if "responses" in record:
            found[run.froude, run.modulus].append(record["responses"]["dynamic_angle"])
    speeds = " | ".join(f"Froude number {froude:g}" for froude in FROUDES)
    yield f"| E, MPa | E / (ρ g d) | runs | {speeds} | mean change |"
    yield "|---" * (4 + len(FROUDES)) + "|"
    for modulus in MODULI:
        value = stiffness_number(drum_of(FROUDES[0], modulus), material_of(modulus))
        own = [found[froude, modulus] for froude in FROUDES]
        means = [float(np.mean(one)) for one in own]
        stiffest = [float(np.mean(found[froude, MODULI[-1]])) for froude in FROUDES]
        changes = np.subtract(means, stiffest)
        cells = " | ".join(f"{m:.1f}° ({c:+.1f}°)" for m, c in zip(means, changes, strict=True))
        yield (
            f"| {modulus / 1e6:g} | {number(value, 3)} | {sum(map(len, own))} | {cells} "
            f"| {changes.mean():+.1f}° |"
        )


def main() -> None:
    """Make the runs that are missing, and print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--kept", type=Path, required=True)
    parser.add_argument("--seeds", type=int, default=2)
    given = parser.parse_args()
    seeds = range(1, given.seeds + 1)
    measure([Run(f, e, s) for s in seeds for e in MODULI for f in FROUDES], given.kept, _made)
    print("\n".join(table(given.kept)))


if __name__ == "__main__":
    main()
