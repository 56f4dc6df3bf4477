"""Runs until the verdict with and without the atlas as a guide.

The truth is the metamodel of a heap that all rows of the atlas give; runs scatter about it as
recorded runs do, and fail as often as its rows say. The atlas that guides has a random half of the
rows, so that it errs as an atlas does. Materials are rows of the other half at which a run rarely
fails: both frictions and the density of the particles are free in wide intervals, the bulk density
is measured to 1 %, the angle of repose to ``--angle`` degrees. ``--wrong`` shifts what the guiding
atlas says by three tolerances. The guide "truth" is the metamodel itself: no atlas can know more.

    python benchmarks/atlas_guide.py --kept FILE [--materials 20] [--angle 1] [--wrong] [--table]

Prints a table in Markdown: calibrations, runs in the median and the 90th percentile, verdicts, and
how many of those called calibrated miss a target in truth.
"""

from __future__ import annotations

import argparse
import tempfile
from collections.abc import Iterator, Mapping
from pathlib import Path
from types import SimpleNamespace
from typing import Any, NamedTuple
from unittest.mock import patch

import numpy as np

from atlas_estimates import atlas_of
from grainfit.arrays import Array
from grainfit.atlas.expectation import relative_scatter
from grainfit.atlas.reading import Reading
from grainfit.atlas.row import rows_in
from grainfit.atlas.shelf import SHIPPED, Atlas
from grainfit.atlas.strata import Stratum, strata
from grainfit.atlas.surrogate import ResponseModel, Surrogate, least_chance, points_of
from grainfit.bulk_tests.parameter_names import DENSITY, ROLLING, SLIDING
from grainfit.calibration.calibrate import calibrate
from grainfit.errors import RunFailedError
from grainfit.evaluation import Response
from grainfit.problem import Parameter, Problem, Target
from grainfit.solvers.base import Workspace
from grainfit.solvers.dem.lammps.program import Lammps
from kept_runs import measure, read, standard_error

RESPONSES = ("bulk_density", "angle_of_repose")
FREE = (SLIDING, ROLLING, DENSITY)
_GUIDES = ("none", "atlas", "truth")
_SHIFT = 3.0
_RARELY_FAILS = 0.8


class Run(NamedTuple):
    """What is varied: number of the material, guide, tolerance of the angle, wrong atlas."""

    material: int
    guide: str
    angle: float
    wrong: bool


def problem_of(
    stratum: Stratum, material: Mapping[str, float], measured: Mapping[str, float], angle: float
) -> Problem:
    """Return the problem of a heap whose material is unknown within wide intervals.

    Parameters
    ----------
    stratum : Stratum
        Both frictions are free over its rows.
    material : mapping of str to float
        The true one: the density of the particles is free within 20 %.
    measured : mapping of str to float
        Responses, SI: the bulk density to 1 %.
    angle : float
        Tolerance of the angle of repose, degrees.
    """
    ranges = stratum.ranges
    tolerances = {"bulk_density": 0.01 * measured["bulk_density"], "angle_of_repose": angle}
    return Problem(
        [
            *(Parameter(n, ranges[n].low, ranges[n].high, "log") for n in (SLIDING, ROLLING)),
            Parameter(DENSITY, 0.8 * material[DENSITY], 1.2 * material[DENSITY]),
        ],
        [Target(n, measured[n], uncertainty=tolerances[n]) for n in RESPONSES],
    )


def chance_of(truth: Surrogate, point: Array) -> float:
    """Return the chance that a run at a point of the atlas, shape (1, inputs), has a heap."""
    return float(least_chance([truth.models[name] for name in RESPONSES], point).item())


class EmulatedHeap(Lammps):
    """A heap as LAMMPS would run it, with the responses of a metamodel instead."""

    truth: Surrogate
    reading: Reading

    def expected(self, parameters: Mapping[str, float]) -> dict[str, tuple[float, float]]:
        """Return the true responses and their scatter from run to run."""
        values = {name: np.array([one]) for name, one in parameters.items()}
        shares, found = self.reading.shares(values), {}
        for name in RESPONSES:
            model, info = self.truth.models[name], self.reading.kind.responses[name]
            mean = model.mean(shares) * self.reading.unit(name, values)
            scatter = np.abs(mean) * relative_scatter(info, model, shares)
            found[name] = float(mean.item()), float(scatter.item())
        return found

    def chance(self, parameters: Mapping[str, float]) -> float:
        """Return the chance that a run has all responses."""
        shares = self.reading.shares({name: np.array([one]) for name, one in parameters.items()})
        return chance_of(self.truth, shares)

    def run(
        self,
        parameters: Mapping[str, float],
        seed: int,
        workspace: Workspace | None = None,  # noqa: ARG002
    ) -> dict[str, Response]:
        """Return the true responses with their scatter, unless there is no heap."""
        random = np.random.default_rng(seed)
        if random.random() > self.chance(parameters):
            raise RunFailedError("there is no heap")
        return {
            name: Response(mean + scatter * random.standard_normal())
            for name, (mean, scatter) in self.expected(parameters).items()
        }


class _Shifted:
    """An atlas whose responses are shifted by shares of the measured ones."""

    def __init__(self, atlas: Atlas, shifts: Mapping[str, float]) -> None:
        self.atlas, self.shifts = atlas, shifts

    def require(self, name: str) -> SimpleNamespace:
        models = self.atlas.require(name).models
        return SimpleNamespace(
            models={
                n: _ShiftedModel(model, 1 + self.shifts.get(n, 0.0)) for n, model in models.items()
            }
        )


class _ShiftedModel:
    def __init__(self, model: ResponseModel, factor: float) -> None:
        self.model, self.factor = model, factor

    def mean(self, points: Array) -> Array:
        return self.factor * self.model.mean(points)

    def __getattr__(self, name: str) -> Any:
        return getattr(self.model, name)


class Trial:
    """The truth, the atlas of half of the rows, and the materials."""

    def __init__(self, folder: Path) -> None:
        self.stratum = strata()["heap"]
        rows = rows_in(SHIPPED / "heap.jsonl")
        shipped = Atlas()
        self.truth = shipped.require("heap")
        points = sorted({row.point for row in rows})
        known = set(np.random.default_rng(5).permutation(points)[::2])
        half = atlas_of(self.stratum, [r for r in rows if r.point in known], folder)
        self.atlases = {"atlas": half, "truth": shipped}
        self.materials = [
            row
            for row in rows
            if not row.is_repeat
            and row.point not in known
            and set(RESPONSES) <= row.responses.keys()
            and chance_of(self.truth, points_of([row], self.stratum.ranges)) > _RARELY_FAILS
        ]

    def record_of(self, run: Run) -> dict[str, Any]:
        """Calibrate once."""
        row = self.materials[run.material]
        test, material = self.stratum.simulated(row.inputs)
        fixed = {name: one for name, one in material.items() if name not in FREE}
        heap = EmulatedHeap(test, fixed)
        heap.truth, heap.reading = self.truth, Reading(heap, material)
        true = heap.expected({name: material[name] for name in FREE})
        values = {name: mean for name, (mean, _) in true.items()}
        problem = problem_of(self.stratum, material, values, run.angle)
        told = self.atlases.get(run.guide)
        if run.wrong and told is not None:
            told = _Shifted(told, {t.name: _SHIFT * t.tolerance / t.value for t in problem.targets})
        with patch("grainfit.atlas.expectation.shipped_atlas", lambda: told):
            result = calibrate(
                problem, heap, seed=run.material + 1, atlas=told is not None, near_runs=False
            )
        met = problem.is_met_by([heap.expected(result.parameters)[n][0] for n in RESPONSES])
        return {
            "runs": result.runs.total,
            "failed": result.runs.failed,
            "status": result.status,
            "met": met,
        }


def table(records: Mapping[Run, dict[str, Any]]) -> Iterator[str]:
    """Yield the lines of the table."""
    yield (
        "| guide | angle | calibrations | runs, median | 90 % | less those without "
        "| calibrated | of these false |"
    )
    yield "|---" * 8 + "|"
    for guide, angle, wrong in sorted({run[1:] for run in records}):
        own = [r for run, r in records.items() if run[1:] == (guide, angle, wrong)]
        runs = [one["runs"] for one in own]
        called = [one for one in own if one["status"] == "calibrated"]
        yield (
            f"| {guide}{', wrong' if wrong else ''} | \u00b1 {angle:g}\u00b0 | {len(own)} "
            f"| {np.median(runs):.0f} | {np.quantile(runs, 0.9):.0f} "
            f"| {_difference((guide, angle, wrong), records)} | {len(called)} "
            f"| {sum(not one['met'] for one in called)} |"
        )


def _difference(kind: tuple[str, float, bool], records: Mapping[Run, dict[str, Any]]) -> str:
    """Return the mean difference of the runs to those without, with its standard error."""
    found = [
        record["runs"] - records[other]["runs"]
        for run, record in records.items()
        if run[1:] == kind
        and (other := run._replace(guide="none", wrong=False)) != run
        and other in records
    ]
    if len(found) < 2:
        return ""
    return f"{np.mean(found):+.1f} ± {standard_error(found):.1f}"


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
            guides = ["atlas"] if given.wrong else _GUIDES
            measure(
                [
                    Run(number, guide, given.angle, given.wrong)
                    for number in range(min(given.materials, len(trial.materials)))
                    for guide in guides
                ],
                given.kept,
                trial.record_of,
            )
    print("\n".join(table(read(given.kept, Run))))


if __name__ == "__main__":
    main()
