"""Run the same heap test on LAMMPS and on LIGGGHTS and compare the responses.

    python benchmarks/solver_agreement.py --seeds 10 --json agreement.json

Prints mean, standard deviation and 95 % confidence interval of each response for each solver, and
the difference of the means (LIGGGHTS minus LAMMPS) with its 95 % confidence interval (Welch).
"""

from __future__ import annotations

import argparse
import json
import math
import sys
import tempfile
import time
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from scipy import stats

from grainfit.bulk_tests.heap import Heap
from grainfit.materials.sizes import ParticleSizes
from grainfit.solvers.base import Workspace
from grainfit.solvers.dem.lammps.program import Lammps
from grainfit.solvers.dem.liggghts.program import Liggghts
from grainfit.solvers.dem.program import DeckSolver
from grainfit.testing.materials import GLASS_BEADS

SOLVERS: Mapping[str, type[DeckSolver]] = {"lammps": Lammps, "liggghts": Liggghts}


def run_seeds(solver: DeckSolver, seeds: Sequence[int]) -> dict[str, list[float]]:
    """Run one heap for each seed; return the values of each response, in order."""
    values: dict[str, list[float]] = {name: [] for name in solver.response_names}
    for seed in seeds:
        with tempfile.TemporaryDirectory() as folder:
            started = time.monotonic()
            responses = solver.run({}, seed, Workspace(Path(folder)))
        for name, response in responses.items():
            values[name].append(response.value)
        text = ", ".join(f"{name} {response.value:.2f}" for name, response in responses.items())
        seconds = time.monotonic() - started
        print(f"{solver.name} seed {seed}: {text} ({seconds:.1f} s)", file=sys.stderr, flush=True)
    return values


def summarise(values: Sequence[float]) -> dict[str, Any]:
    """Return mean, standard deviation and 95 % confidence interval of the mean."""
    mean, deviation = float(np.mean(values)), float(np.std(values, ddof=1))
    half = float(stats.t.ppf(0.975, len(values) - 1)) * deviation / math.sqrt(len(values))
    return {
        "mean": mean,
        "standard_deviation": deviation,
        "interval": [mean - half, mean + half],
        "values": list(values),
    }


def difference(one: Sequence[float], other: Sequence[float]) -> dict[str, Any]:
    """Return the difference of the means, ``other - one``, with its 95 % interval (Welch)."""
    test = stats.ttest_ind(other, one, equal_var=False)
    interval = test.confidence_interval(0.95)
    return {
        "mean": float(np.mean(other) - np.mean(one)),
        "interval": [float(interval.low), float(interval.high)],
    }


def compare(material: Mapping[str, float], seeds: Sequence[int]) -> dict[str, Any]:
    test = Heap(ParticleSizes((0.010,)))
    results = {name: run_seeds(kind(test, material), seeds) for name, kind in SOLVERS.items()}
    return {
        response: {
            **{name: summarise(values[response]) for name, values in results.items()},
            "difference": difference(*(values[response] for values in results.values())),
        }
        for response in test.responses
    }


def print_table(report: Mapping[str, Any]) -> None:
    for response, parts in report.items():
        print(f"{response} [{Heap.responses[response].unit}]")
        for name in SOLVERS:
            part = parts[name]
            low, high = part["interval"]
            print(
                f"  {name:9} mean {part['mean']:8.2f}  standard deviation "
                f"{part['standard_deviation']:5.2f}  95 % interval {low:8.2f} to {high:8.2f}"
            )
        low, high = parts["difference"]["interval"]
        mean = parts["difference"]["mean"]
        print(f"  liggghts - lammps {mean:+6.2f}  95 % interval {low:+6.2f} to {high:+6.2f}")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seeds", type=int, default=10, help="runs for each solver")
    parser.add_argument("--json", type=Path, help="write all figures to this file")
    parser.add_argument(
        "--set", action="append", default=[], metavar="NAME=VALUE", help="a material parameter"
    )
    arguments = parser.parse_args()
    changes = {name: float(value) for name, value in (item.split("=") for item in arguments.set)}
    report = compare({**GLASS_BEADS, **changes}, range(1, arguments.seeds + 1))
    print_table(report)
    if arguments.json:
        arguments.json.write_text(json.dumps(report, indent=2) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
