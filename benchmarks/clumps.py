"""Measure responses, scatter and cost of clumps against their aspect ratio.

Finished runs are kept in the file ``--kept`` and not repeated, so that the command can be stopped
and started again.

    python benchmarks/clumps.py --kept clumps.jsonl [--seeds 3] [--tests heap]
        [--families two_spheres] [--ratios 1 1.25 1.5 1.75 2] [--rolling 0]
        [--solvers lammps] [--options '{"cylinder_radius": 0.035}']
        [--material '{"particle_particle.restitution": 0.3}'] [--table]

Prints the mean of each response with the scatter of single runs, and the processor time of a run.
The material is that of the rough spheres of the documentation, with the rolling friction of
``--rolling`` between particles and on walls, and the values of ``--material``. An aspect ratio of 1
is a sphere.
"""

from __future__ import annotations

import argparse
import json
import os
from collections.abc import Iterator, Mapping, Sequence
from itertools import product
from pathlib import Path
from typing import Any, NamedTuple

os.environ["OMP_NUM_THREADS"] = "1"

import numpy as np

from grainfit.bulk_tests.registry import bulk_tests
from grainfit.formatting import number
from grainfit.materials.particle_shape import ASPECT_RATIO, FAMILIES, ParticleShape
from grainfit.materials.sizes import ParticleSizes
from grainfit.solvers.registry import DEM_PROGRAMS
from grainfit.testing.materials import ROUGH_PLATE, ROUGH_SPHERES
from kept_runs import mean_and, measure, read, simulate

RATIOS = (1.0, 1.25, 1.5, 1.75, 2.0)
DIAMETER = 0.010
#: A test that needs another modulus than the others, Pa.
MODULI = {"compression": 10e6}


class Run(NamedTuple):
    """What is varied, in the order of the records."""

    seed: int
    test: str
    rolling_friction: float
    family: str
    aspect_ratio: float
    solver: str
    options: str
    material: str


def material_of(run: Run) -> Mapping[str, float]:
    """Return rough spheres with the rolling friction and the aspect ratio of a run."""
    contacts = ("particle_particle", "particle_wall")
    modulus = MODULI.get(run.test, ROUGH_SPHERES["particle.youngs_modulus"])
    return {
        **ROUGH_SPHERES,
        **{f"{contact}.rolling_friction": run.rolling_friction for contact in contacts},
        # YADE has none.
        **{f"{contact}.rolling_damping": 0.0 for contact in contacts},
        "particle.youngs_modulus": modulus,
        ASPECT_RATIO: run.aspect_ratio,
        **json.loads(run.material),
    }


def record_of(run: Run) -> dict[str, Any]:
    """Simulate a run."""
    sizes = ParticleSizes((DIAMETER,), shape=ParticleShape(run.family))
    program = DEM_PROGRAMS[run.solver](
        bulk_tests()[run.test](
            sizes, **(ROUGH_PLATE if run.test == "heap" else {}), **json.loads(run.options)
        ),
        material_of(run),
    )
    return simulate(program, run.seed)


def table(records: Mapping[Run, dict[str, Any]]) -> Iterator[str]:
    """Yield the lines of the table in Markdown, one for every setting."""
    yield "| test | shape | L/D | μ_r | solver | runs | responses, ± scatter of a run | CPU s |"
    yield "|---|---|---|---|---|---|---|---|"
    for setting in dict.fromkeys(run._replace(seed=0) for run in sorted(records)):
        own = [r for run, r in records.items() if run._replace(seed=0) == setting]
        good = [r["responses"] for r in own if "responses" in r]
        names = good[0] if good else ()
        means = ", ".join(f"{name} {mean_and(_scatter, [r[name] for r in good])}" for name in names)
        _, test, friction, family, ratio, solver, options, material = setting
        given = " ".join(filter(None, (one.strip("{}") for one in (options, material))))
        seconds = number(float(np.median([r["seconds"] for r in own])), 2)
        yield (
            f"| {test} {given} | {family} | {ratio:g} | {friction:g} | {solver} "
            f"| {len(good)} of {len(own)} | {means} | {seconds} |"
        )


def _scatter(values: Sequence[float]) -> float:
    return float(np.std(values, ddof=1))


def main() -> None:
    """Run, and print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--kept", type=Path, required=True)
    parser.add_argument("--seeds", type=int, default=3)
    parser.add_argument("--tests", nargs="+", choices=bulk_tests(), default=["heap"])
    parser.add_argument("--families", nargs="+", choices=FAMILIES, default=["two_spheres"])
    parser.add_argument("--ratios", nargs="+", type=float, default=list(RATIOS))
    parser.add_argument("--rolling", nargs="+", type=float, default=[0.0])
    parser.add_argument("--solvers", nargs="+", choices=DEM_PROGRAMS, default=["lammps"])
    parser.add_argument("--options", default="{}", help="options of the test, as JSON")
    parser.add_argument("--material", default="{}", help="values of the material, SI, as JSON")
    parser.add_argument("--table", action="store_true", help="only print what is known")
    given = parser.parse_args()
    if not given.table:
        seeds = range(1, given.seeds + 1)
        varied = (given.rolling, given.families, given.ratios, given.solvers)
        texts = ([given.options], [given.material])
        runs = [Run(*values) for values in product(seeds, given.tests, *varied, *texts)]
        measure(runs, given.kept, record_of)
    print("\n".join(table(read(given.kept, Run))))


if __name__ == "__main__":
    main()
