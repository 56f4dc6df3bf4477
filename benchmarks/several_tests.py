"""Computing time of calibrations with two tests: asked one by one, and together each time.

Every calibration is that of `grainfit.calibrate` with its defaults, verification included, on a
problem whose truth is known and whose runs have stated wall times. Each is made twice: with two
tests, of which the search asks for one at a time, and with one test that yields the responses of
both, at the cost of both. Finished calibrations are kept in the file ``--kept`` and not repeated,
so that the command can be stopped and started again.

    python benchmarks/several_tests.py --kept several_tests.jsonl [--calibrations 40]
        [--processes 2] [--problems NAME ...]
"""

from __future__ import annotations

import argparse
import json
import os
import zlib
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import Executor, Future, ProcessPoolExecutor, as_completed
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

os.environ["OMP_NUM_THREADS"] = "1"

import numpy as np
from numpy.typing import NDArray

import grainfit
from calibration_problems import Case, heap_and_rebound, heap_of_four
from grainfit.campaign.store.records import RunRecord
from grainfit.campaign.worker import RunTask
from grainfit.errors import GrainfitError
from grainfit.evaluation import Response
from grainfit.problem import Parameter, Problem, Target
from grainfit.solvers.base import Solver, Workspace
from kept_runs import records_in

Array = NDArray[np.float64]
Record = dict[str, Any]


@dataclass(frozen=True)
class Part:
    """One of the two tests of a problem.

    Parameters
    ----------
    name : str
        Name of the test.
    targets : sequence of int
        Places of its targets among those of the problem.
    parameters : sequence of str
        Free parameters that it depends on.
    seconds : callable
        Wall time of a run with some parameters, s.
    """

    name: str
    targets: Sequence[int]
    parameters: Sequence[str]
    seconds: Callable[[Mapping[str, float]], float]


@dataclass(frozen=True)
class Split:
    """A problem with known truth whose targets are those of two tests."""

    case: Case
    parts: Sequence[Part]


class KnownTest(Solver):
    """Solver of some parts of a problem: true responses with their scatter."""

    uses_folder = False

    def __init__(self, name: str, split: Split, parts: Sequence[Part], several: bool) -> None:
        self.name = name
        self._case, self._parts, self._several = split.case, parts, several

    @property
    def response_names(self) -> tuple[str, ...]:
        """Names of the targets; with several tests without that of the test."""
        return tuple(self._name(part, index) for part in self._parts for index in part.targets)

    def _name(self, part: Part, index: int) -> str:
        target = self._case.problem.targets[index].name
        return target if self._several else f"{part.name}.{target}"

    def model(self) -> Mapping[str, Any]:
        """Return the name: the store of a calibration has no other problem."""
        return {"solver": self.name}

    def depends_on(self, names: Sequence[str]) -> tuple[str, ...]:
        """Return the parameters of the parts."""
        used = {name for part in self._parts for name in part.parameters}
        return tuple(name for name in names if name in used)

    def run(
        self, parameters: Mapping[str, float], seed: int, _workspace: Workspace
    ) -> dict[str, Response]:
        """Return the responses of one noisy run of every part."""
        middle = self._case.problem.from_unit([0.5] * self._case.problem.dimension)
        expected = self._case.expected(middle | dict(parameters))
        found = {}
        for part in self._parts:
            random = np.random.default_rng([seed, zlib.crc32(part.name.encode())])
            for index in part.targets:
                value = expected[index] + self._case.noise[index] * random.standard_normal()
                found[self._name(part, index)] = Response(float(value))
        return found

    def seconds(self, parameters: Mapping[str, float]) -> float:
        """Wall time of a run, s."""
        return sum(part.seconds(parameters) for part in self._parts)


class StatedTimes(Executor):
    """Executes runs at once and gives them the wall times that their solver states."""

    def submit(self, execute: Any, task: RunTask, /) -> Future[RunRecord]:  # type: ignore[override]
        """Execute a run."""
        inner = getattr(task.solver, "solver", task.solver)
        future: Future[RunRecord] = Future()
        future.set_result(replace(execute(task), seconds=inner.seconds(task.parameters)))
        return future


# Problems -----------------------------------------------------------------------------------


def _constant(seconds: float) -> Callable[[Mapping[str, float]], float]:
    return lambda _parameters: seconds


def _heap(density: float, angle: float) -> Callable[[int], Split]:
    """Recorded heaps: the bulk density hardly scatters, the angle by more than its tolerance."""

    def draw(seed: int) -> Split:
        case = heap_of_four(seed)
        names = [parameter.name for parameter in case.problem.parameters]
        parts = [
            Part("density", [0], names, _constant(density)),
            Part("angle", [1], names, _constant(angle)),
        ]
        return Split(case, parts)

    return draw


def _friction(values: Array) -> Array:
    density, sliding, rolling, modulus = values.T
    grip = sliding / (sliding + 0.35)
    packing = 0.62 - 0.07 * (1 - np.exp(-3 * sliding)) - 0.04 * np.tanh(4 * rolling)
    bulk = density * (packing + 0.012 * np.log10(1e8 / modulus))
    angle = 11 + 28 * grip * (0.45 + 0.55 * np.tanh(5 * rolling))
    rebound = 40 + 12 * np.log10(modulus / 1e7) + density / 400
    return np.column_stack([bulk, angle, rebound])


def _friction_case(seed: int, noise: Sequence[float]) -> Case:
    parameters = [
        Parameter("particle.density", 1000.0, 3000.0),
        Parameter("particle_particle.sliding_friction", 0.1, 0.9),
        Parameter("particle_particle.rolling_friction", 0.02, 0.5),
        Parameter("particle.youngs_modulus", 1e6, 1e8, "log"),
    ]
    random = np.random.default_rng([seed, 16])
    cube = Problem(parameters, [Target("none", 1.0)])
    place = cube.from_unit(random.uniform(0.1, 0.9, 4))
    values = _friction(np.array([list(place.values())]))[0]
    relative = (0.01, 0.02, 0.02)
    targets = [
        Target(name, float(value), tolerance=share * float(value))
        for name, value, share in zip(("bulk", "angle", "rebound"), values, relative, strict=True)
    ]
    scatter = np.array(noise) * np.array([target.tolerance for target in targets])
    return Case(Problem(parameters, targets), _friction, scatter)


def _heap_and_rebound(seed: int) -> Split:
    """A noisy heap of all four parameters, and a precise rebound of two at ten times its cost."""
    case = _friction_case(seed, (0.3, 1.3, 0.1))
    names = [parameter.name for parameter in case.problem.parameters]
    return Split(
        case,
        [
            Part("heap", [0, 1], names, _constant(60.0)),
            Part("rebound", [2], [names[0], names[3]], _constant(600.0)),
        ],
    )


def _recorded_heap_and_rebound(seed: int) -> Split:
    """Recorded heaps of all four parameters, and a rebound of two at ten times their cost."""
    case = heap_and_rebound(seed)
    names = [parameter.name for parameter in case.problem.parameters]
    parts = [
        Part("heap", [0, 1], names, _constant(60.0)),
        Part("rebound", [2], ["particle.density", "particle.youngs_modulus"], _constant(600.0)),
    ]
    return Split(case, parts)


def _stiff(seed: int) -> Split:
    """The same with wall times that grow with the root of Young's modulus."""
    split = _heap_and_rebound(seed)
    modulus = split.case.problem.parameters[3].name

    def growing(seconds: float) -> Callable[[Mapping[str, float]], float]:
        return lambda parameters: seconds * (parameters[modulus] / 1e7) ** 0.5

    heap, rebound = split.parts
    return Split(
        split.case, [replace(heap, seconds=growing(60.0)), replace(rebound, seconds=growing(600.0))]
    )


PROBLEMS: dict[str, Callable[[int], Split]] = {
    "heap and rebound, 1 : 10": _heap_and_rebound,
    "the same, costs grow with stiffness": _stiff,
    "recorded heap and rebound, 1 : 10": _recorded_heap_and_rebound,
    "recorded heap, noisy : precise = 1 : 10": _heap(density=600.0, angle=60.0),
    "recorded heap, equal costs": _heap(density=60.0, angle=60.0),
    "recorded heap, noisy : precise = 10 : 1": _heap(density=60.0, angle=600.0),
}


# Calibrations -------------------------------------------------------------------------------


def calibrate(name: str, seed: int, together: bool) -> Record:
    """Calibrate a problem and compare what is stated with what is true."""
    split = PROBLEMS[name](seed)
    prefixes = {index: part.name for part in split.parts for index in part.targets}
    targets = [
        replace(target, name=f"{prefixes[index]}.{target.name}")
        for index, target in enumerate(split.case.problem.targets)
    ]
    problem = Problem(split.case.problem.parameters, targets)
    solvers: Solver | dict[str, Solver] = KnownTest("both", split, split.parts, several=False)
    if not together:
        solvers = {p.name: KnownTest(p.name, split, [p], several=True) for p in split.parts}
    done: dict[str, float] = {"seconds": 0.0}
    timed = StatedTimes()
    spent = _Spent(timed, done)
    base: Record = {"problem": name, "seed": seed, "together": together}
    try:
        result = grainfit.calibrate(problem, solvers, seed=seed, executor=spent)
    except GrainfitError as error:
        return base | {"status": "error", "why": str(error), "seconds": done["seconds"]}
    return base | {
        "status": result.status,
        "seconds": done["seconds"],
        "runs": result.runs.total,
        "probability": result.probability_all_met,
        "off": split.case.tolerances_off(result.parameters),
    }


class _Spent(Executor):
    """Adds up the wall times of the runs."""

    def __init__(self, inner: StatedTimes, done: dict[str, float]) -> None:
        self._inner, self._done = inner, done

    def submit(self, execute: Any, task: RunTask, /) -> Future[RunRecord]:  # type: ignore[override]
        """Execute a run."""
        future = self._inner.submit(execute, task)
        self._done["seconds"] += future.result().seconds
        return future


def measure(names: Sequence[str], calibrations: int, processes: int, kept: Path) -> list[Record]:
    """Return the records of all calibrations; add new ones to the file as they end."""
    records = records_in(kept)
    known = {(r["problem"], r["seed"], r["together"]) for r in records}
    jobs = [
        (name, seed, together)
        for seed in range(1, calibrations + 1)
        for name in names
        for together in (False, True)
        if (name, seed, together) not in known
    ]
    with ProcessPoolExecutor(processes) as pool, kept.open("a") as file:
        pending = [pool.submit(calibrate, *job) for job in jobs]
        try:
            for future in as_completed(pending):
                records.append(future.result())
                file.write(json.dumps(records[-1]) + "\n")
                file.flush()
        except BaseException:
            pool.shutdown(wait=False, cancel_futures=True)
            raise
    return [r for r in records if r["problem"] in names and r["seed"] <= calibrations]


def print_table(records: Sequence[Record], names: Sequence[str]) -> None:
    """Print computing times and verdicts of both ways."""
    print(
        "| problem | tests | calibrations | computing time, h, mean / median / 90th percentile | "
        "runs, mean | calibrated | truly met, of calibrated | one by one over together |\n"
        + "|---" * 8
        + "|"
    )
    for name in names:
        means = {}
        for together in (True, False):
            group = [r for r in records if r["problem"] == name and r["together"] == together]
            hours = np.array([record["seconds"] for record in group]) / 3600
            means[together] = float(hours.mean()) if len(group) else float("nan")
            calibrated = [record for record in group if record["status"] == "calibrated"]
            right = sum(record["off"] <= 1.0 for record in calibrated)
            runs = np.mean([record.get("runs", 0) for record in group])
            ratio = "" if together else f"{means[False] / means[True]:.2f}"
            print(
                f"| {name if together else ''} | {'together' if together else 'one by one'} | "
                f"{len(group)} | {means[together]:.2f} / {np.median(hours):.2f} / "
                f"{np.quantile(hours, 0.9):.2f} | {runs:.1f} | {len(calibrated)} | "
                f"{right}/{len(calibrated)} | {ratio} |"
            )


def main() -> None:
    """Read the command line, calibrate, print."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--kept", type=Path, required=True, help="file of finished calibrations")
    parser.add_argument("--calibrations", type=int, default=40, help="of every problem")
    parser.add_argument("--processes", type=int, default=2)
    parser.add_argument("--problems", nargs="+", default=list(PROBLEMS), choices=list(PROBLEMS))
    given = parser.parse_args()
    records = measure(given.problems, given.calibrations, given.processes, given.kept)
    print_table(records, given.problems)


if __name__ == "__main__":
    main()
