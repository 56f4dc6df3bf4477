"""Verdicts of calibrations against the truth: how often they are wrong, after how many runs.

Every calibration is that of `grainfit.calibrate` with its defaults, verification included, on a
problem of `verdict_problems.py` or `verdict_kinds.py` whose truth is known. Finished calibrations
are kept in the file ``--kept`` and not repeated, so that the command can be stopped and started
again.

    python benchmarks/verdicts.py --kept verdicts.jsonl [--calibrations 100] [--processes 2]
        [--problems NAME_OR_GROUP ...] [--workers 1] [--known-scatter 1]
"""

from __future__ import annotations

import argparse
import json
import math
import os
import sys
import time
from collections.abc import Iterable, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import replace
from itertools import pairwise
from pathlib import Path
from typing import Any

os.environ["OMP_NUM_THREADS"] = "1"

import numpy as np
from scipy.stats import beta

import grainfit
from grainfit.calibration.progress import Progress
from grainfit.errors import GrainfitError
from grainfit.result import Result
from kept_runs import records_in
from verdict_kinds import (
    BEYOND_BUDGET,
    CLIFFS,
    EDGE,
    JAMMING,
    KINDS,
    NO_ANSWER,
    NOISY,
    SMOOTH,
)
from verdict_problems import HOPELESS, NOISE, PROBLEMS, WELL_BEHAVED, KnownProblem

Record = dict[str, Any]
EVERY = PROBLEMS | KINDS
#: Groups of problems by name, for the tables and the command line.
GROUPS = {
    "well-behaved": WELL_BEHAVED,
    "noise": NOISE,
    "hopeless": HOPELESS,
    "smooth kinds": SMOOTH,
    "noisy kinds": NOISY,
    "cliffs": CLIFFS,
    "jamming": JAMMING,
    "no answer": NO_ANSWER,
    "beyond the budget": BEYOND_BUDGET,
    "edge": EDGE,
}
#: Classes of the stated probability in the reliability table.
CLASSES = (0.0, 0.05, 0.25, 0.5, 0.75, 0.9, 0.95, 0.99, 1.0)
#: A remaining number of runs is right between half and twice the truth, give or take one run.
FACTOR, SLACK = 2.0, 1
#: Seeds by which a scatter is known before the runs.
SEEDS = 1000
#: Deviation in tolerances that is an error of rounding.
ROUNDING = 1e-9
#: Demands on kinds, pooled over a group: largest share of false verdicts among calibrated, of
#: answers that exist and are not calibrated by group, of runs to the statistical limit (median and
#: 90th percentile), and shares of 95 % intervals that hold the truth (elsewhere, and of bounds).
MOST_FALSE = 0.03
MOST_MISSED = {"smooth kinds": 0.05, "noisy kinds": 0.05, "cliffs": 0.08, "jamming": 0.2}
PROVABLE = {name for group in MOST_MISSED for name in GROUPS[group]}
MOST_OVER_LIMIT = (1.6, 2.5)
COVERAGE, COVERAGE_OF_BOUNDS = (93, 98), (90, 99)


# One calibration ----------------------------------------------------------------------------


def calibrate(name: str, seed: int, workers: int, known_scatter: float) -> Record:
    """Calibrate a problem and compare what is stated with what is true."""
    known = EVERY[name](seed)
    if known_scatter:
        known = _with_scatters(known, known_scatter)
    told: list[tuple[int, int, int]] = []

    def note(progress: Progress) -> None:
        if not told or told[-1][0] != progress.done:
            told.append((progress.done, *progress.to_come.range))

    start = time.perf_counter()
    try:
        result = grainfit.calibrate(
            known.problem, known.simulate, seed=seed, workers=workers, on_progress=note
        )
    except GrainfitError as error:
        return {"problem": name, "seed": seed, "status": "error", "why": str(error)}
    seconds = time.perf_counter() - start
    return {"problem": name, "seed": seed, "seconds": round(seconds, 2)} | _facts(
        known, result, told
    )


def _with_scatters(known: KnownProblem, factor: float) -> KnownProblem:
    """Return the problem with scatters that are known: a factor times those at its middle."""
    runs = [known.simulate(known.problem.middle, seed) for seed in range(SEEDS)]
    scatters = {name: factor * float(np.std([run[name] for run in runs])) for name in runs[0]}
    return replace(known, problem=replace(known.problem, scatters=scatters))


def _facts(known: KnownProblem, result: Result, told: list[tuple[int, int, int]]) -> Record:
    expected = known.expected(result.parameters)[: len(result.responses)]
    middles, halves = zip(*(r.expected for r in result.responses.values()), strict=True)
    covered = np.abs(expected - np.array(middles)) <= np.array(halves)
    total = result.runs.total
    return {
        "status": result.status,
        "runs": total,
        "verification": result.runs.verification,
        "probability": result.probability_all_met,
        "off": known.tolerances_off(result.parameters),
        "covered": covered.tolist(),
        "held": _held(known, result),
        "limit": known.statistical_limit(),
        "told": [[done, low, high, total - done] for done, low, high in told],
        "notices": list(result.notices),
    }


def _held(known: KnownProblem, result: Result) -> list[tuple[bool, bool]]:
    """Whether intervals hold identifiable true parameters, and whether these are bounds."""
    held = []
    for name, interval in result.intervals.items():
        if known.truth is not None and name in known.identifiable:
            true = known.truth[name]
            on_bound = true in known.problem.intervals[name]
            held.append((interval.low <= true <= interval.high, on_bound))
    return held


# All calibrations ---------------------------------------------------------------------------


def measure(
    names: Sequence[str],
    calibrations: int,
    processes: int,
    workers: int,
    kept: Path,
    known_scatter: float = 0.0,
) -> list[Record]:
    """Return the records of all calibrations; add new ones to the file as they end."""
    records = records_in(kept)
    known = {(record["problem"], record["seed"]) for record in records}
    # Seed by seed, so that a study that is stopped has as many calibrations of every problem.
    jobs = [(n, s) for s in range(1, calibrations + 1) for n in names if (n, s) not in known]
    start = time.monotonic()
    with ProcessPoolExecutor(processes) as pool, kept.open("a") as file:
        pending = [pool.submit(calibrate, *job, workers, known_scatter) for job in jobs]
        try:
            for done, future in enumerate(as_completed(pending), 1):
                records.append(future.result())
                file.write(json.dumps(records[-1]) + "\n")
                file.flush()
                _report(done, len(jobs), time.monotonic() - start)
        except BaseException:
            pool.shutdown(wait=False, cancel_futures=True)
            raise
    wanted = set(names)
    return [r for r in records if r["problem"] in wanted and r["seed"] <= calibrations]


def _report(done: int, jobs: int, seconds: float) -> None:
    if done % 20 == 0 or done == jobs:
        left = seconds / done * (jobs - done) / 60
        print(f"{done:,} of {jobs:,} calibrations, about {left:.0f} min left", file=sys.stderr)


# What follows -------------------------------------------------------------------------------


def share_with_limits(count: int, of: int) -> str:
    """Share in percent with its 95 % confidence limits (Clopper & Pearson)."""
    if of == 0:
        return "-"
    low = beta.ppf(0.025, count, of - count + 1) if count else 0.0
    high = beta.ppf(0.975, count + 1, of - count) if count < of else 1.0
    return f"{count}/{of} ({100 * low:.1f}-{100 * high:.1f} %)"


def is_right(record: Record) -> bool:
    """Whether the answer truly meets every target."""
    return bool(record["off"] <= 1.0 + ROUNDING)


def row(name: str, records: Sequence[Record]) -> str:
    """One row of the table of verdicts."""
    ended = [record for record in records if record["status"] != "error"]
    if not ended:
        return f"| {name} | {len(records)} failed |"
    runs = [record["runs"] for record in ended]
    counts = {word: sum(r["status"] == word for r in ended) for word in STATUSES}
    calibrated = [record for record in ended if record["status"] == "calibrated"]
    false = sum(not is_right(record) for record in calibrated)
    right = [record for record in ended if is_right(record)]
    refused = sum(record["status"] != "calibrated" for record in right)
    covered = [inside for record in ended for inside in record["covered"]]
    check = np.mean([record["verification"] for record in ended]) / np.mean(runs)
    return (
        f"| {name} | {len(records)} | {np.median(runs):g} / {np.quantile(runs, 0.9):g} | "
        f"{100 * check:.0f} | {' / '.join(str(count) for count in counts.values())} | "
        f"{share_with_limits(false, len(calibrated))} | {share_with_limits(refused, len(right))} | "
        f"{100 * np.mean(covered):.0f} | {np.median([r['seconds'] for r in ended]):.1f} |"
    )


STATUSES = ("calibrated", "undecided", "out_of_tolerance", "unreachable")
HEADER = (
    "| problem | calibrations | runs, median / 90th percentile | verification, % of runs | "
    "calibrated / undecided / out of tolerance / unreachable | false of calibrated | "
    "refused of true answers | 95 % intervals that hold, % | s |\n" + "|---" * 9 + "|"
)


def print_tables(records: Sequence[Record], names: Iterable[str]) -> None:
    """Print verdicts, reliability of the stated probability, and of the remaining runs."""
    chosen = list(names)
    for title, group in GROUPS.items():
        inside = [name for name in group if name in chosen]
        if not inside:
            continue
        print(f"\n**{title.capitalize()}**\n\n{HEADER}")
        for name in inside:
            print(row(name, [record for record in records if record["problem"] == name]))
        print(row("all", [record for record in records if record["problem"] in inside]))
    _print_reliability([record for record in records if record["status"] != "error"])
    _print_demands([record for record in records if record["problem"] in KINDS])


DEMANDS_HEADER = (
    "| kind | calibrations | false of calibrated | answer exists, not calibrated | "
    "runs over limit, median / 90th percentile | responses held | parameters held | "
    "true values on a bound held |\n" + "|---" * 8 + "|"
)


def _print_demands(records: Sequence[Record]) -> None:
    """Print what is demanded of kinds: one row each, then groups, with the demands beside them."""
    if not records:
        return
    print(f"\n**Demands**\n\n{DEMANDS_HEADER}")
    done = {record["problem"] for record in records}
    for name in KINDS:
        if name in done:
            print(demands_row(name, [r for r in records if r["problem"] == name]))
    for group, most in MOST_MISSED.items():
        inside = [record for record in records if record["problem"] in GROUPS[group]]
        if inside:
            print(demands_row(f"**{group}**", inside, f", at most {100 * most:g} %"))
    print(demands_row("**all kinds**", records))
    median, high = MOST_OVER_LIMIT
    print(
        f"| demanded | | at most {100 * MOST_FALSE:g} % | | {median:g} / {high:g} | "
        f"{COVERAGE[0]}-{COVERAGE[1]} % | {COVERAGE[0]}-{COVERAGE[1]} % | "
        f"{COVERAGE_OF_BOUNDS[0]}-{COVERAGE_OF_BOUNDS[1]} % |"
    )


def demands_row(name: str, records: Sequence[Record], most_missed: str = "") -> str:
    """One row of the table of demands.

    Runs over the limit are those of calibrated answers; a calibration that gives up takes few runs.
    A calibration that ends in an error counts as an answer that is not calibrated.
    """
    calibrated = [record for record in records if record["status"] == "calibrated"]
    false = sum(not is_right(record) for record in calibrated)
    existing = [record for record in records if record["problem"] in PROVABLE]
    missed = sum(record["status"] != "calibrated" for record in existing)
    over = [r["runs"] / r["limit"] for r in calibrated if r.get("limit")]
    ratios = f"{np.median(over):.2f} / {np.quantile(over, 0.9):.2f}" if over else "-"
    covered = [inside for record in records for inside in record.get("covered", [])]
    held = [pair for record in records for pair in record.get("held", [])]
    elsewhere = [inside for inside, on_bound in held if not on_bound]
    on_bounds = [inside for inside, on_bound in held if on_bound]
    shares = [share_with_limits(sum(one), len(one)) for one in (covered, elsewhere, on_bounds)]
    return (
        f"| {name} | {len(records)} | {share_with_limits(false, len(calibrated))} | "
        f"{share_with_limits(missed, len(existing))}{most_missed} | {ratios} | "
        f"{' | '.join(shares)} |"
    )


def _print_reliability(records: Sequence[Record]) -> None:
    print("\n| stated probability | calibrations | mean stated, % | truly within, % |")
    print("|---" * 4 + "|")
    for low, high in pairwise(CLASSES):
        group = [
            r
            for r in records
            if r["probability"] is not None
            and (low <= r["probability"] < high or r["probability"] == high == 1.0)
        ]
        if group:
            stated = 100 * np.mean([r["probability"] for r in group])
            true = share_with_limits(sum(map(is_right, group)), len(group))
            print(f"| {low:g} to {high:g} | {len(group)} | {stated:.1f} | {true} |")
    told = [item for record in records for item in record["told"][:-1]]
    middles = [(math.sqrt(max(low, 1) * max(high, 1)), left) for _, low, high, left in told]
    right = sum(
        left / FACTOR - SLACK <= middle <= FACTOR * left + SLACK for middle, left in middles
    )
    inside = sum(low <= left <= high for _, low, high, left in told)
    print(
        f"\nRemaining runs: {100 * inside / max(len(told), 1):.0f} % within the stated range, "
        f"{100 * right / max(len(told), 1):.0f} % of the middles between half and twice."
    )


def main() -> None:
    """Read the command line, calibrate, print."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--kept", type=Path, required=True, help="file of finished calibrations")
    parser.add_argument("--calibrations", type=int, default=100, help="of every problem")
    parser.add_argument("--processes", type=int, default=2)
    parser.add_argument("--workers", type=int, default=1, help="runs at a time")
    parser.add_argument(
        "--known-scatter",
        type=float,
        default=0.0,
        metavar="FACTOR",
        help="the scatters times this factor are known before the runs",
    )
    parser.add_argument(
        "--problems",
        nargs="+",
        default=list(PROBLEMS),
        choices=[*EVERY, *GROUPS, "kinds"],
        help="names of problems or groups; kinds are all of verdict_kinds.py",
    )
    arguments = parser.parse_args()
    groups = GROUPS | {"kinds": KINDS}
    names = list(dict.fromkeys(n for g in arguments.problems for n in groups.get(g, [g])))
    records = measure(
        names,
        arguments.calibrations,
        arguments.processes,
        arguments.workers,
        arguments.kept,
        arguments.known_scatter,
    )
    print_tables(records, names)


if __name__ == "__main__":
    main()
