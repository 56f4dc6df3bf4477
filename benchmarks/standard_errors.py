"""Effect of right and wrong stated standard errors on the sequential strategy.

The sequential strategy calibrates problems of `calibration_problems.py`, whose truth is known. The
runs scatter equally, or by 1 to 5 from run to run (long and short averages, the mean variance the
same); the error that a run states is right, twice as large, half as large, leaves the scatter from
seed to seed out, or is itself an estimate from few values. The metamodels treat it in three ways:

* ignored: as if none was stated;
* known: as the known variance of the run, in addition to the estimated scatter;
* ratio: as in grainfit, see `grainfit.metamodels.noise_ratios`. A common factor of all stated
  errors has no effect here, so it is not measured.

Measured are the true deviation of the worst response after a number of runs; and where the strategy
stops by itself: the number of runs, whether the answer is truly within tolerance, whether targets
are called out of reach (none is), and how many of the stated 95 % intervals contain the truth.

    python benchmarks/standard_errors.py [--calibrations N] [--processes 2] [--keep PATH]
"""

from __future__ import annotations

import argparse
import json
import os
import sys
import time
from collections.abc import Iterator, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from contextlib import contextmanager
from pathlib import Path
from typing import Any
from unittest.mock import patch

os.environ["OMP_NUM_THREADS"] = "1"

import numpy as np
from numpy.typing import NDArray
from threadpoolctl import threadpool_limits

from calibration_problems import CASES, Case
from grainfit.evaluation import Evaluation, Proposal, Response
from grainfit.metamodels.kriging import Kriging
from grainfit.strategies.answer import Answer
from grainfit.strategies.base import Search
from grainfit.strategies.sequential.strategy import Sequential

Array = NDArray[np.float64]
Record = dict[str, Any]
#: Problem, statement, treatment, seed.
Job = tuple[str, str, str, int]

PROBLEMS = ("heap, +-66 %", "analytic, six parameters")
CHECKPOINTS = {"heap, +-66 %": (10, 16), "analytic, six parameters": (16, 22)}
LARGEST_RATIO = 5.0
#: Number of values from which a stated error is estimated, where it is an estimate.
FEW = 7
INTERVAL = 1.96
#: Scatter of the runs and their stated error, and how it is treated; the most informative first.
#: If no error is stated, or all runs state the same, `ratio` is `ignored`.
KINDS = (
    ("equal, none stated", "ignored"),
    ("1 to 5, right", "ignored"),
    ("1 to 5, right", "ratio"),
    ("equal, estimated", "ratio"),
    ("equal, twice", "known"),
    ("1 to 5, right", "known"),
    ("equal, estimated", "known"),
    ("equal, right", "known"),
    ("1 to 5, and seeds", "ignored"),
    ("1 to 5, and seeds", "ratio"),
    ("1 to 5, and seeds", "known"),
    ("1 to 5, twice", "known"),
    ("1 to 5, half", "known"),
    ("equal, half", "known"),
)
FACTORS = {"twice": 2.0, "half": 0.5}


def scatter_and_statement(statement: str, seed: int) -> tuple[float, float]:
    """Return true and stated standard deviation of a run, relative to that of the problem."""
    noise, _, stated = statement.partition(", ")
    random = np.random.default_rng([seed, 5])
    logarithm = np.log(LARGEST_RATIO)
    # The mean square of a log-uniform number from 1 to r is (r^2 - 1) / (2 ln r).
    mean_square = (LARGEST_RATIO**2 - 1) / (2 * logarithm)
    own = 1.0 if noise == "equal" else float(np.exp(random.uniform(0, logarithm)))
    own /= 1.0 if noise == "equal" else float(np.sqrt(mean_square))
    if stated == "and seeds":
        return float(np.sqrt((1 + own**2) / 2)), own / float(np.sqrt(2))
    if stated == "estimated":
        return own, own * float(np.sqrt(random.chisquare(FEW - 1) / (FEW - 1)))
    return own, own * FACTORS.get(stated, 1.0)


def evaluation(case: Case, proposal: Proposal, statement: str, treatment: str) -> Evaluation:
    """Make a noisy run that states its error."""
    relative, stated = scatter_and_statement(statement, proposal.seed)
    expected = case.expected(proposal.parameters)
    values = expected + relative * (case.simulate(proposal.parameters, proposal.seed) - expected)
    errors = (0.0 if treatment == "ignored" else stated) * case.noise
    names = [target.name for target in case.problem.targets]
    rows = zip(names, values.tolist(), errors.tolist(), strict=True)
    return Evaluation(proposal, {name: Response(value, error) for name, value, error in rows})


@contextmanager
def treated(treatment: str) -> Iterator[None]:
    """Treat stated errors differently from the metamodels."""
    fit = Kriging.fit

    def known(points: Array, values: Array, *, standard_errors: Array) -> Kriging:
        return fit(points, values, standard_errors**2)

    if treatment == "known":
        with patch.object(Kriging, "fit", known):
            yield
    else:
        yield


def calibrate(name: str, statement: str, treatment: str, seed: int) -> Record:
    """Calibrate once with a budget, and once until the strategy stops by itself."""
    case, checkpoints = CASES[name](seed), CHECKPOINTS[name]
    with treated(treatment):
        search = Sequential(confidence=1.0).start(case.problem, seed, checkpoints[-1])
        off = []
        for runs in _run(case, search, statement, treatment):
            if runs in checkpoints:
                off.append(case.tolerances_off(search.answer().parameters))
        search = Sequential().start(case.problem, seed)
        runs = list(_run(case, search, statement, treatment))[-1]
        answer = search.answer()
    return {
        "off": off,
        "runs": runs,
        "within": case.tolerances_off(answer.parameters) <= 1,
        "out_of_reach": bool(answer.out_of_reach),
        "covered": _covered(case, answer),
    }


def _run(case: Case, search: Search, statement: str, treatment: str) -> Iterator[int]:
    """Make the runs of a strategy until it ends; yield their number."""
    made = 0
    while (proposal := search.ask()) is not None:
        search.tell(proposal, evaluation(case, proposal, statement, treatment))
        made += 1
        yield made


def _covered(case: Case, answer: Answer) -> list[bool]:
    expected = case.expected(answer.parameters)
    return [
        bool(abs(true - answer.predicted[t.name]) <= INTERVAL * answer.standard_errors[t.name])
        for true, t in zip(expected, case.problem.targets, strict=True)
    ]


def measure(
    problems: Sequence[str], calibrations: int, processes: int, kept: Path | None
) -> dict[Job, Record]:
    """Calibrate everything with seeds 1, 2, ...; records in the file ``kept`` are not repeated."""
    jobs = [
        (name, statement, treatment, seed)
        for name in problems
        for statement, treatment in KINDS
        for seed in range(1, calibrations + 1)
    ]
    records = _read(kept)
    start, done = time.monotonic(), 0
    with ProcessPoolExecutor(processes, initializer=_one_thread) as pool:
        asked = {pool.submit(calibrate, *job): job for job in jobs if job not in records}
        for future in as_completed(asked):
            job, done = asked[future], done + 1
            records[job] = future.result()
            if kept:
                with kept.open("a") as file:
                    file.write(json.dumps([job, records[job]]) + "\n")
            left = (time.monotonic() - start) / done * (len(asked) - done) / 60
            print(f"\r{done} of {len(asked)}, {left:.0f} min left ", end="", file=sys.stderr)
    return {job: records[job] for job in jobs}


def _one_thread() -> None:
    threadpool_limits(limits=1)


def _read(kept: Path | None) -> dict[Job, Record]:
    if kept is None or not kept.exists():
        return {}
    lines = [json.loads(line) for line in kept.read_text().splitlines()]
    return {tuple(job): record for job, record in lines}


def summarise(records: Sequence[Record]) -> dict[str, Any]:
    """Return medians, 90th percentiles and shares of calibrations of one kind."""
    off = np.array([record["off"] for record in records])
    runs = [record["runs"] for record in records]
    return {
        "off": [np.quantile(off, share, axis=0).tolist() for share in (0.5, 0.9)],
        "runs": [float(np.quantile(runs, share)) for share in (0.5, 0.9)],
        "within": float(np.mean([record["within"] for record in records])),
        "out_of_reach": sum(record["out_of_reach"] for record in records),
        "coverage": float(np.mean([record["covered"] for record in records])),
    }


def print_table(name: str, found: Mapping[tuple[str, str], Mapping[str, Any]], number: int) -> None:
    """Print the table of one problem."""
    runs = " | ".join(f"off after {n}" for n in CHECKPOINTS[name])
    print(f"\n**{name}** ({number} calibrations each)\n")
    print(f"| scatter, stated error | treated as | {runs} | runs | within, % | out of reach "
          "| covered, % |")  # fmt: skip
    print("|---" * (6 + len(CHECKPOINTS[name])) + "|")
    for (statement, treatment), one in found.items():
        off = " | ".join(f"{m:.2f} / {p:.2f}" for m, p in zip(*one["off"], strict=True))
        print(
            f"| {statement} | {treatment} | {off} | {one['runs'][0]:g} / {one['runs'][1]:g} "
            f"| {100 * one['within']:.0f} | {one['out_of_reach']} | {100 * one['coverage']:.0f} |"
        )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--calibrations", type=int, default=100, metavar="N")
    parser.add_argument("--problem", default="", metavar="TEXT", help="only those with this text")
    parser.add_argument("--processes", type=int, default=2, metavar="N")
    parser.add_argument("--keep", type=Path, help="add to this file, and repeat nothing in it")
    parser.add_argument("--json", type=Path, help="write all figures to this file")
    options = parser.parse_args()
    problems = [name for name in PROBLEMS if options.problem in name]
    records = measure(problems, options.calibrations, options.processes, options.keep)
    summary: dict[str, dict[tuple[str, str], Any]] = {name: {} for name in problems}
    for name, statement, treatment, _ in records:
        if (statement, treatment) not in summary[name]:
            of_kind = [r for job, r in records.items() if job[:3] == (name, statement, treatment)]
            summary[name][statement, treatment] = summarise(of_kind)
    for name, found in summary.items():
        print_table(name, found, options.calibrations)
    if options.json:
        plain = {name: {", ".join(key): one for key, one in found.items()}
                 for name, found in summary.items()}  # fmt: skip
        options.json.write_text(json.dumps(plain, indent=1) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
