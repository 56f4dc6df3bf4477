"""Runs that a second material needs with a warm start from the calibration of a first one.

Two materials on the same test: the targets of the second are other responses within the sampled
range. It is calibrated without earlier runs, and with a warm start from the calibration of the
first. The heap test is an emulator of recorded runs with their noise (see
calibration_problems.py), so that the true deviation of every answer is known.

Usage: python benchmarks/reuse.py [--pairs N] [--workers N] [--json PATH]
"""

from __future__ import annotations

import argparse
import json
import tempfile
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import numpy as np
from rich.progress import track

import grainfit as gf
from calibration_problems import Case, heap
from grainfit.result import Result
from grainfit.solvers.own_model.python_callable import PythonCallable

#: Half-width of the intervals: the widest of the method's study.
WIDTH = 0.66
#: Distance of the second material's seed from the first one's.
_OTHER = 5000
#: Largest share of runs that a second material should need with a warm start.
GOAL = 1 / 3


@dataclass(frozen=True)
class Outcome:
    """Runs of a calibration, and true distance of its answer from the targets."""

    status: str
    search: int
    total: int
    tolerances_off: float


def pair(seed: int) -> tuple[Outcome, Outcome]:
    """Calibrate a second material without earlier runs, and after a first one."""
    first, second = heap(seed, WIDTH), heap(seed + _OTHER, WIDTH)
    with tempfile.TemporaryDirectory() as folder:
        cold = _calibrate(second, Path(folder) / "cold", seed)
        _calibrate(first, Path(folder) / "first", seed)
        warm = _calibrate(second, Path(folder) / "warm", seed, [Path(folder) / "first"])
    return _outcome(second, cold), _outcome(second, warm)


def _calibrate(case: Case, folder: Path, seed: int, runs_from: list[Path] | None = None) -> Result:
    def simulate(parameters: dict[str, float], run_seed: int) -> dict[str, float]:
        names = [target.name for target in case.problem.targets]
        return dict(zip(names, map(float, case.simulate(parameters, run_seed)), strict=True))

    solver = PythonCallable(simulate, identity="heap test of recorded runs")
    return gf.calibrate(case.problem, solver, workdir=folder, seed=seed, runs_from=runs_from or ())


def _outcome(case: Case, result: Result) -> Outcome:
    return Outcome(
        result.status,
        result.runs.design + result.runs.optimisation,
        result.runs.total,
        case.tolerances_off(result.parameters),
    )


def summarise(pairs: list[tuple[Outcome, Outcome]]) -> dict[str, dict[str, float]]:
    """Return the figures of both calibrations by name."""
    figures = {}
    for name, outcomes in zip(
        ("without earlier runs", "warm start"), zip(*pairs, strict=True), strict=True
    ):
        totals = [outcome.total for outcome in outcomes]
        figures[name] = {
            "calibrated": float(np.mean([o.status == "calibrated" for o in outcomes])),
            "search_median": float(np.median([o.search for o in outcomes])),
            "search_p90": float(np.quantile([o.search for o in outcomes], 0.9)),
            "total_median": float(np.median(totals)),
            "total_sum": float(sum(totals)),
            "search_sum": float(sum(o.search for o in outcomes)),
            "within_tolerance": float(np.mean([o.tolerances_off <= 1 for o in outcomes])),
        }
    return figures


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--pairs", type=int, default=100, help="pairs of materials")
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--json", type=Path)
    options = parser.parse_args()
    seeds = range(1, options.pairs + 1)
    with ProcessPoolExecutor(options.workers) as pool:
        done = pool.map(partial(pair), seeds)
        pairs = list(track(done, "calibrating", total=len(seeds)))
    figures = summarise(pairs)
    columns = ("search_median", "search_p90", "total_median", "calibrated", "within_tolerance")
    print(f"{len(pairs)} pairs of materials, intervals of +-{WIDTH:.0%}")
    print(f"{'':20}" + "".join(f"{column:>18}" for column in columns))
    for name, row in figures.items():
        print(f"{name:20}" + "".join(f"{row[column]:18.3g}" for column in columns))
    cold, warm = figures["without earlier runs"], figures["warm start"]
    for what in ("search", "total"):
        share = warm[f"{what}_sum"] / cold[f"{what}_sum"]
        print(f"{what} runs: {share:.2f} of those without earlier runs (goal: at most {GOAL:.2f})")
    if options.json:
        options.json.write_text(json.dumps(figures, indent=1))


if __name__ == "__main__":
    main()
