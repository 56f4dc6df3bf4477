"""Measure how the responses of each bulk test change with the size of its apparatus.

The particles stay the same; vessel, bed and plate become larger in all directions, so that they
hold 1, 4 and 10 times the particles. The outlet of the discharge keeps its width, and its mass flow
is that of a metre of depth; the slot of the draw-down becomes wider like its box, so that its mass
flow is not compared. Speeds follow by Froude's law, the shear by its inertial number. Finished runs
are kept in the file ``--kept`` and not repeated, so that the command can be stopped and started
again.

    python benchmarks/size_series.py --kept benchmarks/data/size_series.jsonl [--tests heap ...]
        [--seeds 8 4 3] [--times 1 4 10] [--moduli 3.6e5] [--table]

Prints each response at every size, its change from the smallest apparatus with two standard errors
(by the scatter in that one, which is the largest), and the processor time of a run. ``--seeds`` has
one number for each of ``--times``.
"""

from __future__ import annotations

import argparse
import math
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from grainfit.bulk_tests.base import BulkTest
from grainfit.bulk_tests.registry import bulk_tests
from grainfit.bulk_tests.size import resized
from grainfit.formatting import number
from grainfit.solvers.dem.lammps.program import Lammps
from grainfit.testing.materials import ROUGH_SPHERES, rough_plate_of
from kept_runs import measure, read, scatter, simulate

DIAMETER = 0.010
MODULUS = "particle.youngs_modulus"
#: Tests that were measured.
TESTS = ("compression", "discharge", "draw_down", "drum", "heap", "hopper", "packing", "shear")
#: Responses that are those of a metre of depth.
PER_DEPTH = (("discharge", "mass_flow"),)
#: Responses that are not compared.
OTHERS = (("draw_down", "mass_flow"), ("hopper", "residual_mass"))
#: A test that needs a stiffer material than the others, Pa.
STIFFER = {"compression": 10e6}


class Run(NamedTuple):
    """What is varied: test, seed, how many times the particles, the modulus in Pa."""

    test: str
    seed: int
    times: float
    modulus: float


def larger(test: str, times: float) -> BulkTest:
    """Return a test in an apparatus that holds so many times the particles."""
    return resized(bulk_tests()[test](diameter=DIAMETER, **rough_plate_of(test)), times)


def material_of(test: str, modulus: float = ROUGH_SPHERES[MODULUS]) -> Mapping[str, float]:
    """Return rough spheres without rolling damping."""
    damping = {f"particle_{partner}.rolling_damping": 0.0 for partner in ("particle", "wall")}
    return {**ROUGH_SPHERES, **damping, MODULUS: STIFFER.get(test, modulus)}


def record_of(run: Run) -> dict[str, Any]:
    """Simulate once."""
    test, material = larger(run.test, run.times), material_of(run.test, run.modulus)
    return {"particles": test.number_of_particles} | simulate(Lammps(test, material), run.seed)


def table(records: Mapping[Run, dict[str, Any]]) -> Iterator[str]:
    """Yield the lines of the table in Markdown, one for every response and size."""
    yield "| test | modulus, MPa | response | unit | particles | mean | change, % | CPU s a run |"
    yield "|---" * 8 + "|"
    for test, modulus in dict.fromkeys((run.test, run.modulus) for run in sorted(records)):
        own = {run: r for run, r in records.items() if (run.test, run.modulus) == (test, modulus)}
        sizes = sorted({run.times for run in own})
        for name, info in bulk_tests()[test].responses.items():
            first = _values(own, sizes[0], name)
            for times in sizes if (test, name) not in OTHERS else ():
                values = _values(own, times, name)
                if not values:
                    continue
                depth = math.cbrt(times) if (test, name) in PER_DEPTH else 1.0
                values = [value / depth for value in values]
                cells = [test, f"{modulus / 1e6:g}", name, info.unit or "1"]
                cells += [_mean(own, times, "particles", 0), number(float(np.mean(values)), 4)]
                cells += [_change(first, values) if times != sizes[0] else ""]
                cells += [_mean(own, times, "seconds", 1)]
                yield f"| {' | '.join(cells)} |"
        yield from (f"{run}: {r['why']}" for run, r in own.items() if "why" in r)


def _values(records: Mapping[Run, dict[str, Any]], times: float, name: str) -> list[float]:
    good = [r["responses"] for run, r in records.items() if run.times == times and "responses" in r]
    return [responses[name] for responses in good]


def _mean(records: Mapping[Run, dict[str, Any]], times: float, key: str, digits: int) -> str:
    values = [record[key] for run, record in records.items() if run.times == times]
    return f"{np.mean(values):.{digits}f}"


def _change(first: list[float], values: list[float]) -> str:
    """Return the relative change of a mean in per cent, with two standard errors."""
    mean = float(np.mean(first))
    error = scatter(first) * math.sqrt(1 / len(first) + 1 / len(values))
    change = float(np.mean(values)) - mean
    return f"{100 * change / mean:+.1f} ± {200 * error / mean:.1f}"


def main() -> None:
    """Make the runs that are missing, and print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--kept", type=Path, required=True)
    parser.add_argument("--tests", nargs="+", default=list(TESTS), choices=list(bulk_tests()))
    parser.add_argument("--times", type=float, nargs="+", default=[1, 4, 10])
    parser.add_argument("--seeds", type=int, nargs="+", default=[8, 4, 3])
    parser.add_argument("--moduli", type=float, nargs="+", default=[ROUGH_SPHERES[MODULUS]])
    parser.add_argument("--table", action="store_true", help="only print what is known")
    given = parser.parse_args()
    if len(given.seeds) != len(given.times):
        parser.error("--seeds needs one number for each of --times.")
    runs = [
        Run(test, seed, times, STIFFER.get(test, modulus))
        for times, seeds in zip(given.times, given.seeds, strict=True)
        for seed in range(1, seeds + 1)
        for test in given.tests
        for modulus in given.moduli
    ]
    if not given.table:
        first = sorted(dict.fromkeys(runs), key=lambda run: (run.seed, run.times))
        measure(first, given.kept, record_of)
    print("\n".join(table(read(given.kept, Run))))


if __name__ == "__main__":
    main()
