"""Calibrations with runs of near problems in the store: good, useless, wrong on purpose, and none.

The responses of a heap are those of `verdict_problems.py`, whose truth is known, so that no DEM is
needed; the definitions of all runs are those of LAMMPS. Two earlier problems, with a restitution of
0.79 instead of 0.80 and with a cylinder of 61 instead of 60 mm, left 27 runs each. What these give
is as in `relatives.py`: similar (shifted by two tolerances and tilted by one), useless, or that of
the opposite corner. Finished calibrations are kept in the file ``--kept`` and not repeated.

    python benchmarks/near_runs.py --kept near_runs.jsonl [--calibrations 4] [--table]
"""

from __future__ import annotations

import argparse
import os
import sys
import tempfile
from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple

os.environ["OMP_NUM_THREADS"] = "1"

import numpy as np

import grainfit
from grainfit.bulk_tests.heap import Heap
from grainfit.campaign.store.records import RunRecord
from grainfit.campaign.store.store import RunStore
from grainfit.errors import GrainfitError
from grainfit.evaluation import Response
from grainfit.metamodels.designs import maximin_latin_hypercube
from grainfit.problem import Parameter, Problem
from grainfit.solvers.base import Workspace
from grainfit.solvers.dem.lammps.program import Lammps
from grainfit.testing.materials import GLASS_BEADS, ROUGH_PLATE
from kept_runs import measure, read
from relatives import RELATIVES, Simulate
from verdict_problems import PROBLEMS, KnownProblem

NAMES = ("smooth", "plateau", "banana", "basins", "interactions")
KINDS = ("none", "good", "useless", "wrong")
RESTITUTION = "particle_particle.restitution"
_FREE = (
    "particle_particle.sliding_friction",
    "particle_particle.rolling_friction",
    "particle_wall.sliding_friction",
)
#: Of the known problems, whose responses are any numbers above zero.
_RESPONSES = ("bulk_density", "base_radius")
_LOWEST, _WIDTH = 0.1, 0.9
#: Runs of each of the two earlier problems.
_EARLIER = 27


class Calibration(NamedTuple):
    """One calibration of the benchmark."""

    problem: str
    near: str
    seed: int


class EmulatedHeap(Lammps):
    """A heap as LAMMPS would run it, with the responses of a known problem instead."""

    def __init__(
        self,
        known: KnownProblem,
        simulate: Simulate,
        restitution: float = 0.80,
        cylinder: str = "60 mm",
    ) -> None:
        self.known, self.simulate_known = known, simulate
        free = _FREE[: known.problem.dimension]
        fixed = {name: value for name, value in GLASS_BEADS.items() if name not in free}
        heap = Heap(diameter="10 mm", cylinder_radius=cylinder, **ROUGH_PLATE)
        super().__init__(heap, fixed | {RESTITUTION: restitution})

    def place(self, parameters: Mapping[str, float]) -> dict[str, float]:
        """Return the parameters of the known problem."""
        names = [parameter.name for parameter in self.known.problem.parameters]
        return {n: (parameters[f] - _LOWEST) / _WIDTH for n, f in zip(names, _FREE, strict=False)}

    def run(
        self,
        parameters: Mapping[str, float],
        seed: int,
        workspace: Workspace | None = None,  # noqa: ARG002
    ) -> dict[str, Response]:
        """Return the responses of the known problem."""
        found = self.simulate_known(self.place(parameters), seed)
        return {n: Response(v) for n, v in zip(_RESPONSES, found.values(), strict=False)}

    @property
    def problem(self) -> Problem:
        """The known problem, in the parameters and responses of a heap."""
        known = self.known.problem
        parameters = [Parameter(n, _LOWEST, _LOWEST + _WIDTH) for n in _FREE[: known.dimension]]
        pairs = zip(_RESPONSES, known.targets, strict=False)
        return Problem(parameters, [replace(target, name=name) for name, target in pairs])

    def off(self, parameters: Mapping[str, float]) -> float:
        """Return the largest true deviation, in tolerances."""
        expected = self.known.expected(self.place(parameters))
        targets = self.problem.targets
        pairs = zip(expected, targets, strict=False)
        return max(abs(float(value) - t.value) / t.tolerance for value, t in pairs)


def left_behind(
    known: KnownProblem,
    make: Callable[[KnownProblem], Simulate],
    folder: Path,
    seed: int,
    count: int = _EARLIER,
) -> None:
    """Fill a work folder with so many runs of each of two earlier problems."""
    store = RunStore.in_folder(folder)
    simulate = make(known)
    for number, other in enumerate(
        (
            EmulatedHeap(known, simulate, restitution=0.79),
            EmulatedHeap(known, simulate, 0.8, "61 mm"),
        )
    ):
        shares = maximin_latin_hypercube(count, known.problem.dimension, 10 * seed + number)
        for run, point in enumerate(shares, 1):
            values = other.problem.from_unit(point)
            definition = other.definition(values, 1000 * seed + 100 * number + run)
            found = other.run(values, definition.seed)
            store.save(
                RunRecord(definition.identity, "heap", "finished", definition, responses=found)
            )
    store.close()


def calibrate(one: Calibration) -> dict[str, Any]:
    """Calibrate; return the runs, the verdict, the true deviation, and what is said."""
    known = PROBLEMS[one.problem](one.seed)
    heap = EmulatedHeap(known, known.simulate)
    make = RELATIVES[one.near]
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place)
        if make is not None:
            left_behind(known, make, folder, one.seed)
        try:
            result = grainfit.calibrate(
                heap.problem,
                {"heap": heap},
                seed=one.seed,
                runs_from=folder if make is not None else (),
                atlas=False,
            )
        except GrainfitError as error:
            return {"status": "failed", "why": str(error)}
    said = [notice for notice in result.notices if "near problem" in notice]
    return {
        "status": result.status,
        "off": round(heap.off(result.parameters), 4),
        "runs": result.runs.total,
        "said": said[0] if said else "",
    }


def table(kept: Path) -> str:
    """Return the table of the kept calibrations."""
    records = read(kept, Calibration)
    rows = [
        "| problem | near runs | calibrated (of these false) | runs: mean, 90th percentile | runs "
        "less those without |",
        "|---|---|---|---|---|",
    ]
    for problem in [*NAMES, "all"]:
        for near in KINDS:
            chosen = {
                one: record
                for one, record in records.items()
                if one.near == near and problem in (one.problem, "all") and "runs" in record
            }
            if not chosen:
                continue
            calibrated = [r for r in chosen.values() if r["status"] == "calibrated"]
            runs = [r["runs"] for r in chosen.values()]
            more = [
                record["runs"] - records[without]["runs"]
                for one, record in chosen.items()
                if "runs" in records.get(without := one._replace(near="none"), {})
            ]
            error = np.std(more) / np.sqrt(len(more)) if more else np.nan
            rows.append(
                f"| {problem} | {near} | {len(calibrated)} of {len(chosen)} "
                f"({sum(r['off'] > 1 for r in calibrated)}) "
                f"| {np.mean(runs):.1f}, {np.quantile(runs, 0.9):.1f} "
                f"| {'' if near == 'none' else f'{np.mean(more):+.1f} ± {error:.1f}'} |"
            )
    return "\n".join(rows)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--kept", type=Path, required=True, help="file of finished calibrations")
    parser.add_argument("--calibrations", type=int, default=4, help="seeds of every problem")
    parser.add_argument("--table", action="store_true", help="only print what is known")
    given = parser.parse_args()
    wanted = [
        Calibration(problem, near, seed)
        for seed in range(1, given.calibrations + 1)
        for problem in NAMES
        for near in KINDS
    ]
    if not given.table:
        measure(wanted, given.kept, calibrate)
    sys.stdout.write(table(given.kept) + "\n")


if __name__ == "__main__":
    main()
