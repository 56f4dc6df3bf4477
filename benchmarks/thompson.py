"""Knowledge gradient against a composite Thompson sampler at the same place of the search.

The search of the sequential strategy is the same for both, and so are problem, design and seeds;
only the choice of the run that improves the answer differs. Thompson sampling draws the responses
of many candidates from the joint posterior of the metamodels, and runs the candidate whose drawn
misfit is smallest; with several workers every run has a draw of its own. The problems are those of
`verdict_problems.py` and `verdict_kinds.py`.

Several workers have as many runs pending: the oldest one is told, then the next one is asked for.
An answer is right when every expected response is truly within its tolerance. Finished searches are
kept in the file ``--kept`` and not repeated, so that the command can be stopped and started again.

    python benchmarks/thompson.py --kept thompson.jsonl [--searches 12] [--processes 2]
        [--workers 1 8] [--methods NAME ...] [--problems NAME ...] [--table]
"""

from __future__ import annotations

import argparse
import json
import math
import os
import sys
import time
from collections import deque
from collections.abc import Callable, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from pathlib import Path
from typing import Any
from unittest.mock import patch

os.environ["OMP_NUM_THREADS"] = "1"

import numpy as np
from numpy.typing import NDArray
from scipy.stats import binomtest

from grainfit.evaluation import Evaluation, Proposal, Response
from grainfit.metamodels.metamodels import Metamodels
from grainfit.metamodels.unit_cube import points_about, spread_points
from grainfit.strategies.run_costs import RunCosts
from grainfit.strategies.sequential import next_run as place
from grainfit.strategies.sequential.belief import Belief
from grainfit.strategies.sequential.next_run import NextRun
from grainfit.strategies.sequential.strategy import Sequential
from kept_runs import records_in
from verdict_kinds import KINDS
from verdict_problems import PROBLEMS, KnownProblem

Array = NDArray[np.float64]
Record = dict[str, Any]
Choice = Callable[[Belief, Metamodels, RunCosts, np.random.Generator], NextRun]

COMPARED = (
    "two frictions",
    "ridge",
    "banana",
    "six correlated",
    "eight",
    "eight over decades",
    "fourteen",
    "plane",
    "basins",
)
EVERY = PROBLEMS | KINDS
#: An answer is right when it is so after as many runs in a row.
IN_A_ROW = 3
#: Most runs after the design; a search that is still not right, or not ended, counts as later.
MOST_AFTER_DESIGN = 60
#: Candidates of a draw: all over the cube, and moved from the closest point by so much.
EVERYWHERE, MOVED, WIDTHS = 96, 32, (0.02, 0.08, 0.25)


# Choices of the next run --------------------------------------------------------------------


def thompson(
    belief: Belief, _conditioned: Metamodels, _costs: RunCosts, random: np.random.Generator
) -> NextRun:
    """Return the candidate with the smallest misfit in one draw of all responses."""
    closest = belief.answers.closest
    moved = [points_about(closest[:1], MOVED, width, random) for width in WIDTHS]
    everywhere = spread_points(EVERYWHERE, belief.problem.dimension, random)
    points = np.vstack([belief.answers.candidates, belief.answers.agreeing, *moved, everywhere])
    drawn = belief.metamodels.decorrelated(_drawn(belief.metamodels, points, random))
    misfits = (drawn**2).sum(axis=1) + belief.handicaps(points)
    likely = belief.feasibility.is_likely(points)
    best = int(np.argmin(np.where(likely, misfits, np.inf)))
    return NextRun(points[best], belief.problem.scopes[0])


def _drawn(metamodels: Metamodels, points: Array, random: np.random.Generator) -> Array:
    """Deviations drawn from their joint distribution at points, shape (m, targets)."""
    means, _ = metamodels.deviations(points)
    covariances, _ = metamodels.covariance_with(points)(points)
    drawn = []
    for mean, covariance in zip(means.T, covariances, strict=True):
        values, vectors = np.linalg.eigh((covariance + covariance.T) / 2)
        spread = np.sqrt(np.maximum(values, 0.0)) * random.standard_normal(len(values))
        drawn.append(mean + vectors @ spread)
    return np.column_stack(drawn)


KNOWLEDGE_GRADIENT = "knowledge gradient"
METHODS: dict[str, Choice] = {
    KNOWLEDGE_GRADIENT: place._most_improving,
    "Thompson": thompson,
}


# One search ---------------------------------------------------------------------------------


def search(name: str, seed: int, workers: int, method: str) -> Record:
    """Search for an answer; note after how many runs it is right, and when the search ends."""
    start = time.process_time()
    with patch.object(place, "_most_improving", METHODS[method]):
        found = _searched(EVERY[name](seed), seed, workers)
    seconds = round(time.process_time() - start, 2)
    job = {"problem": name, "seed": seed, "workers": workers, "method": method}
    return job | found | {"seconds": seconds}


def _searched(known: KnownProblem, seed: int, workers: int) -> Record:
    searching = Sequential().start(known.problem, seed)
    design = searching.design_runs
    pending: deque[Proposal] = deque()
    told, right = 0, list[bool]()
    while told < design + MOST_AFTER_DESIGN:
        while len(pending) < workers and (proposal := searching.ask()) is not None:
            pending.append(proposal)
        if not pending:
            break
        _tell(known, searching, pending.popleft())
        told += 1
        if told >= design:
            right.append(known.tolerances_off(searching.answer().parameters) <= 1.0)
    return {
        "design": design,
        "right_after": _first_in_a_row(right, design),
        "ends_after": told if searching.finished and not pending else None,
        "right_at_end": right[-1],
    }


def _tell(known: KnownProblem, searching: Any, proposal: Proposal) -> None:
    values = known.simulate(proposal.parameters, proposal.seed)
    responses = {name: Response(value) for name, value in values.items()}
    searching.tell(proposal, Evaluation(proposal, responses))


def _first_in_a_row(right: Sequence[bool], design: int) -> int | None:
    """Runs after which an answer is right and stays so; those of a search that ends right count."""
    for first in range(len(right)):
        if all(right[first : first + IN_A_ROW]):
            return design + first
    return None


# All searches -------------------------------------------------------------------------------


def measure(jobs: Sequence[tuple[str, int, int, str]], processes: int, kept: Path) -> list[Record]:
    """Return the records of all searches; add new ones to the file as they end."""
    records = records_in(kept)
    known = {(r["problem"], r["seed"], r["workers"], r["method"]) for r in records}
    left = [job for job in jobs if job not in known]
    with ProcessPoolExecutor(processes) as pool, kept.open("a") as file:
        futures = [pool.submit(search, *job) for job in left]
        try:
            for done, future in enumerate(as_completed(futures), 1):
                records.append(future.result())
                file.write(json.dumps(records[-1]) + "\n")
                file.flush()
                print(f"{done:,} of {len(left):,} searches", file=sys.stderr)
        except BaseException:
            pool.shutdown(wait=False, cancel_futures=True)
            raise
    return records


# What follows -------------------------------------------------------------------------------

HEADER = (
    "| problem | workers | seeds | {0}: right after (median / 90th percentile) | {1} | fewer runs: "
    "{0}, {1} | p | {0}: search ends after | {1} | fewer runs: {0}, {1} | p | right at the end | "
    "processor time, s |"
)


def print_table(records: Sequence[Record], problems: Sequence[str], other: str) -> None:
    """Print one row per problem and number of workers, then all problems pooled."""
    print("\n" + HEADER.format(KNOWLEDGE_GRADIENT, other) + "\n" + "|---" * 13 + "|")
    for workers in sorted({record["workers"] for record in records}):
        pairs = _pairs([r for r in records if r["workers"] == workers], other)
        for name in problems:
            own = [pair for pair in pairs if pair[0]["problem"] == name]
            if own:
                print(_row(name, workers, own))
        if pairs:
            print(_row("all", workers, pairs))


def _pairs(records: Sequence[Record], other: str) -> list[tuple[Record, Record]]:
    """Searches of both methods with the same problem and seed."""
    found: list[dict[tuple[str, int], Record]] = [
        {(r["problem"], r["seed"]): r for r in records if r["method"] == method}
        for method in (KNOWLEDGE_GRADIENT, other)
    ]
    ours, theirs = found
    return [(ours[key], theirs[key]) for key in sorted(ours.keys() & theirs.keys())]


def _row(name: str, workers: int, pairs: Sequence[tuple[Record, Record]]) -> str:
    columns = [name, str(workers), str(len(pairs))]
    for key in ("right_after", "ends_after"):
        ours, theirs = (
            np.array([record[key] or math.inf for record in side])
            for side in zip(*pairs, strict=True)
        )
        won, lost = int((ours < theirs).sum()), int((ours > theirs).sum())
        p_value = binomtest(won, won + lost).pvalue if won + lost else 1.0
        columns += [_spread(ours), _spread(theirs), f"{won}, {lost}", f"{p_value:.2g}"]
    for key, show in (("right_at_end", "{:.0%}"), ("seconds", "{:.1f}")):
        means = [np.mean([record[key] for record in side]) for side in zip(*pairs, strict=True)]
        columns.append(", ".join(show.format(mean) for mean in means))
    return f"| {' | '.join(columns)} |"


def _spread(runs: Array) -> str:
    """Median and 90th percentile; those that are not there after all runs count as more."""
    both = [np.median(runs), np.quantile(runs, 0.9, method="higher")]
    return " / ".join("more" if math.isinf(value) else f"{value:g}" for value in both)


def main() -> None:
    """Read the command line, search, print."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--kept", type=Path, required=True, help="file of finished searches")
    parser.add_argument("--searches", type=int, default=12, help="of every problem")
    parser.add_argument("--processes", type=int, default=2)
    parser.add_argument("--workers", type=int, nargs="+", default=[1, 8], help="runs at a time")
    parser.add_argument("--methods", nargs="+", default=list(METHODS), choices=METHODS)
    parser.add_argument("--problems", nargs="+", default=COMPARED, choices=EVERY)
    parser.add_argument("--table", action="store_true", help="only print what is known")
    arguments = parser.parse_args()
    # Seed by seed, so that a study that is stopped has as many searches of every problem.
    jobs = [
        (name, seed, workers, method)
        for seed in range(1, arguments.searches + 1)
        for name in arguments.problems
        for workers in arguments.workers
        for method in arguments.methods
    ]
    if arguments.table:
        records = records_in(arguments.kept)
    else:
        records = measure(jobs, arguments.processes, arguments.kept)
    for method in arguments.methods:
        if method != KNOWLEDGE_GRADIENT:
            print_table(records, arguments.problems, method)


if __name__ == "__main__":
    main()
