"""Simulate a plate box with a published angle of repose, as a scene of the user's own.

Zhou et al. (2002) discharged boxes over a plate and fitted the angle of the pile that stays:
68.61 mu_pp^0.27 mu_pw^0.22 m_pp^0.06 m_pw^0.12 d^-0.2, with rolling frictions m (torque over normal
force) and the diameter d in mm. Spheres of 10 mm with sliding and rolling frictions of 0.2 and
0.1 d have 19.7 degrees. `examples/plate_discharge/plate_box.py` simulates them without a rolling
dashpot; rolling frictions are 0.4 and 0.2 here, over effective radii of d/4 and d/2. The published
box is 1 x 0.2 m with 52,000 particles; the width of its plate is not known here. Runs are kept in
the file ``--kept`` and not repeated, so that the command can be stopped and started again.

    python benchmarks/plate_discharge.py --kept plate.jsonl [--solver lammps] [--seeds 3]
        [--plates 0.4 0.6] [--depth 0.06] [--end-walls] [--slidings 0.1 0.2 0.4]
        [--torques 0.1 0.025]
"""

from __future__ import annotations

import argparse
import itertools
import json
import math
import resource
import sys
import tempfile
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import numpy as np

from grainfit.bulk_tests.own_scene.bulk_test import OwnScene
from grainfit.errors import GrainfitError
from grainfit.evaluation import scalars
from grainfit.solvers.base import Workspace
from grainfit.solvers.registry import DEM_PROGRAMS
from grainfit.testing.materials import GLASS_BEADS

SCENE = Path(__file__).parents[1] / "examples" / "plate_discharge" / "plate_box.py"
DIAMETER, WIDTH, FILL_HEIGHT = 0.010, 1.0, 0.235
#: What makes runs the same but for their seed.
CASE = ("solver", "plate", "depth", "end_walls", "torque", "sliding")
Record = dict[str, Any]


def published(torque: float, sliding: float) -> float:
    """Return the published angle, degrees, for the same frictions everywhere.

    ``torque`` is that of rolling friction over normal force, a share of the diameter.
    """
    diameter = 1000 * DIAMETER
    rolling = torque * diameter
    return float(68.61 * sliding ** (0.27 + 0.22) * rolling ** (0.06 + 0.12) * diameter**-0.2)


def material(torque: float, sliding: float) -> dict[str, float]:
    """Return the material with the same frictions everywhere."""
    given = {"particle_particle": 4 * torque, "particle_wall": 2 * torque}
    of_body = {"youngs_modulus": 1e6, "poissons_ratio": 0.3, "density": 2400.0}
    return {
        **GLASS_BEADS,
        **{f"particle.{key}": value for key, value in of_body.items()},
        **{f"wall.{key}": value for key, value in of_body.items()},
        **{f"{pair}.sliding_friction": sliding for pair in given},
        **{f"{pair}.rolling_friction": rolling for pair, rolling in given.items()},
        **{f"{pair}.restitution": 0.9 for pair in given},
        **{f"{pair}.rolling_damping": 0.0 for pair in given},
    }


def run(case: tuple[Any, ...], seed: int) -> Record:
    """Simulate the box once; return the angle and its standard error, or why there is none."""
    solver, plate, depth, end_walls, torque, sliding = case
    record: Record = dict(zip(CASE, case, strict=True)) | {"seed": seed}
    options = {
        "width": WIDTH,
        "plate": plate,
        "depth": depth,
        "fill_height": FILL_HEIGHT,
        "end_walls": end_walls,
    }
    box = OwnScene(
        diameter=DIAMETER,
        scene=f"{SCENE}:scene",
        measure=f"{SCENE}:measure",
        options=options,
    )
    before = _processor_seconds()
    with tempfile.TemporaryDirectory() as folder:
        try:
            program = DEM_PROGRAMS[solver](box, material(torque, sliding))
            found = scalars(program.run({}, seed, Workspace(Path(folder))))["angle_of_repose"]
        except GrainfitError as error:
            return record | {"why": str(error)}
    seconds = round(_processor_seconds() - before, 1)
    return record | {"angle": [found.value, found.standard_error], "seconds": seconds}


def _processor_seconds() -> float:
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def table(records: Iterable[Record]) -> str:
    """Return means and standard deviations over seeds as a table in Markdown."""
    records = list(records)
    lines = [
        "| solver | plate, m | depth, m | end walls | torque / d | sliding friction | seeds "
        "| angle | stated error | published | CPU s a run |",
        "|---" * 11 + "|",
    ]
    for case in dict.fromkeys(tuple(r[key] for key in CASE) for r in records):
        own = [r for r in records if tuple(r[key] for key in CASE) == case]
        measured = [r for r in own if "angle" in r]
        if measured:
            values, errors = np.array([r["angle"] for r in measured]).T
            scatter = f" ± {values.std(ddof=1):.1f}°" if len(values) > 1 else ""
            solver, plate, depth, end_walls, torque, sliding = case
            cells = [solver, f"{plate:g}", f"{depth:g}", "yes" if end_walls else "no"]
            cells += [
                f"{torque:g}",
                f"{sliding:g}",
                str(len(values)),
                f"{values.mean():.1f}°{scatter}",
            ]
            cells += [f"{math.sqrt((errors**2).mean()):.1f}°", f"{published(torque, sliding):.1f}°"]
            cells += [f"{np.median([r['seconds'] for r in measured]):.0f}"]
            lines.append("| " + " | ".join(cells) + " |")
        lines += [f"{case}, seed {r['seed']}: {r['why']}" for r in own if "why" in r]
    return "\n".join(lines)


def main() -> None:
    """Make the runs that are missing, and print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--kept", type=Path, required=True)
    parser.add_argument("--solver", choices=sorted(DEM_PROGRAMS), default="lammps")
    parser.add_argument("--seeds", type=int, default=3)
    parser.add_argument("--plates", type=float, nargs="+", default=[0.6])
    parser.add_argument("--depth", type=float, default=0.06)
    parser.add_argument("--end-walls", action="store_true", help="instead of a periodic slice")
    parser.add_argument("--slidings", type=float, nargs="+", default=[0.2])
    parser.add_argument("--torques", type=float, nargs="+", default=[0.1])
    given = parser.parse_args()
    lines = given.kept.read_text().splitlines() if given.kept.exists() else []
    records = [json.loads(line) for line in lines]
    known = {(*(r[key] for key in CASE), r["seed"]) for r in records}
    seeds = range(1, given.seeds + 1)
    product = itertools.product(seeds, given.plates, given.torques, given.slidings)
    for seed, plate, torque, sliding in product:
        case = (given.solver, plate, given.depth, given.end_walls, torque, sliding)
        if (*case, seed) in known:
            continue
        records.append(run(case, seed))
        with given.kept.open("a") as file:
            file.write(json.dumps(records[-1]) + "\n")
        print(records[-1], file=sys.stderr, flush=True)
    print(table(records))


if __name__ == "__main__":
    main()
