"""Two frictions told apart: which bulk tests settle sliding and rolling friction.

Random materials are "measured" (the mean of eight seeds at the true parameters, with the scatter of
a laboratory) and calibrated with a particle density that is known to 0.5 %: it is free within two
standard uncertainties. The 95 % intervals of both frictions are compared with the truth. Finished
calibrations are kept in the file ``--kept``, runs of unfinished ones in the folder beside it, so
that the command can be stopped and started again. With ``--wanted``, the search goes on until the
half-widths are as wanted, if it can; these calibrations are kept apart from those without it.

    python benchmarks/two_frictions.py --kept two_frictions.jsonl [--materials 20]
        [--tests heap+draw_down ...] [--wanted 25%] [--processes 2] [--table]
"""

from __future__ import annotations

import argparse
import itertools
import json
import math
import os
import shutil
import statistics
import sys
import time
from collections.abc import Iterable, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from zlib import crc32

os.environ["OMP_NUM_THREADS"] = "1"

import numpy as np

import grainfit
from grainfit.bulk_tests.base import BulkTest
from grainfit.bulk_tests.registry import bulk_tests
from grainfit.campaign.batch import simulate_once
from grainfit.errors import GrainfitError
from grainfit.evaluation import scalars
from grainfit.problem import Parameter, Problem, Target
from grainfit.solvers.base import Solver
from grainfit.solvers.dem.lammps.program import Lammps
from grainfit.testing.materials import GLASS_BEADS

SLIDING, ROLLING = "particle_particle.sliding_friction", "particle_particle.rolling_friction"
DENSITY = "particle.density"
#: Intervals of the calibration; the true values lie well inside.
INTERVALS = {SLIDING: (0.05, 1.0), ROLLING: (0.02, 0.8)}
TRUE = {SLIDING: (0.1, 0.8), ROLLING: (0.05, 0.6)}
DENSITY_UNCERTAINTY = 0.005
MEASURED_SEEDS = 8
#: Standard uncertainty of a laboratory: a share of the value, or absolute.
LABORATORY: Mapping[str, float | str] = {
    "bulk_density": "0.5 %",
    "angle_of_repose": 0.5,
    "shear_angle": 0.7,
    "mass_flow": "2 %",
    "discharged_share": 0.01,
    "loading_modulus": "3 %",
    "unloading_modulus": "3 %",
    "lateral_stress_ratio": 0.01,
}
DIAMETER = 0.010


@dataclass(frozen=True)
class Combination:
    """Tests of a calibration, and the Young's modulus that they need, Pa."""

    tests: tuple[str, ...]
    youngs_modulus: float

    def solvers(self, fixed: Mapping[str, float]) -> dict[str, Solver]:
        """Return one solver for each test."""
        return {name: Lammps(_test(name), fixed) for name in self.tests}


#: Compression needs E / stress >= 1000; the others are cheap with the paper's modulus.
COMBINATIONS = {
    "heap": Combination(("heap",), 0.36e6),
    "heap+draw_down": Combination(("heap", "draw_down"), 0.36e6),
    "heap+compression": Combination(("heap", "compression"), 10e6),
}


def _test(name: str) -> BulkTest:
    return bulk_tests()[name](diameter=DIAMETER)


# One material -------------------------------------------------------------------------------


def calibrate(name: str, number: int, wanted: str | None, folder: Path) -> dict[str, Any]:
    """Measure a random material, calibrate it, and compare the intervals with the truth."""
    start = time.perf_counter()
    record = {"tests": name, "material": number, **({"wanted": wanted} if wanted else {})}
    try:
        return record | _calibrate(name, number, wanted, folder) | _seconds_since(start)
    except GrainfitError as error:
        return record | {"status": "error", "why": str(error)} | _seconds_since(start)


def _seconds_since(start: float) -> dict[str, float]:
    return {"seconds": round(time.perf_counter() - start, 1)}


def _calibrate(name: str, number: int, wanted: str | None, folder: Path) -> dict[str, Any]:
    combination = COMBINATIONS[name]
    random = np.random.default_rng([2016, number])
    truth = {key: float(random.uniform(*TRUE[key])) for key in TRUE}
    density = float(random.uniform(1500.0, 3000.0))
    known = density * (1 + DENSITY_UNCERTAINTY * float(random.standard_normal()))
    fixed = {n: v for n, v in GLASS_BEADS.items() if n not in (*INTERVALS, DENSITY)}
    fixed["particle.youngs_modulus"] = combination.youngs_modulus
    real = {**fixed, **truth, DENSITY: density}
    targets = [
        _target(key, values, np.random.default_rng([2016, number, crc32(key.encode())]))
        for key, values in _measure(combination.solvers(real), folder / "laboratory").items()
        if key.rpartition(".")[2] in LABORATORY
    ]
    reach = 2 * DENSITY_UNCERTAINTY * known
    intervals = {**INTERVALS, DENSITY: (known - reach, known + reach)}
    problem = Problem([Parameter(n, *i) for n, i in intervals.items()], targets)
    result = grainfit.calibrate(
        problem,
        combination.solvers(fixed),
        strategy=grainfit.Sequential(wanted_half_width=wanted),
        seed=number,
        workdir=folder / "calibration",
        keep="results",
    )
    return {
        "truth": truth,
        "status": result.status,
        "probability": result.probability_all_met,
        "answer": dict(result.parameters),
        "intervals": {n: [i.low, i.high, i.determination] for n, i in result.intervals.items()},
        "runs": result.runs.total,
        "notices": list(result.notices),
    }


def _measure(solvers: Mapping[str, Solver], folder: Path) -> dict[str, list[float]]:
    """Return the values of every response for seeds that no calibration uses."""
    found: dict[str, list[float]] = {}
    for seed in range(900_001, 900_001 + MEASURED_SEEDS):
        evaluation, _ = simulate_once(solvers, {}, seed, folder, keep="results")
        for key, response in scalars(evaluation.responses).items():
            found.setdefault(key, []).append(response.value)
    return found


def _target(key: str, values: Sequence[float], random: np.random.Generator) -> Target:
    """Return a target at the mean of the values, with the error of a laboratory."""
    mean = statistics.fmean(values)
    accuracy = LABORATORY[key.rpartition(".")[2]]
    share = isinstance(accuracy, str)
    absolute = float(str(accuracy).rstrip(" %")) / 100 * mean if share else float(accuracy)
    of_mean = statistics.stdev(values) / math.sqrt(len(values))
    value = mean + absolute * float(random.standard_normal())
    return Target(key, value, uncertainty=math.hypot(absolute, of_mean))


# All of them --------------------------------------------------------------------------------


def measure(
    names: Sequence[str], materials: int, wanted: str | None, processes: int, kept: Path
) -> list[dict[str, Any]]:
    """Return the records of all calibrations; add new ones to the file as they end."""
    records = _read(kept)
    known = {(record["tests"], record["material"], record.get("wanted")) for record in records}
    jobs = [(n, k, wanted) for k in range(1, materials + 1) for n in names]
    jobs = [job for job in jobs if job not in known]
    start = time.monotonic()
    with ProcessPoolExecutor(processes) as pool, kept.open("a") as file:
        folders = {
            job: kept.with_suffix("") / " ".join(map(str, filter(None, job))) for job in jobs
        }
        for folder in folders.values():
            folder.mkdir(parents=True, exist_ok=True)
        pending = {pool.submit(calibrate, *job, folders[job]): job for job in jobs}
        try:
            for done, future in enumerate(as_completed(pending), 1):
                records.append(future.result())
                file.write(json.dumps(records[-1]) + "\n")
                file.flush()
                shutil.rmtree(folders[pending[future]])
                _report(done, len(jobs), time.monotonic() - start)
        except BaseException:
            pool.shutdown(wait=False, cancel_futures=True)
            raise
    return [
        record
        for record in records
        if record["tests"] in names
        and record["material"] <= materials
        and record.get("wanted") == wanted
    ]


def _read(kept: Path) -> list[dict[str, Any]]:
    return [json.loads(line) for line in kept.read_text().splitlines()] if kept.exists() else []


def _report(done: int, jobs: int, seconds: float) -> None:
    left = seconds / done * (jobs - done) / 60
    print(f"{done} of {jobs} calibrations, about {left:.0f} min left", file=sys.stderr)


def table(records: Iterable[Mapping[str, Any]]) -> str:
    """Return the findings as a table in Markdown."""
    lines = [
        "| tests | materials | truth in the 95 % interval: sliding, rolling "
        "| median half-width: sliding, rolling | called not determined | runs (median) |",
        "|---|---|---|---|---|---|",
    ]
    records = list(records)
    failed = [f"{r['tests']}, material {r['material']}: {r['why']}" for r in records if "why" in r]
    records = [record for record in records if "intervals" in record]
    kinds = sorted({record.get("wanted") or "" for record in records})
    for name, wanted in itertools.product(COMBINATIONS, kinds):
        own = [r for r in records if (r["tests"], r.get("wanted") or "") == (name, wanted)]
        if own:
            held = ", ".join(_held(own, key) for key in INTERVALS)
            widths = ", ".join(f"{100 * _half_width(own, key):.0f} %" for key in INTERVALS)
            open_ones = ", ".join(_not_determined(own, key) for key in INTERVALS)
            runs = statistics.median(record["runs"] for record in own)
            words = name.replace("+", " + ").replace("_", "-")
            words += f", ±{wanted} wanted" if wanted else ""
            lines.append(f"| {words} | {len(own)} | {held} | {widths} | {open_ones} | {runs:g} |")
    return "\n".join([*lines, *failed])


def _held(records: Sequence[Mapping[str, Any]], key: str) -> str:
    inside = [r["intervals"][key][0] <= r["truth"][key] <= r["intervals"][key][1] for r in records]
    return f"{sum(inside)} of {len(inside)}"


def _half_width(records: Sequence[Mapping[str, Any]], key: str) -> float:
    widths = [
        (r["intervals"][key][1] - r["intervals"][key][0]) / 2 / r["truth"][key] for r in records
    ]
    return statistics.median(widths)


def _not_determined(records: Sequence[Mapping[str, Any]], key: str) -> str:
    return str(sum(r["intervals"][key][2] == "not determined" for r in records))


def main() -> None:
    """Calibrate, and print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--kept", type=Path, required=True)
    parser.add_argument("--materials", type=int, default=20)
    parser.add_argument("--tests", nargs="+", choices=COMBINATIONS, default=list(COMBINATIONS))
    parser.add_argument("--wanted", metavar="SHARE", help="half-width of the 95 %% intervals")
    parser.add_argument("--processes", type=int, default=2)
    parser.add_argument("--table", action="store_true", help="only print what is known")
    options = parser.parse_args()
    if options.table:
        print(table(_read(options.kept)))
        return
    found = measure(
        options.tests, options.materials, options.wanted, options.processes, options.kept
    )
    print(table(found))


if __name__ == "__main__":
    main()
