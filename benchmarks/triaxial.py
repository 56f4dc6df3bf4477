"""Compare dense and loose beds in a triaxial test: peak, critical state, and initial density.

Spheres without rolling friction in the default box under a confining stress of E / 1000, on LAMMPS
or YADE. Without friction during isotropic compression a bed is dense at first, with that of the
material it is loose; the critical state must not know of it. Runs are kept in the file ``--kept``
and not repeated, so that the command can be stopped and started again.

    python benchmarks/triaxial.py --kept benchmarks/data/triaxial.jsonl [--seeds 3]
        [--solvers lammps] [--frictions 0.5] [--strains 0.5]
        [--table]
"""

from __future__ import annotations

import argparse
import math
from collections import defaultdict
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from grainfit.bulk_tests.triaxial import Triaxial
from grainfit.solvers.registry import DEM_PROGRAMS
from grainfit.testing.materials import ROUGH_SPHERES
from kept_runs import mean_and, measure, read, scatter, simulate

DIAMETER, MODULUS = 0.010, 1e7
RESPONSES = ("initial_density", "peak_friction_angle", "critical_friction_angle")


class Run(NamedTuple):
    """What is varied: friction of the material, that at first, and the axial strain."""

    solver: str
    seed: int
    friction: float
    initial_friction: float
    axial_strain: float


def record_of(run: Run) -> dict[str, Any]:
    """Simulate a run."""
    pairs = ("particle_particle", "particle_wall")
    without = ("rolling_friction", "rolling_damping")
    material = {
        **ROUGH_SPHERES,
        **{f"{pair}.{name}": 0.0 for pair in pairs for name in without},
        "particle.youngs_modulus": MODULUS,
        "particle_particle.sliding_friction": run.friction,
    }
    test = Triaxial(
        diameter=DIAMETER, initial_friction=run.initial_friction, axial_strain=run.axial_strain
    )
    return simulate(DEM_PROGRAMS[run.solver](test, material), run.seed)


def print_table(kept: Path) -> None:
    """Print means with the scatter from seed to seed, and how far critical states are apart."""
    beds: dict[tuple[str, float, float], dict[float, list[dict[str, float]]]] = defaultdict(dict)
    failed = 0
    for run, record in read(kept, Run).items():
        of_material = beds[run.solver, run.friction, run.axial_strain].setdefault(
            run.initial_friction, []
        )
        if "responses" in record:
            of_material.append(record["responses"])
        else:
            failed += 1
    heads = ("solver", "friction", "axial strain", "friction at first", "runs")
    print(f"| {' | '.join((*heads, 'initial density', 'peak', 'critical'))} |")
    print("|---|---|---|---|---|---|---|---|")
    for (solver, friction, strain), of_material in sorted(beds.items()):
        for first, runs in sorted(of_material.items()):
            values = [mean_and(scatter, [one[name] for one in runs]) for name in RESPONSES]
            cells = [solver, f"{friction:g}", f"{strain:g}", f"{first:g}", str(len(runs)), *values]
            print(f"| {' | '.join(cells)} |")
        angles = [[one[RESPONSES[2]] for one in runs] for runs in of_material.values()]
        if len(angles) == 2 and min(map(len, angles)) > 1:
            error = math.sqrt(sum(np.var(one, ddof=1) / len(one) for one in angles))
            apart = abs(np.mean(angles[0]) - np.mean(angles[1]))
            print(f"\ncritical states: {apart:.2f} ± {error:.2f} degrees apart\n")
    print(f"{failed} runs failed")


def main() -> None:
    """Simulate what is missing, and print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--kept", type=Path, required=True)
    parser.add_argument("--seeds", type=int, default=3)
    parser.add_argument("--solvers", nargs="+", default=["lammps"])
    parser.add_argument("--frictions", nargs="+", type=float, default=[0.5])
    parser.add_argument("--strains", nargs="+", type=float, default=[0.5])
    parser.add_argument("--table", action="store_true")
    arguments = parser.parse_args()
    if not arguments.table:
        runs = [
            Run(solver, seed, friction, initial, strain)
            for solver in arguments.solvers
            for seed in range(1, arguments.seeds + 1)
            for friction in arguments.frictions
            for strain in arguments.strains
            for initial in (0.0, friction)
        ]
        measure(runs, arguments.kept, record_of)
    print_table(arguments.kept)


if __name__ == "__main__":
    main()
