"""Runs that a second material needs with a warm start from the calibration of a first one.

Two materials on the same test: the targets of the second are other responses within the sampled
range. It is calibrated without earlier runs, and with a warm start from the calibration of the
first. The heap test is an emulator of recorded runs with their noise (see
calibration_problems.py), so that the true deviation of every answer is known.

With --neighbours, the intervals differ as well: those of every material are a random part of the
whole, and some other materials were calibrated before. Runs beyond the intervals are used up to
several distances, as shares of the interval.

Usage: python benchmarks/reuse.py [--neighbours] [--pairs N] [--workers N] [--json PATH]
"""

from __future__ import annotations

import argparse
import json
import tempfile
from collections.abc import Mapping
from concurrent.futures import Executor, ProcessPoolExecutor
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import numpy as np
from rich.progress import track

import grainfit as gf
from calibration_problems import CASES, Case, heap, part_of
from grainfit.campaign import reuse
from grainfit.result import Result
from grainfit.solvers.own_model.python_callable import PythonCallable

#: Half-width of the intervals: the widest of the method's study.
WIDTH = 0.66
#: Distance of the second material's seed from the first one's.
_OTHER = 5000
#: Largest share of runs that a second material should need with a warm start.
GOAL = 1 / 3
#: Cases of neighbours, number of materials calibrated before, and share of each interval.
NEIGHBOURS = ("heap, +-66 %", "heap, four parameters", "analytic, six parameters")
EARLIER, SHARE = 2, 0.5
#: Largest distances beyond the intervals.
REACHES = (0.0, 0.5, 1.0)


@dataclass(frozen=True)
class Outcome:
    """Runs of a calibration, and true distance of its answer from the targets."""

    status: str
    search: int
    total: int
    tolerances_off: float
    known: int


def pair(seed: int) -> tuple[Outcome, Outcome]:
    """Calibrate a second material without earlier runs, and after a first one."""
    first, second = heap(seed, WIDTH), heap(seed + _OTHER, WIDTH)
    with tempfile.TemporaryDirectory() as folder:
        cold = _calibrate(second, Path(folder) / "cold", seed)
        _calibrate(first, Path(folder) / "first", seed)
        warm = _calibrate(second, Path(folder) / "warm", seed, [Path(folder) / "first"])
    return _outcome(second, cold), _outcome(second, warm)


def neighbours(name: str, seed: int) -> dict[float, Outcome]:
    """Calibrate a material after some with other intervals, with runs up to each distance."""
    whole = CASES[name](seed)
    case = part_of(whole, seed, SHARE)
    found = {}
    with tempfile.TemporaryDirectory() as folder:
        sources = [Path(folder) / f"earlier {number}" for number in range(EARLIER)]
        for number, source in enumerate(sources, start=1):
            earlier = seed + number * _OTHER
            _calibrate(part_of(whole, earlier, SHARE), source, earlier)
        for reach in REACHES:
            reuse.LARGEST_DISTANCE = reach
            result = _calibrate(case, Path(folder) / f"reach {reach}", seed, sources)
            found[reach] = _outcome(case, result)
    return found


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
        result.runs.warm_start_runs,
    )


def figures_of(outcomes: list[Outcome]) -> dict[str, float]:
    """Return the figures of some calibrations by name."""
    searches = [outcome.search for outcome in outcomes]
    totals = [outcome.total for outcome in outcomes]
    return {
        "known_median": float(np.median([o.known for o in outcomes])),
        "search_median": float(np.median(searches)),
        "search_p90": float(np.quantile(searches, 0.9)),
        "total_median": float(np.median(totals)),
        "calibrated": float(np.mean([o.status == "calibrated" for o in outcomes])),
        "within_tolerance": float(np.mean([o.tolerances_off <= 1 for o in outcomes])),
        "search_sum": float(sum(searches)),
        "total_sum": float(sum(totals)),
    }


def show(figures: Mapping[str, Mapping[str, float]]) -> None:
    """Print figures, one line for each way."""
    columns = list(next(iter(figures.values())))
    print(f"{'':22}" + "".join(f"{column:>18}" for column in columns))
    for name, row in figures.items():
        print(f"{name:22}" + "".join(f"{row[column]:18.3g}" for column in columns))


def compare_pairs(seeds: range, pool: Executor) -> dict[str, dict[str, float]]:
    """Calibrate pairs of materials, and print what the runs of the first one save."""
    pairs = list(track(pool.map(pair, seeds), "calibrating", total=len(seeds)))
    print(f"{len(pairs)} pairs of materials, intervals of +-{WIDTH:.0%}")
    ways = ("without earlier runs", "warm start")
    columns = zip(*pairs, strict=True)
    figures = {name: figures_of(list(found)) for name, found in zip(ways, columns, strict=True)}
    show(figures)
    cold, warm = figures.values()
    for what in ("search", "total"):
        share = warm[f"{what}_sum"] / cold[f"{what}_sum"]
        print(f"{what} runs: {share:.2f} of those without earlier runs (goal: at most {GOAL:.2f})")
    return figures


def compare_reaches(seeds: range, pool: Executor) -> dict[str, dict[str, float]]:
    """Calibrate materials after others with other intervals, and print every distance."""
    figures = {}
    for name in NEIGHBOURS:
        done = pool.map(partial(neighbours, name), seeds)
        found = list(track(done, name, total=len(seeds)))
        print(f"{name}: {len(found)} materials, each after {EARLIER} others")
        ways = {f"up to {reach:g}": figures_of([f[reach] for f in found]) for reach in REACHES}
        show(ways)
        figures |= {f"{name}, {way}": row for way, row in ways.items()}
    return figures


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--pairs", type=int, default=100, help="pairs of materials")
    parser.add_argument("--neighbours", action="store_true", help="with other intervals as well")
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--json", type=Path)
    options = parser.parse_args()
    seeds = range(1, options.pairs + 1)
    with ProcessPoolExecutor(options.workers) as pool:
        compare = compare_reaches if options.neighbours else compare_pairs
        figures = compare(seeds, pool)
    if options.json:
        options.json.write_text(json.dumps(figures, indent=1))


if __name__ == "__main__":
    main()
