"""Run every bulk test on several solvers, and compare their responses with those of LAMMPS.

Finished runs are kept in the file ``--kept`` and not repeated, so that the command can be stopped
and started again.

    python benchmarks/solver_agreement.py --kept agreement.jsonl [--seeds 20] [--tests heap ...]
        [--material rough|beads] [--set particle.youngs_modulus=1e7] [--processes 2] [--table]
        [--solvers lammps liggghts yade]

Prints, for each response, mean and standard deviation over the seeds on each solver, the difference
of the means from LAMMPS with its 95 % confidence interval (Welch), the ratio of the stated standard
error to the scatter over seeds, and the processor time of a run. YADE needs rolling damping 0:

    --solvers lammps yade --set particle_particle.rolling_damping=0
                          --set particle_wall.rolling_damping=0
"""

from __future__ import annotations

import argparse
import json
import os
import resource
import sys
import tempfile
import time
from collections.abc import Iterable, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from pathlib import Path
from typing import Any

os.environ["OMP_NUM_THREADS"] = "1"

import numpy as np
from scipy import stats

from grainfit.bulk_tests.registry import bulk_tests
from grainfit.errors import GrainfitError
from grainfit.evaluation import scalars
from grainfit.formatting import number
from grainfit.solvers.base import Workspace
from grainfit.solvers.registry import DEM_PROGRAMS
from grainfit.testing.materials import GLASS_BEADS, ROUGH_SPHERES, rough_plate_of
from kept_runs import records_in

#: The first one is the reference.
SOLVERS = ("lammps", "liggghts")
DIAMETER = 0.010
MATERIALS: Mapping[str, Mapping[str, float]] = {"rough": ROUGH_SPHERES, "beads": GLASS_BEADS}
#: Tests that need another modulus than the others, Pa.
MODULI = {"compression": 10e6, "triaxial": 10e6}
Record = dict[str, Any]


def run(test: str, solver: str, seed: int, name: str, changes: Mapping[str, float]) -> Record:
    """Simulate a test once; return its responses and the processor time."""
    modulus = MODULI.get(test, MATERIALS[name]["particle.youngs_modulus"])
    material = {**MATERIALS[name], "particle.youngs_modulus": modulus, **changes}
    before = _processor_seconds()
    record: Record = {
        "test": test,
        "solver": solver,
        "seed": seed,
        "material": name,
        "changes": dict(changes),
    }
    with tempfile.TemporaryDirectory() as folder:
        program = DEM_PROGRAMS[solver](
            bulk_tests()[test](diameter=DIAMETER, **rough_plate_of(test)), material
        )
        try:
            responses = program.run({}, seed, Workspace(Path(folder)))
        except GrainfitError as error:
            return record | {"why": str(error)}
    found = {n: [r.value, r.standard_error] for n, r in scalars(responses).items()}
    return record | {"responses": found, "seconds": round(_processor_seconds() - before, 2)}


def _processor_seconds() -> float:
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def measure(
    tests: Sequence[str],
    seeds: int,
    material: str,
    changes: Mapping[str, float],
    processes: int,
    kept: Path,
    solvers: Sequence[str] = SOLVERS,
) -> list[Record]:
    """Return the records of all runs; add new ones to the file as they end."""
    records = _of(records_in(kept), material, changes)
    known = {(r["test"], r["solver"], r["seed"]) for r in records}
    wanted = [(t, s, n) for n in range(1, seeds + 1) for t in tests for s in solvers]
    jobs = [job for job in wanted if job not in known]
    start = time.monotonic()
    with ProcessPoolExecutor(processes, max_tasks_per_child=1) as pool, kept.open("a") as file:
        pending = [pool.submit(run, *job, material, changes) for job in jobs]
        try:
            for done, future in enumerate(as_completed(pending), 1):
                records.append(future.result())
                file.write(json.dumps(records[-1]) + "\n")
                file.flush()
                if done % 10 == 0 or done == len(jobs):
                    left = (time.monotonic() - start) / done * (len(jobs) - done) / 60
                    print(f"{done} of {len(jobs)}, about {left:.0f} min left", file=sys.stderr)
        except BaseException:
            pool.shutdown(wait=False, cancel_futures=True)
            raise
    wanted_now = set(wanted)
    return [r for r in records if (r["test"], r["solver"], r["seed"]) in wanted_now]


def _of(records: Iterable[Record], material: str, changes: Mapping[str, float]) -> list[Record]:
    return [r for r in records if r["material"] == material and r["changes"] == changes]


def table(records: Iterable[Record], solvers: Sequence[str] = SOLVERS) -> str:
    """Return the comparison as a table in Markdown."""
    reference, *others = (name.upper() for name in solvers)
    differences = [f"{name} - {reference}" for name in others]
    titles = ["test", "response", "unit", reference, *others, *differences]
    titles += ["stated error / scatter", "CPU s a run"]
    lines = [f"| {' | '.join(titles)} |", "|---" * len(titles) + "|"]
    records = list(records)
    for name, test in bulk_tests().items():
        own = [r for r in records if r["test"] == name]
        for index, (response, info) in enumerate(test.responses.items() if own else ()):
            values = {s: _values(own, s, response) for s in solvers}
            if len(values[solvers[0]]) < 2:
                continue
            cells = [
                name if index == 0 else "",
                response,
                info.unit or "1",
                *(_mean(values[s]) for s in solvers),
                *(_difference(values[solvers[0]], values[s]) for s in solvers[1:]),
                ", ".join(_ratio(values[s]) for s in solvers),
                ", ".join(_seconds(own, s) for s in solvers) if index == 0 else "",
            ]
            lines.append("| " + " | ".join(cells) + " |")
    failed = [
        f"{r['test']}, {r['solver']}, seed {r['seed']}: {r['why']}" for r in records if "why" in r
    ]
    return "\n".join([*lines, *failed])


def _values(records: Iterable[Record], solver: str, response: str) -> np.ndarray:
    """Values and stated standard errors of a response, shape (n, 2)."""
    found = [
        r["responses"][response]
        for r in records
        if r["solver"] == solver and response in r.get("responses", {})
    ]
    return np.array(found).reshape(-1, 2)


def _mean(values: np.ndarray) -> str:
    if len(values) < 2:
        return ""
    return f"{number(values[:, 0].mean(), 4)} ± {number(values[:, 0].std(ddof=1), 2)}"


def _difference(one: np.ndarray, other: np.ndarray) -> str:
    if len(other) < 2:
        return ""
    one, other = one[:, 0], other[:, 0]
    interval = stats.ttest_ind(other, one, equal_var=False).confidence_interval(0.95)
    mean = other.mean() - one.mean()
    return f"{number(mean, 2)} ({number(interval.low, 2)} to {number(interval.high, 2)})"


def _ratio(values: np.ndarray) -> str:
    if len(values) < 2:
        return ""
    scatter = values[:, 0].std(ddof=1)
    return number(float(np.sqrt((values[:, 1] ** 2).mean()) / scatter), 2) if scatter else ""


def _seconds(records: Iterable[Record], solver: str) -> str:
    found = [r["seconds"] for r in records if r["solver"] == solver and "seconds" in r]
    return number(float(np.median(found)), 2) if found else ""


def main() -> None:
    """Run, and print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--kept", type=Path, required=True)
    parser.add_argument("--seeds", type=int, default=20, help="runs of each test and solver")
    parser.add_argument("--tests", nargs="+", choices=bulk_tests(), default=list(bulk_tests()))
    parser.add_argument("--solvers", nargs="+", choices=DEM_PROGRAMS, default=list(SOLVERS))
    parser.add_argument("--processes", type=int, default=2)
    parser.add_argument("--material", choices=MATERIALS, default="rough")
    parser.add_argument(
        "--set", action="append", default=[], metavar="NAME=VALUE", help="a material parameter"
    )
    parser.add_argument("--table", action="store_true", help="only print what is known")
    options = parser.parse_args()
    changes = {name: float(value) for name, value in (item.split("=") for item in options.set)}
    if options.table:
        known = _of(records_in(options.kept), options.material, changes)
        print(table([r for r in known if r["solver"] in options.solvers], options.solvers))
        return
    print(
        table(
            measure(
                options.tests,
                options.seeds,
                options.material,
                changes,
                options.processes,
                options.kept,
                options.solvers,
            ),
            options.solvers,
        )
    )


if __name__ == "__main__":
    main()
