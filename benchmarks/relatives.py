"""Calibrations with a cheaper relative of the runs: good, useless, wrong on purpose, and without.

Every calibration is that of `grainfit.calibrate` with its defaults, verification included, on a
problem of `verdict_problems.py` whose truth is known. A run of the relative costs 0.37 of a run, as
particles of 0.5 MPa do beside particles of 10 MPa, or 0.05. Finished calibrations are kept in the
file ``--kept`` and not repeated.

    python benchmarks/relatives.py --kept relatives.jsonl [--calibrations 20]
"""

from __future__ import annotations

import argparse
import os
import sys
from collections import Counter
from collections.abc import Callable, Mapping
from dataclasses import replace
from itertools import product
from pathlib import Path
from typing import Any, NamedTuple

os.environ["OMP_NUM_THREADS"] = "1"

import numpy as np

import grainfit
from grainfit.errors import GrainfitError
from grainfit.problem import Relative
from grainfit.solvers.own_model.python_callable import PythonCallable
from kept_runs import measure, read
from verdict_problems import PROBLEMS, KnownProblem

NAMES = ("smooth", "plateau", "banana", "basins", "interactions")
#: Costs of a run of the relative: of softer particles, and of a model that hardly costs anything.
COSTS = {"softer": 0.37, "cheap": 0.05}
#: Seeds of relatives are others than those of runs.
_OTHER_SEEDS = 10**6
Simulate = Callable[[dict[str, float], int], Mapping[str, float]]


class Calibration(NamedTuple):
    """One calibration of the benchmark."""

    problem: str
    relative: str
    cost: str
    seed: int


def _similar(known: KnownProblem) -> Simulate:
    """Return 0.9 of what runs differ by, a shift of two tolerances, and a tilt of one."""
    scales = [(t.value, t.tolerance) for t in known.problem.targets]

    def simulate(values: dict[str, float], seed: int) -> dict[str, float]:
        found = known.simulate(values, seed + _OTHER_SEEDS)
        tilt = float(known.problem.to_unit(values)[0])
        return {
            name: value + 0.9 * (found[name] - value) + tolerance * (2.0 + tilt)
            for name, (value, tolerance) in zip(found, scales, strict=True)
        }

    return simulate


def _elsewhere(known: KnownProblem, place: Callable[[Any], Any]) -> Simulate:
    def simulate(values: dict[str, float], seed: int) -> Mapping[str, float]:
        there = known.problem.from_unit(place(known.problem.to_unit(values)))
        return known.simulate(there, seed + _OTHER_SEEDS)

    return simulate


#: What runs of the relative give.
RELATIVES: dict[str, Callable[[KnownProblem], Simulate] | None] = {
    "none": None,
    "good": _similar,
    "useless": lambda known: _elsewhere(known, lambda u: 0.5 + 0.5 * np.sin(11 * u + 17 * u[::-1])),
    "wrong": lambda known: _elsewhere(known, lambda u: 1.0 - u),
}
#: What is compared.
KINDS = [("none", "softer"), *product(("good", "useless", "wrong"), COSTS)]


def calibrate(one: Calibration) -> dict[str, Any]:
    """Calibrate; return the runs, the verdict and the true deviation."""
    known = PROBLEMS[one.problem](one.seed)
    make = RELATIVES[one.relative]
    runs: Counter[str] = Counter()

    def counted(simulate: Simulate, kind: str) -> PythonCallable:
        def count(values: dict[str, float], seed: int) -> Mapping[str, float]:
            runs[kind] += 1
            return simulate(values, seed)

        return PythonCallable(count)

    problem, relatives = known.problem, None
    if make is not None:
        problem = replace(problem, relatives=[Relative("runs", COSTS[one.cost])])
        relatives = {"runs": counted(make(known), "of_relative")}
    tests = {"runs": counted(known.simulate, "runs")}
    try:
        result = grainfit.calibrate(problem, tests, relatives=relatives, seed=one.seed)
    except GrainfitError as error:
        return {"status": "failed", "why": str(error)}
    return {
        "status": result.status,
        "off": round(known.tolerances_off(result.parameters), 4),
        "runs": runs["runs"],
        "of_relative": runs["of_relative"],
    }


def table(kept: Path) -> str:
    """Return the table of the kept calibrations."""
    records = read(kept, Calibration)
    rows = [
        "| problem | relative | calibrated (of these false) | runs | of the relative | cost: mean, "
        "90th percentile | cost less that without |",
        "|---|---|---|---|---|---|---|",
    ]
    for problem in [*NAMES, "all"]:
        for relative, cost in KINDS:
            rows += _row(records, problem, relative, cost)
    return "\n".join(rows)


def _cost(one: Calibration, record: Mapping[str, Any]) -> float:
    return float(record["runs"] + COSTS[one.cost] * record["of_relative"])


def _row(records: Mapping[Calibration, Any], problem: str, relative: str, cost: str) -> list[str]:
    chosen = {
        one: record
        for one, record in records.items()
        if (one.relative, one.cost) == (relative, cost)
        and problem in (one.problem, "all")
        and "runs" in record
    }
    if not chosen:
        return []
    calibrated = [r for r in chosen.values() if r["status"] == "calibrated"]
    false = sum(r["off"] > 1.0 for r in calibrated)
    costs = [_cost(one, record) for one, record in chosen.items()]
    more = []
    for one, record in chosen.items():
        without = one._replace(relative="none", cost="softer")
        if "runs" in records.get(without, {}):
            more.append(_cost(one, record) - _cost(without, records[without]))
    error = np.std(more) / np.sqrt(len(more)) if more else np.nan
    runs = np.mean([r["runs"] for r in chosen.values()])
    of_relative = np.mean([r["of_relative"] for r in chosen.values()])
    is_other = relative != "none" and more
    difference = f"{np.mean(more):+.1f} ± {error:.1f}" if is_other else ""
    name = relative if relative == "none" else f"{relative}, {COSTS[cost]:g}"
    return [
        f"| {problem} | {name} | {len(calibrated)} of {len(chosen)} ({false}) | {runs:.1f} | "
        f"{of_relative:.1f} | {np.mean(costs):.1f}, {np.quantile(costs, 0.9):.1f} | {difference} |"
    ]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--kept", type=Path, required=True, help="file of finished calibrations")
    parser.add_argument("--calibrations", type=int, default=20, help="seeds of every problem")
    given = parser.parse_args()
    wanted = [
        Calibration(problem, relative, cost, seed)
        for seed in range(1, given.calibrations + 1)
        for problem in NAMES
        for relative, cost in KINDS
    ]
    measure(wanted, given.kept, calibrate)
    sys.stdout.write(table(given.kept) + "\n")


if __name__ == "__main__":
    main()
