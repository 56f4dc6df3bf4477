"""Measure how the responses of bulk tests change with the factor of coarse graining, on LAMMPS.

Finished runs are kept in the file ``--kept`` and not repeated, so that the command can be stopped
and started again.

    python benchmarks/coarse_graining.py --kept coarse.jsonl [--seeds 5]
        [--tests heap draw_down discharge] [--factors 1 1.5 2 2.5] [--table]

Particles of 5 mm are simulated in the default geometry of 10 mm particles, so that a factor of 2
is the default test. Prints the mean of each response with its standard error, its deviation from
the real particles, and the processor time of a run.
"""

from __future__ import annotations

import argparse
import os
from collections.abc import Iterator, Mapping
from itertools import product
from pathlib import Path
from typing import Any, NamedTuple

os.environ["OMP_NUM_THREADS"] = "1"

import numpy as np

import kept_runs
from grainfit.bulk_tests.base import BulkTest
from grainfit.bulk_tests.registry import bulk_tests
from grainfit.errors import InputError
from grainfit.formatting import number
from grainfit.materials.sizes import ParticleSizes
from grainfit.options.kinds import Quantity
from grainfit.solvers.dem.lammps.program import Lammps
from grainfit.testing.materials import ROUGH_PLATE, ROUGH_SPHERES

REAL = ParticleSizes((0.005,))
USUAL = ParticleSizes((0.010,))
#: Without rolling dashpots, which the solvers implement in different ways.
MATERIAL = {
    **ROUGH_SPHERES,
    "particle.youngs_modulus": 1e6,
    "particle_particle.rolling_damping": 0.0,
    "particle_wall.rolling_damping": 0.0,
}


#: On a floor as smooth as the walls the foot of a pile slides outward, the more the higher it is in
#: diameters, and its angle is that of the floor.
ROUGH_FLOOR = {"floor_sliding_friction": 0.5, "floor_rolling_friction": 0.5}


class Run(NamedTuple):
    """What is varied, in the order of the records."""

    seed: int
    test: str
    factor: float


def test_of(run: Run) -> BulkTest:
    """Return a test of coarse-grained particles in the apparatus of 10 mm particles."""
    kind = bulk_tests()[run.test]
    usual = kind(USUAL)
    units = {k.name: k.kind.unit for k in kind.option_keys() if isinstance(k.kind, Quantity)}
    apparatus = {
        name: value
        for name, value in usual.resolved_options().items()
        if units.get(name) in ("m", "m/s") and value is not None
    }
    rough = {"draw_down": ROUGH_FLOOR, "heap": ROUGH_PLATE}.get(run.test, {})
    return kind(REAL.coarse_grained(run.factor), **apparatus, **rough)


def simulate(run: Run) -> dict[str, Any]:
    """Simulate once; return the responses, or the reason of a failure, and processor time."""
    try:
        test = test_of(run)
    except InputError as error:
        return {"why": str(error)}
    record = kept_runs.simulate(Lammps(test, MATERIAL), run.seed)
    return record | {"particles": test.number_of_particles}


def table(records: Mapping[Run, dict[str, Any]]) -> Iterator[str]:
    """Yield the lines of the table in Markdown, one for every test, response and factor."""
    yield "| test | response | factor | runs | mean ± standard error | deviation | CPU s |"
    yield "|---|---|---|---|---|---|---|"
    for test in dict.fromkeys(run.test for run in records):
        own = {run: r for run, r in records.items() if run.test == test and "responses" in r}
        for name in next(iter(own.values()))["responses"]:
            for factor in sorted({run.factor for run in own}):
                yield _row(test, name, factor, own)
    for run, record in records.items():
        if "why" in record:
            yield f"{run}: {record['why']}"


def _row(test: str, name: str, factor: float, records: Mapping[Run, dict[str, Any]]) -> str:
    values = _values(name, factor, records)
    real = _values(name, 1.0, records)
    seconds = [r["seconds"] for run, r in records.items() if run.factor == factor]
    change = 100 * (np.mean(values) / np.mean(real) - 1) if real else np.nan
    error = np.std(values, ddof=1) / np.sqrt(len(values)) if len(values) > 1 else np.nan
    return (
        f"| {test} | {name} | {factor:g} | {len(values)} "
        f"| {number(float(np.mean(values)))} ± {number(float(error), 2)} "
        f"| {change:+.1f} % | {number(float(np.median(seconds)), 2)} |"
    )


def _values(name: str, factor: float, records: Mapping[Run, dict[str, Any]]) -> list[float]:
    return [r["responses"][name] for run, r in records.items() if run.factor == factor]


def main() -> None:
    """Run, and print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--kept", type=Path, required=True)
    parser.add_argument("--seeds", type=int, default=5)
    tests = ["heap", "draw_down", "discharge"]
    parser.add_argument("--tests", nargs="+", choices=bulk_tests(), default=tests)
    parser.add_argument("--factors", nargs="+", type=float, default=[1.0, 1.5, 2.0, 2.5])
    parser.add_argument("--table", action="store_true", help="only print what is known")
    given = parser.parse_args()
    if not given.table:
        seeds = range(1, given.seeds + 1)
        runs = [Run(*values) for values in product(seeds, given.tests, given.factors)]
        kept_runs.measure(runs, given.kept, simulate)
    print("\n".join(table(kept_runs.read(given.kept, Run))))


if __name__ == "__main__":
    main()
