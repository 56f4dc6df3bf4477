"""Half-widths of 95 % intervals with the option ``wanted_half_width``, and without it.

Problems with known truth are calibrated by `grainfit.calibrate`, verification included, from
measured values with a random error of their standard uncertainty. Per problem: runs, half-widths of
the final 95 % intervals as shares of the answer, intervals that hold the truth, and the difference
between the half-widths that the search estimates and the final ones. Finished calibrations are
kept in the file ``--kept``, so that the command can be stopped and started again.

    python benchmarks/half_widths.py --kept half_widths.jsonl [--calibrations 10] [--processes 2]
        [--cases NAME ...] [--wanted 25% ...] [--table]
"""

from __future__ import annotations

import argparse
import json
import math
import os
import statistics
import sys
import time
from collections.abc import Callable, Iterable, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import replace
from pathlib import Path
from typing import Any

os.environ["OMP_NUM_THREADS"] = "1"

import numpy as np

import grainfit
from calibration_problems import (
    ANALYTIC_NOISE,
    ANALYTIC_PARAMETERS,
    ANALYTIC_TOLERANCE,
    CASES,
    Array,
    Case,
    analytic,
    true_parameters,
)
from grainfit.evaluation import Evaluation, Proposal, Response
from grainfit.metamodels.metamodels import Metamodels
from grainfit.problem import Problem, Target
from grainfit.result import Result
from grainfit.strategies.feasibility import FeasibilityModel
from grainfit.strategies.sequential.parameter_knowledge import ParameterKnowledge
from kept_runs import records_in

Record = dict[str, Any]
#: Without the option.
NONE = "none"


def analytic_of_three(seed: int) -> Case:
    """Density and the frictions between particles alone: fewer parameters than responses."""
    whole = analytic(seed)
    fixed = Problem(ANALYTIC_PARAMETERS[3:], [Target("none", 1.0)]).middle

    def truth(values: Array) -> Array:
        return whole.truth(np.hstack([values, np.tile(list(fixed.values()), (len(values), 1))]))

    problem = Problem(ANALYTIC_PARAMETERS[:3], whole.problem.targets)
    expected = truth(np.array([list(true_parameters(problem, seed).values())]))[0]
    targets = [
        Target(target.name, float(value), tolerance=ANALYTIC_TOLERANCE * float(value))
        for target, value in zip(problem.targets, expected, strict=True)
    ]
    return Case(replace(problem, targets=targets), truth, ANALYTIC_NOISE * expected)


PROBLEMS: dict[str, Callable[[int], Case]] = {
    "heap, +-33 %": CASES["heap, +-33 %"],
    "heap, +-66 %": CASES["heap, +-66 %"],
    "analytic, three parameters": analytic_of_three,
    "heap, four parameters": CASES["heap, four parameters"],
    "analytic, six parameters": CASES["analytic, six parameters"],
}


# One calibration ----------------------------------------------------------------------------


def calibrate(name: str, wanted: str, seed: int) -> Record:
    """Calibrate a problem and compare the intervals with the truth."""
    case = PROBLEMS[name](seed)
    problem = _measured(case.problem, seed)
    names = [target.name for target in problem.targets]

    def simulate(values: dict[str, float], run_seed: int) -> dict[str, float]:
        return dict(zip(names, case.simulate(values, run_seed).tolist(), strict=True))

    strategy = grainfit.Sequential(wanted_half_width=None if wanted == NONE else wanted)
    start = time.process_time()
    result = grainfit.calibrate(problem, simulate, strategy=strategy, seed=seed)
    seconds = round(time.process_time() - start, 1)
    truth = true_parameters(case.problem, seed)
    found = {n: (i.low, i.high) for n, i in result.intervals.items()}
    return {
        "case": name,
        "wanted": wanted,
        "seed": seed,
        "seconds": seconds,
        "status": result.status,
        "runs": result.runs.total,
        "half_widths": {n: _half_width(result, n) for n in found},
        "estimated": _estimated(problem, result) if found else {},
        "holds": {n: low <= truth[n] <= high for n, (low, high) in found.items()},
        "notices": list(result.notices),
    }


def _measured(problem: Problem, seed: int) -> Problem:
    """Return the problem with measured values that are off by their uncertainty."""
    random = np.random.default_rng([seed, 1795])
    targets = [
        Target(
            target.name,
            target.value + target.standard_uncertainty * float(random.standard_normal()),
            tolerance=target.tolerance,
        )
        for target in problem.targets
    ]
    return replace(problem, targets=targets)


def _half_width(result: Result, name: str) -> float:
    interval = result.intervals[name]
    return (interval.high - interval.low) / 2 / abs(result.parameters[name])


def _estimated(problem: Problem, result: Result) -> dict[str, float]:
    """Return the half-widths that a search with these runs would state."""
    runs = [
        Evaluation(
            Proposal(run.parameters, run.seed, run.stage),
            {name: Response(value) for name, value in run.responses.items()},
        )
        for run in result.history
    ]
    answer = problem.to_unit(result.parameters)
    knowledge = ParameterKnowledge(
        Metamodels.fit(problem, runs),
        FeasibilityModel(problem, runs),
        answer,
        1.0,
        (result.seed,),
    )
    return dict(knowledge.half_widths)


# All of them --------------------------------------------------------------------------------


def measure(
    cases: Sequence[str], wanted: Sequence[str], calibrations: int, processes: int, kept: Path
) -> list[Record]:
    """Return the records of all calibrations; add new ones to the file as they end."""
    records = records_in(kept)
    known = {(record["case"], record["wanted"], record["seed"]) for record in records}
    jobs = [(c, w, s) for s in range(1, calibrations + 1) for c in cases for w in wanted]
    jobs = [job for job in jobs if job not in known]
    start = time.monotonic()
    with ProcessPoolExecutor(processes) as pool, kept.open("a") as file:
        pending = [pool.submit(calibrate, *job) for job in jobs]
        try:
            for done, future in enumerate(as_completed(pending), 1):
                records.append(future.result())
                file.write(json.dumps(records[-1]) + "\n")
                file.flush()
                left = (time.monotonic() - start) / done * (len(jobs) - done) / 60
                print(f"{done} of {len(jobs)}, about {left:.0f} min left", file=sys.stderr)
        except BaseException:
            pool.shutdown(wait=False, cancel_futures=True)
            raise
    return [r for r in records if r["case"] in cases and r["wanted"] in wanted]


def table(records: Iterable[Mapping[str, Any]]) -> str:
    """Return the findings as a table in Markdown."""
    lines = [
        "| problem | wanted | calibrations | runs: median, most | half-widths (median) "
        "| intervals that hold the truth | estimate against final half-width |",
        "|---|---|---|---|---|---|---|",
    ]
    records = list(records)
    for case in PROBLEMS:
        for wanted in sorted({record["wanted"] for record in records}, reverse=True):
            own = [r for r in records if (r["case"], r["wanted"]) == (case, wanted)]
            if own:
                lines.append(_row(case, wanted, own))
    return "\n".join(lines)


def _row(case: str, wanted: str, records: Sequence[Mapping[str, Any]]) -> str:
    runs = [record["runs"] for record in records]
    with_intervals = [record for record in records if record["half_widths"]]
    names = with_intervals[0]["half_widths"]
    medians = [statistics.median(r["half_widths"][name] for r in with_intervals) for name in names]
    widths = ", ".join(
        f"{name.rpartition('.')[2]} {100 * w:.2g} %" for name, w in zip(names, medians, strict=True)
    )
    holds = [inside for record in with_intervals for inside in record["holds"].values()]
    logs = [
        math.log(record["estimated"][name] / record["half_widths"][name])
        for record in with_intervals
        for name in names
    ]
    difference = 100 * statistics.fmean(map(abs, logs))
    return (
        f"| {case} | {wanted} | {len(records)} | {statistics.median(runs):g}, {max(runs)} "
        f"| {widths} | {sum(holds)} of {len(holds)} | {difference:.0f} % |"
    )


def main() -> None:
    """Calibrate, and print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--kept", type=Path, required=True)
    parser.add_argument("--calibrations", type=int, default=10)
    parser.add_argument("--cases", nargs="+", choices=PROBLEMS, default=list(PROBLEMS))
    parser.add_argument("--wanted", nargs="+", default=[NONE, "10%"])
    parser.add_argument("--processes", type=int, default=2)
    parser.add_argument("--table", action="store_true", help="only print what is known")
    options = parser.parse_args()
    if options.table:
        print(table(records_in(options.kept)))
        return
    found = measure(
        options.cases, options.wanted, options.calibrations, options.processes, options.kept
    )
    print(table(found))


if __name__ == "__main__":
    main()
