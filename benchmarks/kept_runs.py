"""Runs of a benchmark that are kept in a file of JSON lines, and not repeated."""

from __future__ import annotations

import json
import math
import resource
import sys
import tempfile
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import Any, NamedTuple, TypeVar

import numpy as np

from grainfit.errors import GrainfitError
from grainfit.evaluation import Response
from grainfit.formatting import number
from grainfit.solvers.base import Workspace
from grainfit.solvers.dem.program import DeckSolver

Run = TypeVar("Run", bound=NamedTuple)


def simulate(program: DeckSolver, seed: int) -> dict[str, Any]:
    """Simulate once; return the responses, or the reason of a failure, and processor time."""
    record: dict[str, Any] = {}
    before = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime
    with tempfile.TemporaryDirectory() as folder:
        try:
            responses = program.run({}, seed, Workspace(Path(folder)))
        except GrainfitError as error:
            record["why"] = str(error)
        else:
            record["responses"] = {
                name: found.value
                for name, found in responses.items()
                if isinstance(found, Response)
            }
    seconds = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime - before
    return record | {"seconds": round(seconds, 2)}


def measure(runs: Sequence[Run], kept: Path, make: Callable[[Run], dict[str, Any]]) -> None:
    """Make the record of every run that is not kept yet, and keep it."""
    known = set(read(kept, type(runs[0])))
    missing = [run for run in runs if run not in known]
    for done, run in enumerate(missing, len(runs) - len(missing) + 1):
        write(kept, [(run, make(run))])
        print(f"{done} of {len(runs)}", file=sys.stderr)


def write(kept: Path, made: Iterable[tuple[Run, dict[str, Any]]]) -> None:
    """Keep every run with its record as soon as it is there."""
    with kept.open("a") as file:
        for run, record in made:
            file.write(json.dumps(run._asdict() | record) + "\n")
            file.flush()


def read(kept: Path, kind: type[Run]) -> dict[Run, dict[str, Any]]:
    """Read the records of all runs that are kept."""
    return {kind(*(one[key] for key in kind._fields)): one for one in records_in(kept)}


def records_in(kept: Path) -> list[dict[str, Any]]:
    """Read all records; none before the first one is kept."""
    return [json.loads(line) for line in kept.read_text().splitlines()] if kept.exists() else []


def scatter(values: Sequence[float]) -> float:
    """Return the standard deviation of a single run."""
    return float(np.std(values, ddof=1))


def standard_error(values: Sequence[float]) -> float:
    """Return the standard error of the mean."""
    return scatter(values) / math.sqrt(len(values))


def mean_and(spread: Callable[[Sequence[float]], float], values: Sequence[float]) -> str:
    """Return the mean and a measure of the spread of values in words."""
    found = spread(values) if len(values) > 1 else float("nan")
    return f"{number(float(np.mean(values)), 4)} ± {number(float(found), 2)}"
