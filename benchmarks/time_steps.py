"""Find the largest safe time step of every rolling model, on LAMMPS and on LIGGGHTS.

Finished runs are kept in the file ``--kept`` and not repeated, so that the command can be stopped
and started again.

    python benchmarks/time_steps.py --kept steps.jsonl [--seeds 3] [--tests heap packing]
        [--models epsd2 epsd "epsd 0.25"] [--fractions 0.12 0.16 0.2 0.25 0.3]
        [--frictions 0.2 1] [--restitutions 0.6] [--table]

``"epsd 0.25"`` is EPSD with a rolling damping of 0.25, ``epsd`` the same without. Prints, for each
setting and solver, how many runs at each share of the Rayleigh time step gave responses, and the
mean of each response with its standard error.
"""

from __future__ import annotations

import argparse
import os
from collections.abc import Iterator, Mapping, Sequence
from itertools import product
from pathlib import Path
from typing import Any, NamedTuple

os.environ["OMP_NUM_THREADS"] = "1"

import numpy as np

from grainfit.bulk_tests.registry import bulk_tests
from grainfit.formatting import number
from grainfit.solvers.registry import DEM_PROGRAMS
from grainfit.testing.materials import ROUGH_PLATE, ROUGH_SPHERES
from kept_runs import mean_and, measure, read, simulate

SOLVERS = ("lammps", "liggghts")
MODELS = ("epsd2", "epsd", "epsd 0.25")
FRACTIONS = (0.12, 0.16, 0.2, 0.25, 0.3)
ROLLING_FRICTIONS = (0.2, 1.0)
#: A test that needs another modulus than the others, Pa.
MODULI = {"compression": 10e6}


class Run(NamedTuple):
    """What is varied, in the order of the records."""

    seed: int
    test: str
    rolling_friction: float
    restitution: float
    model: str
    fraction: float
    solver: str


def material_of(run: Run) -> Mapping[str, float]:
    """Return rough spheres with rolling friction, rolling damping and restitution of a run."""
    name, _, damping = run.model.partition(" ")
    rest = {k: v for k, v in ROUGH_SPHERES.items() if not k.endswith("rolling_damping")}
    contacts = ("particle_particle", "particle_wall")
    dashpot = {f"{c}.rolling_damping": float(damping or 0) for c in contacts if name == "epsd"}
    bounce = {f"{c}.restitution": run.restitution for c in contacts}
    modulus = MODULI.get(run.test, rest["particle.youngs_modulus"])
    changes = {**dashpot, **bounce, "particle.youngs_modulus": modulus}
    return {**rest, **changes, "particle_particle.rolling_friction": run.rolling_friction}


def record_of(run: Run) -> dict[str, Any]:
    """Simulate a run."""
    test = bulk_tests()[run.test](
        diameter="10 mm",
        **(ROUGH_PLATE if run.test == "heap" else {}),
        time_step_fraction=run.fraction,
    )
    chosen = [run.model.partition(" ")[0]]
    program = DEM_PROGRAMS[run.solver](test, material_of(run), contact_models=chosen)
    return simulate(program, run.seed)


def table(records: Mapping[Run, dict[str, Any]]) -> Iterator[str]:
    """Yield the lines of the table in Markdown, one for every setting."""
    yield "| test | μ_r | e | model | solver | time step | responses from | means | CPU s |"
    yield "|---|---|---|---|---|---|---|---|---|"
    settings = dict.fromkeys(run._replace(seed=0) for run in sorted(records))
    for setting in settings:
        own = [r for run, r in records.items() if run._replace(seed=0) == setting]
        good = [r["responses"] for r in own if "responses" in r]
        names = good[0] if good else ()
        means = ", ".join(f"{name} {mean_and(_error, [r[name] for r in good])}" for name in names)
        _, test, friction, restitution, model, fraction, solver = setting
        seconds = number(float(np.median([r["seconds"] for r in own])), 2)
        yield (
            f"| {test} | {friction} | {restitution} | {model} | {solver} | {fraction:.0%} "
            f"| {len(good)} of {len(own)} | {means} | {seconds} |"
        )


def _error(values: Sequence[float]) -> float:
    return float(np.std(values, ddof=1) / np.sqrt(len(values)))


def main() -> None:
    """Run, and print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--kept", type=Path, required=True)
    parser.add_argument("--seeds", type=int, default=3)
    parser.add_argument("--tests", nargs="+", choices=bulk_tests(), default=["heap", "packing"])
    parser.add_argument("--models", nargs="+", default=list(MODELS))
    parser.add_argument("--frictions", nargs="+", type=float, default=list(ROLLING_FRICTIONS))
    parser.add_argument("--restitutions", nargs="+", type=float, default=[0.6])
    parser.add_argument("--fractions", nargs="+", type=float, default=list(FRACTIONS))
    parser.add_argument("--solvers", nargs="+", choices=SOLVERS, default=list(SOLVERS))
    parser.add_argument("--table", action="store_true", help="only print what is known")
    given = parser.parse_args()
    if not given.table:
        seeds = range(1, given.seeds + 1)
        varied = (given.frictions, given.restitutions, given.models, given.fractions)
        settings = product(seeds, given.tests, *varied, given.solvers)
        measure([Run(*values) for values in settings], given.kept, record_of)
    print("\n".join(table(read(given.kept, Run))))


if __name__ == "__main__":
    main()
