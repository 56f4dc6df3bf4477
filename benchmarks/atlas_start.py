"""Runs until the verdict with and without a start where the atlas expects the answer.

The truth is the metamodel of a heap that all rows of the atlas give, with its scatter from run to
run; the atlas that estimates has a random half of the rows, so that it errs as an atlas does.
Materials are rows of the other half: both frictions and the density of the particles are free in
wide intervals, the bulk density is measured to 1 %, the angle of repose to ``--angle`` degrees.
``--wrong`` shifts what the estimating atlas is told by three tolerances. The start "truth" is
within 7 % of the true parameters: no atlas can know more.

    python benchmarks/atlas_start.py --kept FILE [--materials 20] [--angle 1] [--wrong] [--table]

Prints a table in Markdown: calibrations, runs in the median and the 90th percentile, verdicts, and
how many of those called calibrated miss a target in truth.
"""

from __future__ import annotations

import argparse
import math
import tempfile
from collections.abc import Iterator, Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from atlas_estimates import atlas_of
from grainfit.atlas.estimate import estimate_of
from grainfit.atlas.reading import Reading
from grainfit.atlas.row import rows_in
from grainfit.atlas.shelf import SHIPPED, Surrogate
from grainfit.atlas.strata import strata
from grainfit.bulk_tests.parameter_names import DENSITY, ROLLING, SLIDING
from grainfit.calibration.calibrate import calibrate
from grainfit.errors import InputError
from grainfit.problem import Parameter, Problem, Target
from grainfit.solvers.dem.lammps.program import Lammps
from kept_runs import measure, read

RESPONSES = ("bulk_density", "angle_of_repose")
_FREE = (SLIDING, ROLLING, DENSITY)
_STARTS = ("all over", "atlas", "truth")
_SHIFT = 3.0
_NEAR_TRUTH = 0.07


class Run(NamedTuple):
    """What is varied: number of the material, start, tolerance of the angle, wrong atlas."""

    material: int
    start: str
    angle: float
    wrong: bool


class Trial:
    """The truth, the atlas of half of the rows, and the materials."""

    def __init__(self, folder: Path) -> None:
        self.stratum = strata()["heap"]
        rows = rows_in(SHIPPED / "heap.jsonl")
        self.truth = Surrogate(self.stratum, rows)
        halves = np.random.default_rng(5).permutation(len(rows)) % 2
        self.atlas = atlas_of(
            self.stratum, [r for r, h in zip(rows, halves, strict=True) if h], folder
        )
        self.materials = [
            row
            for row, half in zip(rows, halves, strict=True)
            if not half and set(RESPONSES) <= row.responses.keys()
        ]

    def record_of(self, run: Run) -> dict[str, Any]:
        """Calibrate once."""
        row = self.materials[run.material]
        test, material = self.stratum.simulated(row.inputs)
        ranges = self.stratum.ranges
        fixed = {name: one for name, one in material.items() if name not in _FREE}
        solver = Lammps(test, fixed)
        reading = Reading(solver, material)

        def at(parameters: Mapping[str, float]) -> dict[str, tuple[float, float]]:
            values = {name: np.array([one]) for name, one in parameters.items()}
            shares = reading.shares(values)
            return {
                name: (
                    float((self.truth.models[name].predict(shares)[0] * unit).item()),
                    float((self.truth.models[name].scatter(shares) * unit).item()),
                )
                for name in RESPONSES
                for unit in [reading.unit(name, values)]
            }

        def simulate(parameters: dict[str, float], seed: int) -> dict[str, float]:
            random = np.random.default_rng(seed)
            return {n: m + s * random.standard_normal() for n, (m, s) in at(parameters).items()}

        true = at({name: material[name] for name in _FREE})
        tolerances = {"bulk_density": 0.01 * true["bulk_density"][0], "angle_of_repose": run.angle}
        targets = [Target(n, true[n][0], uncertainty=tolerances[n]) for n in RESPONSES]
        problem = Problem(
            [
                *(Parameter(n, ranges[n].low, ranges[n].high, "log") for n in (SLIDING, ROLLING)),
                Parameter(DENSITY, 0.8 * material[DENSITY], 1.2 * material[DENSITY]),
            ],
            targets,
        )
        expected: Mapping[str, tuple[float, float]] = {}
        if run.start == "truth":
            expected = {
                one.name: (
                    max(one.minimum, (1 - _NEAR_TRUTH) * material[one.name]),
                    min(one.maximum, (1 + _NEAR_TRUTH) * material[one.name]),
                )
                for one in problem.parameters
            }
        elif run.start == "atlas":
            shift = _SHIFT if run.wrong else 0.0
            told = [
                Target(n, true[n][0] + shift * tolerances[n], uncertainty=tolerances[n])
                for n in RESPONSES
            ]
            told_problem = Problem(problem.parameters, told)
            with suppress(InputError):
                found = estimate_of(told_problem, {"heap": solver}, self.atlas)
                expected = found.expected_intervals()
        problem = Problem(problem.parameters, targets, expected=expected)
        result = calibrate(problem, simulate, seed=run.material + 1)
        met = problem.is_met_by([at(result.parameters)[n][0] for n in RESPONSES])
        return {"runs": result.runs.total, "status": result.status, "met": met}


def table(records: Mapping[Run, dict[str, Any]]) -> Iterator[str]:
    """Yield the lines of the table."""
    yield (
        "| start | angle | calibrations | runs, median | 90 % | less those all over "
        "| calibrated | of these false |"
    )
    yield "|---" * 8 + "|"
    for start, angle, wrong in sorted({run[1:] for run in records}):
        own = [r for run, r in records.items() if run[1:] == (start, angle, wrong)]
        runs = [one["runs"] for one in own]
        called = [one for one in own if one["status"] == "calibrated"]
        yield (
            f"| {start}{', wrong' if wrong else ''} | \u00b1 {angle:g}\u00b0 | {len(own)} "
            f"| {np.median(runs):.0f} | {np.quantile(runs, 0.9):.0f} "
            f"| {_difference((start, angle, wrong), records)} | {len(called)} "
            f"| {sum(not one['met'] for one in called)} |"
        )


def _difference(kind: tuple[str, float, bool], records: Mapping[Run, dict[str, Any]]) -> str:
    """Return the mean difference of the runs to a start all over, with its standard error."""
    found = [
        record["runs"] - records[other]["runs"]
        for run, record in records.items()
        if run[1:] == kind
        and (other := run._replace(start="all over", wrong=False)) != run
        and other in records
    ]
    if len(found) < 2:
        return ""
    return f"{np.mean(found):+.1f} ± {np.std(found, ddof=1) / math.sqrt(len(found)):.1f}"


def main() -> None:
    """Calibrate what is missing, and print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--kept", type=Path, required=True)
    parser.add_argument("--materials", type=int, default=20)
    parser.add_argument("--angle", type=float, default=1.0)
    parser.add_argument("--wrong", action="store_true")
    parser.add_argument("--table", action="store_true", help="only print what is known")
    given = parser.parse_args()
    if not given.table:
        with tempfile.TemporaryDirectory() as folder:
            trial = Trial(Path(folder))
            starts = ["atlas"] if given.wrong else _STARTS
            measure(
                [
                    Run(number, start, given.angle, given.wrong)
                    for number in range(min(given.materials, len(trial.materials)))
                    for start in starts
                ],
                given.kept,
                trial.record_of,
            )
    print("\n".join(table(read(given.kept, Run))))


if __name__ == "__main__":
    main()
