"""True values on bounds: do the 95 % intervals hold them?

Linear and curved responses of one to four parameters, with normal noise, are simulated at a maximin
Latin hypercube and measured with an error at true values that lie inside of all intervals, on a
bound of one parameter, or on bounds of two. A third of the problems has a response fewer than
parameters. Equal-tailed intervals of the same posteriors are counted beside. Finished problems are
kept in the file ``--kept``, so that the command can be stopped and started again.

    python benchmarks/bounds.py --kept bounds.jsonl [--problems 200] [--table]
"""

from __future__ import annotations

import argparse
import os
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any, NamedTuple

os.environ["OMP_NUM_THREADS"] = "1"

import numpy as np

from grainfit.analysis.analysis import analyse_parameters
from grainfit.evaluation import Evaluation, Proposal, Response
from grainfit.metamodels.designs import maximin_latin_hypercube
from grainfit.problem import Parameter, Problem, Target
from kept_runs import measure, read

_RUNS, _RUNS_PER_PARAMETER = 8, 6
_FEWER_RESPONSES = 1 / 3
#: Standard uncertainty of the measurement; a parameter moves a response by about 1.
_UNCERTAINTY = (0.02, 0.6)
#: Scatter of a run over the uncertainty of the measurement.
_SCATTER = 0.5


class Drawn(NamedTuple):
    """A problem, with the number of parameters whose true value is on a bound."""

    on_bounds: int
    seed: int


def interval_ends(run: Drawn) -> dict[str, Any]:
    """Return ends of the intervals, and of equal-tailed ones, with the true values."""
    random = np.random.default_rng(run)
    dimension = int(random.integers(max(run.on_bounds, 1), 5))
    count = max(dimension - int(random.random() < _FEWER_RESPONSES), 1)
    slopes, bends = random.normal(size=(2, dimension, count))
    bends *= random.choice([0.0, 0.6])
    uncertainty = float(np.exp(random.uniform(*np.log(_UNCERTAINTY))))
    truth = random.random(dimension)
    on_bound = random.permutation(dimension)[: run.on_bounds]
    truth[on_bound] = random.integers(2, size=run.on_bounds)

    def respond(points: np.ndarray, deviation: float) -> np.ndarray:
        expected = points @ slopes + points**2 @ bends + np.sin(3 * points) @ (bends * slopes)
        return np.asarray(expected + deviation * random.standard_normal(expected.shape))

    measured = respond(truth[None], uncertainty)[0]
    problem = Problem(
        [Parameter(f"x{axis}", 0.0, 1.0) for axis in range(dimension)],
        [Target(f"y{i}", float(v), uncertainty=uncertainty) for i, v in enumerate(measured)],
    )
    points = maximin_latin_hypercube(_RUNS + _RUNS_PER_PARAMETER * dimension, dimension, run.seed)
    evaluations = [
        Evaluation(
            Proposal(problem.from_unit(point), seed, "design"),
            {f"y{i}": Response(float(value)) for i, value in enumerate(values)},
        )
        for seed, (point, values) in enumerate(
            zip(points, respond(points, _SCATTER * uncertainty), strict=True)
        )
    ]
    found = analyse_parameters(problem, evaluations)
    assert found.posterior is not None
    ends = np.quantile(found.posterior.points, [0.025, 0.975], axis=0)
    return {
        "truth": truth.tolist(),
        "on_bound": on_bound.tolist(),
        "intervals": [[one.low, one.high] for one in found.intervals.values()],
        "words": [one.determination for one in found.intervals.values()],
        "equal_tailed": ends.T.tolist(),
    }


def rows(records: dict[Drawn, dict[str, Any]]) -> Iterator[str]:
    """Yield the lines of a table in Markdown."""
    yield "| true values | parameters | equal-tailed | intervals | widths over equal-tailed |"
    yield "|---|---|---|---|---|"
    for name, on_bounds, on in (
        ("inside", (0,), False),
        ("on a bound", (1,), True),
        ("on bounds of two parameters", (2,), True),
        ("inside, another on a bound", (1, 2), False),
    ):
        chosen = [r for run, r in records.items() if run.on_bounds in on_bounds]
        yield _row(name, chosen, on, ("determined", "narrowed", "not determined"))
        for word in ("determined", "narrowed", "not determined"):
            yield _row(f"{name}: {word}", chosen, on, (word,))


def _row(name: str, records: Sequence[dict[str, Any]], on: bool, words: Sequence[str]) -> str:
    chosen = [
        (record["truth"][axis], record["equal_tailed"][axis], record["intervals"][axis])
        for record in records
        for axis in range(len(record["truth"]))
        if (axis in record["on_bound"]) == on and record["words"][axis] in words
    ]
    before, now = (
        sum(one[i][0] <= one[0] <= one[i][1] for one in chosen) / max(len(chosen), 1)
        for i in (1, 2)
    )
    wider = float(np.median([(i[1] - i[0]) / (e[1] - e[0]) for _, e, i in chosen] or [1.0]))
    return f"| {name} | {len(chosen)} | {before:.1%} | {now:.1%} | {wider:.2f} |"


def main() -> None:
    """Analyse the problems, and print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--kept", type=Path, required=True)
    parser.add_argument("--problems", type=int, default=200, help="of each kind")
    parser.add_argument("--table", action="store_true", help="only print what is known")
    options = parser.parse_args()
    if not options.table:
        runs = [Drawn(on, seed) for seed in range(options.problems) for on in range(3)]
        measure(runs, options.kept, interval_ends)
    print("\n".join(rows(read(options.kept, Drawn))))


if __name__ == "__main__":
    main()
