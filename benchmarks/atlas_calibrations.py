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
from atlas_guide import FREE, RESPONSES, problem_of
from atlas_rows import point
from grainfit.atlas.strata import Stratum, strata
from grainfit.calibration.calibrate import calibrate
from grainfit.errors import GrainfitError
from grainfit.problem import Problem
from grainfit.solvers.dem.lammps.program import Lammps
from kept_runs import read, scatter, standard_error, write

_ANGLE = 1.0
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
    found = [r["responses"] for r in records if r.get("responses", {}).keys() >= {*RESPONSES}]
    return {name: [one[name] for one in found] for name in RESPONSES}


def materials(fresh: Path) -> list[int]:
    """Return the numbers of the materials, those with the cheapest runs first."""
    records = read(fresh, FreshRun)
    seconds = {
        row.number: mean(r["seconds"] for run, r in records.items() if run.number == row.number)
        for row in fresh_rows(fresh, _heap())
    }
    return sorted(seconds, key=seconds.__getitem__)


def problem_in(fresh: Path, number: int) -> Problem:
    """Return the problem of a material, measured by the means of its runs."""
    stratum = _heap()
    _, material = stratum.simulated(point(stratum, number))
    means = {name: mean(values) for name, values in measured(fresh, number).items()}
    return problem_of(stratum, material, means, _ANGLE)


def record_of(run: Run, fresh: Path) -> dict[str, Any]:
    """Calibrate once."""
    stratum = _heap()
    test, material = stratum.simulated(point(stratum, run.material))
    problem = problem_in(fresh, run.material)
    fixed = {name: one for name, one in material.items() if name not in FREE}
    try:
        result = calibrate(
            problem, {"heap": Lammps(test, fixed)}, seed=run.seed, atlas=run.atlas, near_runs=False
        )
    except GrainfitError as error:
        return {"status": "failed", "why": str(error)}
    held = {
        name: result.intervals[name].low <= material[name] <= result.intervals[name].high
        for name in FREE
        if name in result.intervals
    }
    return {"runs": result.runs.total, "status": result.status, "held": held}


def table(records: Mapping[Run, dict[str, Any]], fresh: Path) -> Iterator[str]:
    """Yield the lines of the table."""
    yield "| material | limit | runs without | runs with the atlas | called |"
    yield "|---" * 5 + "|"
    for number in dict.fromkeys(run.material for run in records):
        values = measured(fresh, number)
        targets = problem_in(fresh, number).targets
        limits = [(2 * scatter(values[one.name]) / one.tolerance) ** 2 for one in targets]
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
        error = standard_error(differences)
        yield f"| runs with less those without | | | {mean(differences):+.1f} ± {error:.1f} | |"
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
