"""Simulate a plate box with a published angle of repose, as a scene of the user's own.

Zhou et al. (2002) discharged boxes over a plate and fitted the angle of the pile that stays:
68.61 mu_pp^0.27 mu_pw^0.22 m_pp^0.06 m_pw^0.12 d^-0.2, with rolling frictions m (torque over normal
force) and the diameter d in mm. Spheres of 10 mm with a sliding friction of 0.2 and a torque of
0.1 d have 19.7 degrees. `examples/plate_discharge/plate_box.py` simulates them without a rolling
dashpot; a torque of 0.1 d is a rolling friction of 0.4 between two particles and of 0.2 on walls,
over effective radii of d/4 and d/2. The published box is 1 x 0.2 m with 52,000 particles; the width
of its plate is not known here. Finished runs are kept in the file ``--kept`` and not repeated, so
that the command can be stopped and started again.

    python benchmarks/plate_discharge.py --kept plate.jsonl [--solver lammps] [--seeds 3]
        [--plates 0.4 0.6] [--depth 0.05] [--end-walls] [--torques 0.1 0.025]
        [--slidings 0.1 0.2 0.4] [--table]
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator, Mapping
from itertools import product
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from grainfit.bulk_tests.own_scene.bulk_test import OwnScene
from grainfit.solvers.registry import DEM_PROGRAMS
from grainfit.testing.materials import GLASS_BEADS
from kept_runs import mean_and, measure, read, simulate
from rolling_programs import ConstantTorque

SCENE = Path(__file__).parents[1] / "examples" / "plate_discharge" / "plate_box.py"
DIAMETER, WIDTH, FILL_HEIGHT = 0.010, 1.0, 0.235
PROGRAMS = {**DEM_PROGRAMS, "constant_torque": ConstantTorque}


class Run(NamedTuple):
    """What is varied; lengths in m, the torque as a share of the diameter."""

    seed: int
    solver: str
    plate: float
    depth: float
    end_walls: bool
    torque: float
    sliding: float


def published(run: Run) -> float:
    """Return the published angle, degrees."""
    diameter = 1000 * DIAMETER
    rolling = run.torque * diameter
    return float(68.61 * run.sliding ** (0.27 + 0.22) * rolling ** (0.06 + 0.12) * diameter**-0.2)


def material_of(run: Run) -> Mapping[str, float]:
    """Return the material of a run: its frictions are the same everywhere."""
    of_body = {"youngs_modulus": 1e6, "poissons_ratio": 0.3, "density": 2400.0}
    rolling = {"particle_particle": 4 * run.torque, "particle_wall": 2 * run.torque}
    return {
        **GLASS_BEADS,
        **{f"particle.{key}": value for key, value in of_body.items()},
        **{f"wall.{key}": value for key, value in of_body.items()},
        **{f"{pair}.sliding_friction": run.sliding for pair in rolling},
        **{f"{pair}.rolling_friction": value for pair, value in rolling.items()},
        **{f"{pair}.restitution": 0.9 for pair in rolling},
        **{f"{pair}.rolling_damping": 0.0 for pair in rolling},
    }


def record_of(run: Run) -> dict[str, Any]:
    """Simulate a run."""
    box = OwnScene(
        diameter=DIAMETER,
        scene=f"{SCENE}:scene",
        measure=f"{SCENE}:measure",
        options={
            "width": WIDTH,
            "plate": run.plate,
            "depth": run.depth,
            "fill_height": FILL_HEIGHT,
            "end_walls": run.end_walls,
        },
    )
    return simulate(PROGRAMS[run.solver](box, material_of(run)), run.seed)


def table(records: Mapping[Run, dict[str, Any]]) -> Iterator[str]:
    """Yield the lines of the table in Markdown, one for every setting."""
    yield (
        "| solver | plate, m | depth, m | torque / d | sliding friction | seeds | angle, ° "
        "| published | CPU s |"
    )
    yield "|---" * 9 + "|"
    for setting in dict.fromkeys(run._replace(seed=0) for run in sorted(records)):
        own = {run: r for run, r in records.items() if run._replace(seed=0) == setting}
        angles = [r["responses"]["angle_of_repose"] for r in own.values() if "responses" in r]
        if angles:
            depth = f"{setting.depth:g}, {'end walls' if setting.end_walls else 'periodic'}"
            cells = [setting.solver, f"{setting.plate:g}", depth, f"{setting.torque:g}"]
            cells += [f"{setting.sliding:g}", str(len(angles)), mean_and(_scatter, angles)]
            cells += [f"{published(setting):.1f}"]
            cells += [f"{np.median([r['seconds'] for r in own.values()]):.0f}"]
            yield f"| {' | '.join(cells)} |"
        yield from (f"{run}: {r['why']}" for run, r in own.items() if "why" in r)


def _scatter(values: Any) -> float:
    return float(np.std(values, ddof=1))


def main() -> None:
    """Make the runs that are missing, and print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--kept", type=Path, required=True)
    parser.add_argument("--solver", choices=sorted(PROGRAMS), default="lammps")
    parser.add_argument("--seeds", type=int, default=3)
    parser.add_argument("--plates", type=float, nargs="+", default=[0.6])
    parser.add_argument("--depth", type=float, default=0.05)
    parser.add_argument("--end-walls", action="store_true", help="instead of a periodic slice")
    parser.add_argument("--torques", type=float, nargs="+", default=[0.1])
    parser.add_argument("--slidings", type=float, nargs="+", default=[0.2])
    parser.add_argument("--table", action="store_true", help="only print what is known")
    given = parser.parse_args()
    cases = product(given.plates, given.torques, given.slidings)
    runs = [
        Run(seed, given.solver, plate, given.depth, given.end_walls, torque, sliding)
        for plate, torque, sliding in cases
        for seed in range(1, given.seeds + 1)
    ]
    if not given.table:
        measure(runs, given.kept, record_of)
    print("\n".join(table(read(given.kept, Run))))


if __name__ == "__main__":
    main()
