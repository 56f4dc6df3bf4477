"""Calibrate an example with many seeds: runs, time, verdicts, and whether intervals hold a truth.

Every calibration is the command ``grainfit run`` in a folder of its own, start-up and report
included. Processor time is that of the command and all its runs. Compare wall times of an idle
machine only. Finished calibrations are kept in the file ``--kept`` and not repeated, so that the
command can be stopped and started again.

    python benchmarks/examples.py examples/glass_beads/calibration.toml --kept beads.jsonl
        [--seeds 20] [--workers 2] [--unknown-scatter] [--truth NAME=VALUE ...] [--table]
"""

from __future__ import annotations

import argparse
import json
import os
import resource
import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any

os.environ["OMP_NUM_THREADS"] = "1"
# An image of a container may forbid to keep compiled modules: each start would compile them again.
os.environ.pop("PYTHONDONTWRITEBYTECODE", None)

import numpy as np

from grainfit.formatting import number
from kept_runs import records_in

COMMAND = "from grainfit.__main__ import main; main()"
#: The same without the scatters that are known before the runs.
WITHOUT_SCATTER = (
    "import grainfit.calibration.calibrate as c;"
    "c.with_recorded_scatters = lambda problem, *_: problem;" + COMMAND
)

Record = dict[str, Any]


def calibrate(file: Path, seed: int, workers: int, *, knows_scatter: bool) -> Record:
    """Calibrate once; return runs by stage, times, status, and intervals of the parameters."""
    code = COMMAND if knows_scatter else WITHOUT_SCATTER
    with tempfile.TemporaryDirectory() as folder:
        work = Path(folder) / "example.grainfit"
        options = ["--workers", str(workers), "--seed", str(seed), "--workdir", str(work)]
        before, start = resource.getrusage(resource.RUSAGE_CHILDREN), time.perf_counter()
        done = subprocess.run(
            [sys.executable, "-c", code, "run", str(file), *options, "--quiet"],
            capture_output=True,
            text=True,
            check=False,
        )
        wall, after = time.perf_counter() - start, resource.getrusage(resource.RUSAGE_CHILDREN)
        found = work / "result.json"
        if not found.exists():
            raise RuntimeError(done.stderr)
        result = json.loads(found.read_text(encoding="utf-8"))
    return {
        "seed": seed,
        "workers": workers,
        "knows_scatter": knows_scatter,
        "status": result["status"],
        "stages": result["runs"],
        "total": result["runs"]["total"],
        "wall": round(wall, 2),
        "cpu": round(after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime, 2),
        "intervals": {n: (one["low"], one["high"]) for n, one in result["intervals"].items()},
    }


def print_table(records: Sequence[Record], truth: dict[str, float]) -> None:
    """Print runs, times and verdicts, median and 90th percentile."""
    print(
        "| scatter | calibrations | calibrated | runs | wall time, s | processor time, s | held |"
    )
    print("|---" * 7 + "|")
    for knows in (True, False):
        own = [record for record in records if record["knows_scatter"] is knows]
        if own:
            calibrated = sum(record["status"] == "calibrated" for record in own)
            held = [
                low <= truth[name] <= high
                for record in own
                for name, (low, high) in record["intervals"].items()
                if name in truth
            ]
            columns = [
                "known" if knows else "not known",
                str(len(own)),
                str(calibrated),
                *(_spread([record[key] for record in own]) for key in ("total", "wall", "cpu")),
                f"{sum(held)} of {len(held)}" if held else "",
            ]
            print(f"| {' | '.join(columns)} |")


def _spread(values: Sequence[float]) -> str:
    both = (np.median(values), np.quantile(values, 0.9, method="higher"))
    return " / ".join(number(float(value), 3) for value in both)


def _value(text: str) -> tuple[str, float]:
    name, _, value = text.partition("=")
    return name, float(value)


def main() -> None:
    """Read the command line, calibrate, print."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("file", type=Path, help="calibration file")
    parser.add_argument("--kept", type=Path, required=True)
    parser.add_argument("--seeds", type=int, default=20)
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--unknown-scatter", action="store_true")
    parser.add_argument("--truth", nargs="+", type=_value, default=[], metavar="NAME=VALUE")
    parser.add_argument("--table", action="store_true", help="only print what is known")
    given = parser.parse_args()
    knows = not given.unknown_scatter
    known = {(r["seed"], r["workers"], r["knows_scatter"]) for r in records_in(given.kept)}
    for seed in range(1, 1 if given.table else given.seeds + 1):
        if (seed, given.workers, knows) not in known:
            record = calibrate(given.file, seed, given.workers, knows_scatter=knows)
            with given.kept.open("a") as kept:
                kept.write(json.dumps(record) + "\n")
            print(f"{seed} of {given.seeds}", file=sys.stderr)
    print_table(records_in(given.kept), dict(given.truth))


if __name__ == "__main__":
    main()
