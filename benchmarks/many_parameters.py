"""Processor time of a proposal and of the report with 14 free parameters and 300 runs.

The runs are those of three made-up responses, so that nothing but grainfit takes time. The first
proposal fits the metamodels; the following ones fit them again, as after every run.

Usage: python benchmarks/many_parameters.py [--parameters N] [--runs N] [--json PATH]
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

os.environ["OMP_NUM_THREADS"] = "1"

import numpy as np
from numpy.typing import NDArray

from grainfit.evaluation import Evaluation, Proposal, Response
from grainfit.metamodels.designs import maximin_latin_hypercube
from grainfit.problem import Parameter, Problem, Target
from grainfit.strategies.sequential.strategy import Sequential

Array = NDArray[np.float64]

RESPONSES = 3
SCATTER = 0.3
#: Each should take less processor time, s.
GOALS = {"proposal": 2.0, "report": 20.0}


def responses(point: Array, seed: int) -> dict[str, float]:
    """Return the responses at a point of the unit cube: linear, a little curved, noisy."""
    slopes = np.random.default_rng(1).normal(size=(RESPONSES, len(point)))
    slopes *= np.exp(-np.arange(len(point)) / 4)
    centred = point - 0.5
    # Of few parameters, one stands for several.
    first, second, third, fourth = np.resize(centred, 4)
    curved = [2 * first * second, 2 * third**2, np.sin(3 * (fourth + 0.5)) / 2]
    noise = SCATTER * np.random.default_rng(seed).normal(size=RESPONSES)
    values = 10.3 + slopes @ centred + curved + noise
    return {f"r{number}": float(value) for number, value in enumerate(values)}


def parameters(point: Array) -> dict[str, float]:
    """Return the parameters of a point: all from 1 to 2."""
    return {f"p{number}": 1.0 + float(value) for number, value in enumerate(point)}


def time_of_proposals(cube: Array, proposals: int) -> list[float]:
    """Return the processor time of each of the next proposals, s."""
    problem = Problem(
        tuple(Parameter(name, 1.0, 2.0) for name in parameters(cube[0])),
        tuple(Target(f"r{number}", 10.0, tolerance=0.1) for number in range(RESPONSES)),
    )
    search = Sequential().start(problem, 1, len(cube) + 100)
    search.warm_start(
        [
            Evaluation(
                Proposal(parameters(point), 1000 + seed, "design"),
                {name: Response(value) for name, value in responses(point, seed).items()},
            )
            for seed, point in enumerate(cube)
        ]
    )
    times = []
    for _ in range(proposals):
        start = time.process_time()
        proposal = search.ask()
        times.append(time.process_time() - start)
        if proposal is None:
            break
        point = problem.to_unit(proposal.parameters)
        search.tell(proposal, responses(point, proposal.seed))
    return times


def time_of_report(cube: Array) -> float:
    """Return the processor time of the report on a calibration that knows the runs, s."""
    with tempfile.TemporaryDirectory() as folder:
        place = Path(folder)
        free = "".join(f"{name} = {{ min = 1, max = 2 }}\n" for name in parameters(cube[0]))
        targets = "".join(
            f"targets.r{number} = {{ value = 10, tolerance = 0.1 }}\n"
            for number in range(RESPONSES)
        )
        test = '[[test]]\ntype = "python"\nfunction = "model.py:f"\n'
        text = f'name = "many parameters"\n[parameters]\n{free}{test}{targets}'
        (place / "many.toml").write_text(text)
        (place / "model.py").write_text(_MODEL.format(folder=str(Path(__file__).parent)))
        names = [*parameters(cube[0]), *(f"r{number}" for number in range(RESPONSES)), "seed"]
        rows = [
            [*parameters(point).values(), *responses(point, seed).values(), 1000 + seed]
            for seed, point in enumerate(cube)
        ]
        lines = [",".join(map(str, row)) for row in [names, *rows]]
        (place / "runs.csv").write_text("\n".join(lines))
        _grainfit(place, "runs", "import", "many.toml", "runs.csv")
        _grainfit(place, "run", "many.toml", "--max-runs", "20", "--no-report")
        return _grainfit(place, "report", "many.grainfit")


_MODEL = """import sys
sys.path.insert(0, {folder!r})
import numpy as np
from many_parameters import responses
def f(parameters, seed):
    return responses(np.array(list(parameters.values())) - 1, seed)
"""


def _grainfit(folder: Path, *arguments: str) -> float:
    """Run a command and return its processor time, s. A calibration may end undecided."""
    before = os.times()
    command = [sys.executable, "-m", "grainfit", *arguments]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
    if done.returncode not in (0, 3):
        raise SystemExit(done.stdout + done.stderr)
    after = os.times()
    return after.children_user + after.children_system - sum(before[2:4])


def main() -> None:
    """Measure both, and print them."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--parameters", type=int, default=14)
    parser.add_argument("--runs", type=int, default=300)
    parser.add_argument("--proposals", type=int, default=5)
    parser.add_argument("--json", type=Path)
    options = parser.parse_args()
    cube = maximin_latin_hypercube(options.runs, options.parameters, 1)
    # Packages are imported when they are first needed.
    time_of_proposals(cube[:60], 1)
    times = time_of_proposals(cube, options.proposals)
    found = {"proposals": times, "report": time_of_report(cube)}
    print("proposals:", " ".join(f"{seconds:.2f}" for seconds in times), "s of processor time")
    print(f"report: {found['report']:.1f} s of processor time")
    print("goals:", ", ".join(f"{name} {goal:g} s" for name, goal in GOALS.items()))
    if options.json:
        options.json.write_text(json.dumps(found))


if __name__ == "__main__":
    main()
