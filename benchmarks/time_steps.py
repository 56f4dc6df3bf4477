"""Find the largest safe time step of every rolling model, on LAMMPS and on LIGGGHTS.

Finished runs are kept in the file ``--kept`` and not repeated, so that the command can be stopped
and started again.

    python benchmarks/time_steps.py --kept steps.jsonl [--seeds 3] [--tests heap packing]
        [--models epsd2 epsd "epsd 0.25"] [--fractions 0.12 0.16 0.2 0.25 0.3]
        [--sliding 0.5] [--frictions 0.2 1] [--restitutions 0.6] [--moduli 0.36e6] [--table]

``"epsd 0.25"`` is EPSD with a rolling damping of 0.25, ``epsd`` the same without; ``"linear epsd"``
has linear springs. Prints, for each
setting and solver, how many runs at each share of the Rayleigh time step gave responses, and the
mean of each response with its standard error, and its difference from the shortest step.
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


class Run(NamedTuple):
    """What is varied, in the order of the records."""

    seed: int
    test: str
    sliding_friction: float
    rolling_friction: float
    restitution: float
    youngs_modulus: float
    model: str
    fraction: float
    solver: str


def material_of(run: Run) -> Mapping[str, float]:
    """Return rough spheres with rolling friction, rolling damping and restitution of a run."""
    *_, damping = ["0", *(word for word in run.model.split() if not word.isidentifier())]
    rest = {k: v for k, v in ROUGH_SPHERES.items() if not k.endswith("rolling_damping")}
    contacts = ("particle_particle", "particle_wall")
    has_dashpot = "epsd" in run.model.split()
    dashpot = {f"{c}.rolling_damping": float(damping) for c in contacts if has_dashpot}
    bounce = {f"{c}.restitution": run.restitution for c in contacts}
    changes = {**dashpot, **bounce, "particle.youngs_modulus": run.youngs_modulus}
    friction = {
        "particle_particle.sliding_friction": run.sliding_friction,
        "particle_particle.rolling_friction": run.rolling_friction,
    }
    return {**rest, **changes, **friction}


def record_of(run: Run) -> dict[str, Any]:
    """Simulate a run."""
    test = bulk_tests()[run.test](
        diameter="10 mm",
        **(ROUGH_PLATE if run.test == "heap" else {}),
        time_step_fraction=run.fraction,
    )
    chosen = [word for word in run.model.split() if word.isidentifier()]
    program = DEM_PROGRAMS[run.solver](test, material_of(run), contact_models=chosen)
    return simulate(program, run.seed)


def table(records: Mapping[Run, dict[str, Any]]) -> Iterator[str]:
    """Yield the lines of the table in Markdown, one for every setting and response."""
    yield (
        "| test | sliding, rolling friction | e | E, MPa | model | solver | time step | runs "
        "| response | mean | difference from the shortest step | over the scatter of a run "
        "| CPU s |"
    )
    yield "|---" * 13 + "|"
    settings = dict.fromkeys(run._replace(seed=0) for run in sorted(records))
    for setting in settings:
        own = _of(records, setting)
        shortest = min(
            s.fraction for s in settings if s._replace(fraction=0) == setting._replace(fraction=0)
        )
        first = _of(records, setting._replace(fraction=shortest))
        seconds = number(float(np.mean([r["seconds"] for r in own])), 2)
        good = [r["responses"] for r in own if "responses" in r]
        for name in good[0] if good else ():
            values = [r[name] for r in good]
            others = [r["responses"][name] for r in first if "responses" in r]
            yield (
                f"| {setting.test} | {setting.sliding_friction:g}, {setting.rolling_friction:g} "
                f"| {setting.restitution:g} | {setting.youngs_modulus / 1e6:g} | {setting.model} "
                f"| {setting.solver} | {setting.fraction:.0%} | {len(good)} of {len(own)} | {name} "
                f"| {mean_and(_error, values)} | {_difference(values, others)} | {seconds} |"
            )


def _of(records: Mapping[Run, dict[str, Any]], setting: Run) -> list[dict[str, Any]]:
    return [record for run, record in records.items() if run._replace(seed=0) == setting]


def _difference(values: Sequence[float], others: Sequence[float]) -> str:
    """Difference of the means with its 95 % interval, and both over the scatter of one run."""
    if values == others or min(len(values), len(others)) < 2:
        return " | "
    error = 1.96 * float(np.hypot(_error(values), _error(others)))
    scatter = float(np.sqrt((np.var(values, ddof=1) + np.var(others, ddof=1)) / 2))
    found = float(np.mean(values) - np.mean(others))
    half = number(error, 2)
    return f"{number(found, 2)} ± {half} | {found / scatter:+.2f} ± {error / scatter:.2f}"


def _error(values: Sequence[float]) -> float:
    return float(np.std(values, ddof=1) / np.sqrt(len(values)))


def main() -> None:
    """Run, and print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--kept", type=Path, required=True)
    parser.add_argument("--seeds", type=int, default=3)
    parser.add_argument("--tests", nargs="+", choices=bulk_tests(), default=["heap", "packing"])
    parser.add_argument("--models", nargs="+", default=list(MODELS))
    parser.add_argument("--sliding", nargs="+", type=float, default=[0.5])
    parser.add_argument("--frictions", nargs="+", type=float, default=list(ROLLING_FRICTIONS))
    parser.add_argument("--restitutions", nargs="+", type=float, default=[0.6])
    parser.add_argument("--moduli", nargs="+", type=float, default=[0.36e6], help="Pa")
    parser.add_argument("--fractions", nargs="+", type=float, default=list(FRACTIONS))
    parser.add_argument("--solvers", nargs="+", choices=SOLVERS, default=list(SOLVERS))
    parser.add_argument("--table", action="store_true", help="only print what is known")
    given = parser.parse_args()
    if not given.table:
        seeds = range(1, given.seeds + 1)
        varied = (
            given.sliding,
            given.frictions,
            given.restitutions,
            given.moduli,
            given.models,
            given.fractions,
        )
        settings = product(seeds, given.tests, *varied, given.solvers)
        measure([Run(*values) for values in settings], given.kept, record_of)
    print("\n".join(table(read(given.kept, Run))))


if __name__ == "__main__":
    main()
