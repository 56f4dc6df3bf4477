"""How many runs a search says are to come, beside how many come.

A problem of five parameters and three tests, eight responses that scatter by a tolerance each. At
every run the forecast is asked twice: as it is, and without its two precautions. A search that
takes longer than usual goes on for a share of the runs so far, and few runs do not measure scatter.
Verification is not a part of it.

    python benchmarks/forecasts.py --kept forecasts.jsonl [--searches 10]
"""

from __future__ import annotations

import argparse
import json
import os
from pathlib import Path
from typing import Any

os.environ["OMP_NUM_THREADS"] = "1"

import numpy as np
from numpy.typing import NDArray

import grainfit
from grainfit.strategies.sequential import search as sequential
from grainfit.strategies.sequential.search import SequentialSearch
from kept_runs import records_in

PARAMETERS = 5
#: Responses of each test.
TESTS = {"heap": 2, "draw_down": 3, "compression": 3}
#: Changes of a response over an interval, in tolerances.
SLOPES = (3.0, 12.0)
#: Share of the runs so far, and runs for each coefficient of a trend.
PRECAUTIONS = {
    "with": (sequential._LONGER_THAN_USUAL, sequential.RUNS_PER_COEFFICIENT),
    "without": (0.0, 1),
}
#: Verification of three parameter sets, so that no ratio is one to nothing.
AT_LEAST = 9

Array = NDArray[np.float64]
Record = dict[str, Any]


def make_problem(seed: int) -> tuple[grainfit.Problem, Array, Array]:
    """Return a problem with its slopes, shape (responses, parameters), and its answer."""
    random = np.random.default_rng(seed)
    names = [f"parameter_{number}" for number in range(PARAMETERS)]
    scopes = [
        grainfit.TestScope(test, [f"{test}.{number}" for number in range(count)], names)
        for test, count in TESTS.items()
    ]
    targets = [
        grainfit.Target(name, 100.0, tolerance=1.0) for scope in scopes for name in scope.targets
    ]
    size = (len(targets), PARAMETERS)
    slopes = random.uniform(*SLOPES, size) * random.choice([-1.0, 1.0], size)
    problem = grainfit.Problem(
        [grainfit.Parameter(name, 0.0, 1.0) for name in names], targets, tests=scopes
    )
    return problem, slopes, random.uniform(0.3, 0.7, PARAMETERS)


def record(seed: int) -> Record:
    """Search once; return the number of runs, and the forecasts after every run."""
    problem, slopes, answer = make_problem(seed)
    random = np.random.default_rng([seed, 1])
    search = grainfit.Sequential().start(problem, seed=seed)
    assert isinstance(search, SequentialSearch)
    asked, forecasts = 0, []
    while not search.finished:
        proposal = search.ask()
        assert proposal is not None
        off = np.array(list(proposal.parameters.values())) - answer
        values = 100.0 + slopes @ off + 2.0 * np.sin(3.0 * off[0]) + random.normal(size=len(slopes))
        told = dict(zip([target.name for target in problem.targets], values.tolist(), strict=True))
        tests = proposal.tests or tuple(TESTS)
        search.tell(proposal, {n: v for n, v in told.items() if n.split(".")[0] in tests})
        asked += len(tests)
        expected = {}
        for name, (share, runs) in PRECAUTIONS.items():
            sequential._LONGER_THAN_USUAL, sequential.RUNS_PER_COEFFICIENT = share, runs
            expected[name] = search.expected_left
        forecasts.append({"runs": asked, **expected})
    return {"seed": seed, "runs": asked, "forecasts": forecasts}


def ratios(records: list[Record], name: str, low: float, high: float) -> list[float]:
    """Return forecasts over the runs that came, while some part of a search had passed."""
    return [
        (forecast[name] + AT_LEAST) / (one["runs"] - forecast["runs"] + AT_LEAST)
        for one in records
        for forecast in one["forecasts"]
        if low <= forecast["runs"] / one["runs"] < high
    ]


def print_table(records: list[Record]) -> None:
    """Print median, 10 and 90 % of the ratios, by what part of the search had passed."""
    print("| part of the runs done | forecasts | without precautions | with them |")
    print("|---|---|---|---|")
    for low, high in ((0.2, 0.4), (0.4, 0.6), (0.6, 0.8), (0.8, 1.0)):
        without, having = (ratios(records, name, low, high) for name in ("without", "with"))
        shares = [np.quantile(one, (0.1, 0.5, 0.9)) for one in (without, having)]
        shown = " | ".join("{1:.2f} ({0:.2f} to {2:.2f})".format(*one) for one in shares)
        print(f"| {100 * low:.0f} to {100 * high:.0f} % | {len(having)} | {shown} |")


def main() -> None:
    """Read the command line, search, print."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--kept", type=Path, required=True)
    parser.add_argument("--searches", type=int, default=10)
    given = parser.parse_args()
    records = records_in(given.kept)
    for seed in range(len(records), given.searches):
        records.append(record(seed))
        with given.kept.open("a") as kept:
            kept.write(json.dumps(records[-1]) + "\n")
    print_table(records)


if __name__ == "__main__":
    main()
