"""Calibrations of the fresh materials of `atlas_fresh.py` on LAMMPS, with the atlas and without.

A material in its random apparatus is measured by the mean of its 20 runs: the bulk density to 1 %,
the angle of repose to 1 degree. Both frictions are free over the whole range of the atlas, and the
density of the particles within 20 %. The cheapest materials come first. Finished calibrations are
kept in a file of JSON lines.

    python benchmarks/atlas_calibrations.py --kept FILE [--fresh benchmarks/data/atlas_fresh.jsonl]
        [--materials 8] [--seeds 2] [--processes 1] [--table]

Prints a table in Markdown: runs with and without the atlas, and how many the limit of a known
scatter would be, (2 scatter / tolerance)^2 and at least 3.
"""

from __future__ import annotations

import argparse
import math
import os
import sys
from collections.abc import Iterator, Mapping
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path
from statistics import mean, median
from typing import Any, NamedTuple

os.environ["OMP_NUM_THREADS"] = "1"

import numpy as np

from atlas_fresh import Run as FreshRun
from atlas_fresh import fresh_rows
from atlas_rows import point
from grainfit.atlas.strata import Stratum, strata
from grainfit.bulk_tests.parameter_names import DENSITY, ROLLING, SLIDING
from grainfit.calibration.calibrate import calibrate
from grainfit.errors import GrainfitError
from grainfit.problem import Parameter, Problem, Target
from grainfit.solvers.dem.lammps.program import Lammps
from kept_runs import read, scatter, write

TOLERANCES = {"bulk_density": 0.01, "angle_of_repose": 1.0}
_FREE = (SLIDING, ROLLING, DENSITY)
_FEWEST = 3


class Run(NamedTuple):
    """One calibration: number of the material, seed, whether the atlas guides it."""

    material: int
    seed: int
    atlas: bool


def _heap() -> Stratum:
    return strata()["heap"]


def measured(fresh: Path, number: int) -> dict[str, list[float]]:
    """Return the responses of all runs of a material."""
    records = [r for run, r in read(fresh, FreshRun).items() if run.number == number]
    found = [
        one["responses"] for one in records if TOLERANCES.keys() <= one.get("responses", {}).keys()
    ]
    return {name: [one[name] for one in found] for name in TOLERANCES}


def materials(fresh: Path) -> list[int]:
    """Return the numbers of the materials, those with the cheapest runs first."""
    seconds = {
        row.number: mean(
            r["seconds"] for run, r in read(fresh, FreshRun).items() if run.number == row.number
        )
        for row in fresh_rows(fresh, _heap())
    }
    return sorted(seconds, key=seconds.__getitem__)


def tolerances(values: Mapping[str, list[float]]) -> dict[str, float]:
    """Return the tolerances of the measured means, SI."""
    return {
        "bulk_density": TOLERANCES["bulk_density"] * mean(values["bulk_density"]),
        "angle_of_repose": 1.0,
    }


def record_of(run: Run, fresh: Path) -> dict[str, Any]:
    """Calibrate once."""
    stratum, values = _heap(), measured(fresh, run.material)
    test, material = stratum.simulated(point(stratum, run.material))
    allowed = tolerances(values)
    problem = Problem(
        [
            *(
                Parameter(n, stratum.ranges[n].low, stratum.ranges[n].high, "log")
                for n in (SLIDING, ROLLING)
            ),
            Parameter(DENSITY, 0.8 * material[DENSITY], 1.2 * material[DENSITY]),
        ],
        [Target(name, mean(values[name]), uncertainty=allowed[name]) for name in TOLERANCES],
    )
    fixed = {name: one for name, one in material.items() if name not in _FREE}
    try:
        result = calibrate(
            problem, {"heap": Lammps(test, fixed)}, seed=run.seed, atlas=run.atlas, near_runs=False
        )
    except GrainfitError as error:
        return {"status": "failed", "why": str(error)}
    held = {
        name: result.intervals[name].low <= material[name] <= result.intervals[name].high
        for name in _FREE
        if name in result.intervals
    }
    return {"runs": result.runs.total, "status": result.status, "held": held}


def table(records: Mapping[Run, dict[str, Any]], fresh: Path) -> Iterator[str]:
    """Yield the lines of the table."""
    yield "| material | limit | runs without | runs with the atlas | called |"
    yield "|---" * 5 + "|"
    for number in dict.fromkeys(run.material for run in records):
        values = measured(fresh, number)
        limits = [(2 * scatter(values[n]) / one) ** 2 for n, one in tolerances(values).items()]
        own = {run: r for run, r in records.items() if run.material == number}
        runs = {
            atlas: ", ".join(
                str(r.get("runs", "-")) for run, r in own.items() if run.atlas == atlas
            )
            for atlas in (False, True)
        }
        called = ", ".join(dict.fromkeys(r["status"] for r in own.values()))
        limit = max(_FEWEST, math.ceil(max(limits)))
        yield f"| {number} | {limit} | {runs[False]} | {runs[True]} | {called} |"
    differences = [
        r["runs"] - other["runs"]
        for run, r in records.items()
        if run.atlas
        and (other := records.get(run._replace(atlas=False)))
        and "runs" in r
        and "runs" in other
    ]
    if len(differences) > 1:
        error = np.std(differences, ddof=1) / math.sqrt(len(differences))
        yield f"| runs with less those without | | | {np.mean(differences):+.1f} ± {error:.1f} | |"
    for atlas in (False, True):
        own_runs = [r["runs"] for run, r in records.items() if run.atlas == atlas and "runs" in r]
        held = [
            one
            for run, r in records.items()
            if run.atlas == atlas
            for one in r.get("held", {}).values()
        ]
        if own_runs:
            high = np.quantile(own_runs, 0.9)
            yield (
                f"| atlas: {atlas} | | median {median(own_runs):g} | 90 %: {high:.0f} "
                f"| {sum(held)} of {len(held)} intervals hold the truth |"
            )


def main() -> None:
    """Calibrate what is missing, and print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--kept", type=Path, required=True)
    parser.add_argument("--fresh", type=Path, default=Path("benchmarks/data/atlas_fresh.jsonl"))
    parser.add_argument("--materials", type=int, default=8)
    parser.add_argument("--seeds", type=int, default=2)
    parser.add_argument("--processes", type=int, default=1)
    parser.add_argument("--table", action="store_true", help="only print what is known")
    given = parser.parse_args()
    if not given.table:
        known = read(given.kept, Run)
        missing = [
            run
            for number in materials(given.fresh)[: given.materials]
            for seed in range(1, given.seeds + 1)
            for atlas in (False, True)
            if (run := Run(number, seed, atlas)) not in known
        ]
        with ProcessPoolExecutor(given.processes) as pool:
            done = pool.map(record_of, missing, [given.fresh] * len(missing))
            write(given.kept, zip(missing, done, strict=True))
    print("\n".join(table(read(given.kept, Run), given.fresh)), file=sys.stdout)


if __name__ == "__main__":
    main()
