"""Measure how the responses of a bulk test follow the material, as a check of the atlas.

About two materials, of sliding and rolling friction 0.5 and 0.2, and 0.2 and 0.5, a 2^(6-2) design
of 16 runs and five runs in the centre vary density, Young's modulus, both frictions, the friction
on the wall and the restitution; a regression on logarithms gives the slopes d ln y / d ln p with
their standard errors, and the scatter of a run. Finished runs are kept in the file ``--kept`` and
not repeated, so that the command can be stopped and started again.

    python benchmarks/slopes.py --kept benchmarks/data/slopes.jsonl [--tests funnel ...]
        [--materials 1] [--table]

Prints every slope beyond three standard errors, the scatter and the failed runs.
"""

from __future__ import annotations

import argparse
import itertools
import math
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from grainfit.bulk_tests.abilities import options_for
from grainfit.bulk_tests.registry import bulk_tests
from grainfit.bulk_tests.time_steps import with_safe_time_step
from grainfit.solvers.dem.lammps.program import Lammps
from kept_runs import measure, read, simulate
from size_series import DIAMETER, material_of

#: Factor of each parameter between the centre and either end, and the signs of its column in the
#: design as products of the four basic columns.
FACTORS = {
    "particle.density": (1.3, (0,)),
    "particle.youngs_modulus": (2.0, (1,)),
    "particle_particle.sliding_friction": (1.5, (2,)),
    "particle_particle.rolling_friction": (2.0, (3,)),
    "particle_wall.sliding_friction": (1.5, (0, 1, 2)),
    "particle_particle.restitution": (1.25, (1, 2, 3)),
}
#: Sliding and rolling friction of the two materials.
MATERIALS = ((0.5, 0.2), (0.2, 0.5))
CENTRES = 5
_CLEAR = 3.0


class Run(NamedTuple):
    """What is varied: test, material (0 or 1), and number of the run in the design."""

    test: str
    material: int
    number: int


def design() -> np.ndarray:
    """Return the signs of all runs, one column for each parameter; the last runs are centres."""
    basic = np.array(list(itertools.product((-1, 1), repeat=4)))
    columns = [np.prod(basic[:, list(which)], axis=1) for _, which in FACTORS.values()]
    return np.vstack((np.column_stack(columns), np.zeros((CENTRES, len(columns)))))


def record_of(run: Run) -> dict[str, Any]:
    """Simulate once; all runs of a design have the time step that suits all of them."""
    sliding, rolling = MATERIALS[run.material]
    base = {
        **material_of(run.test),
        "particle_particle.sliding_friction": sliding,
        "particle_particle.rolling_friction": rolling,
    }
    ends = {name: (value, value) for name, value in base.items()}
    ends |= {n: (base[n] / factor, base[n] * factor) for n, (factor, _) in FACTORS.items()}
    kind = bulk_tests()[run.test]
    test = with_safe_time_step(kind(diameter=DIAMETER, **options_for(kind, base)), ends)
    signs = design()[run.number]
    varied = {
        name: base[name] * factor**sign
        for (name, (factor, _)), sign in zip(FACTORS.items(), signs, strict=True)
    }
    return simulate(Lammps(test, {**base, **varied}), 1 + run.number)


def lines(records: Mapping[Run, dict[str, Any]]) -> Iterator[str]:
    """Yield a line for every response and material: its slopes, scatter and failures."""
    for test, material in sorted({(run.test, run.material) for run in records}):
        own = {run.number: r for run, r in records.items() if run[:2] == (test, material)}
        good = {number: r["responses"] for number, r in own.items() if "responses" in r}
        yield f"{test}, frictions {MATERIALS[material]}: {len(good)} of {len(own)} runs"
        yield from (f"  {number}: {r['why']}" for number, r in own.items() if "why" in r)
        for name in bulk_tests()[test].responses:
            values = {n: r[name] for n, r in good.items() if r.get(name, 0.0) > 0}
            if len(values) > len(FACTORS) + 2:
                yield f"  {name}: {_slopes(values)}"


def _slopes(values: Mapping[int, float]) -> str:
    spans = np.array([math.log(factor) for factor, _ in FACTORS.values()])
    rows = design()[list(values)] * spans
    matrix = np.column_stack((np.ones(len(rows)), rows))
    logs = np.log(list(values.values()))
    found, *_ = np.linalg.lstsq(matrix, logs, rcond=None)
    freedom = len(logs) - matrix.shape[1]
    scatter = math.sqrt(float(((logs - matrix @ found) ** 2).sum()) / freedom)
    errors = scatter * np.sqrt(np.diag(np.linalg.inv(matrix.T @ matrix)))
    shown = [
        f"{name} {slope:+.3g} ± {error:.2g}"
        for name, slope, error in zip(FACTORS, found[1:], errors[1:], strict=True)
        if abs(slope) > _CLEAR * error
    ]
    centres = [v for n, v in values.items() if n >= len(design()) - CENTRES]
    repeats = float(np.std(centres, ddof=1) / np.mean(centres)) if len(centres) > 1 else math.nan
    return f"{', '.join(shown) or 'nothing'}; scatter {scatter:.2%}, of centre runs {repeats:.2%}"


def main() -> None:
    """Make the runs that are missing, and print the slopes."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--kept", type=Path, required=True)
    parser.add_argument("--tests", nargs="+", default=["funnel"], choices=list(bulk_tests()))
    parser.add_argument("--materials", type=int, nargs="+", default=[0, 1])
    parser.add_argument("--table", action="store_true", help="only print what is known")
    given = parser.parse_args()
    if not given.table:
        numbers = range(len(design()))
        measure(
            [Run(t, m, n) for t in given.tests for m in given.materials for n in numbers],
            given.kept,
            record_of,
        )
    print("\n".join(lines(read(given.kept, Run))))


if __name__ == "__main__":
    main()
