"""Measure what end caps do to the angles of a drum, by its length and by their friction.

Rough spheres (sliding friction 0.5, rolling friction 0.2 without a rolling dashpot) in the default
drum of 16 particle diameters: a slice that repeats, and drums of several lengths with caps that
turn with them, rough or without friction. Runs are kept in the file ``--kept`` and not repeated,
so that the command can be stopped and started again.

    python benchmarks/drum_caps.py --kept benchmarks/data/drum_caps.jsonl [--seeds 4]
        [--solvers lammps] [--table]
"""

from __future__ import annotations

import argparse
from collections import defaultdict
from pathlib import Path
from typing import Any, NamedTuple

from grainfit.bulk_tests.drum import Drum
from grainfit.materials.walls import on_wall, wall_of
from grainfit.solvers.dem.program import DeckSolver
from grainfit.solvers.registry import DEM_PROGRAMS
from grainfit.testing.materials import ROUGH_SPHERES
from kept_runs import mean_and, measure, read, scatter, simulate

DIAMETER = 0.010
#: Length in diameters, and sliding friction of the caps; None for a slice without any.
DRUMS = ((6.0, None), (6.0, 0.0), (4.0, 0.4), (6.0, 0.4), (12.0, 0.4), (24.0, 0.4))


class Run(NamedTuple):
    """What is varied: the length in diameters, and the sliding friction of the caps."""

    solver: str
    seed: int
    length: float
    friction: float | None


def solver_of(run: Run) -> DeckSolver:
    """Return the solver of a run; the caps are a wall of their own."""
    pairs = ("particle_particle", "particle_wall")
    material = {**ROUGH_SPHERES, **{f"{pair}.rolling_damping": 0.0 for pair in pairs}}
    drum = Drum(
        diameter=DIAMETER, drum_length=run.length * DIAMETER, end_caps=run.friction is not None
    )
    program = DEM_PROGRAMS[run.solver]
    if run.friction is None:
        return program(drum, material)
    of_caps = {on_wall(key, "cap"): value for key, value in material.items() if wall_of(key) == ""}
    of_caps["particle_wall.cap.sliding_friction"] = run.friction
    of_caps["particle_wall.cap.rolling_friction"] = run.friction / 4
    return program(drum, {**material, **of_caps}, walls={"caps": "cap"})


def record_of(run: Run) -> dict[str, Any]:
    """Simulate a run."""
    return simulate(solver_of(run), run.seed)


def print_table(kept: Path) -> None:
    """Print the mean of each angle with its scatter from seed to seed."""
    found: dict[tuple[str, float, str], list[dict[str, float]]] = defaultdict(list)
    failed: dict[tuple[str, float, str], int] = defaultdict(int)
    for run, record in read(kept, Run).items():
        caps = "slice" if run.friction is None else f"{run.friction:g}"
        key = (run.solver, run.length, caps)
        if "responses" in record:
            found[key].append(record["responses"])
        else:
            failed[key] += 1
    print("| solver | length, d | friction of the caps | runs | failed | dynamic | surface |")
    print("|---|---|---|---|---|---|---|")
    for key, runs in sorted(found.items()):
        angles = [
            mean_and(scatter, [one[name] for one in runs])
            for name in ("dynamic_angle", "surface_angle")
        ]
        solver, length, caps = key
        cells = [solver, f"{length:g}", caps, str(len(runs)), str(failed[key]), *angles]
        print(f"| {' | '.join(cells)} |")


def main() -> None:
    """Simulate what is missing, and print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--kept", type=Path, required=True)
    parser.add_argument("--seeds", type=int, default=4)
    parser.add_argument("--solvers", nargs="+", default=["lammps"])
    parser.add_argument("--table", action="store_true")
    arguments = parser.parse_args()
    if not arguments.table:
        runs = [
            Run(solver, seed, length, friction)
            for seed in range(1, arguments.seeds + 1)
            for solver in arguments.solvers
            for length, friction in DRUMS
        ]
        measure(runs, arguments.kept, record_of)
    print_table(arguments.kept)


if __name__ == "__main__":
    main()
