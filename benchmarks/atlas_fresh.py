"""Estimates by the atlas against fresh materials, each simulated with many seeds.

Random materials in random apparatus, at points of the atlas's design that it does not have, are
simulated with 20 seeds each. A point is no material without all responses in at least 16 of them,
and left when two of the first four are without. Runs are kept in a file of JSON lines: the command
can be stopped and started again.

    python benchmarks/atlas_fresh.py --kept FILE [--strata heap draw_down] [--materials 40]
        [--processes 1]
    python benchmarks/atlas_fresh.py --kept FILE --table

Prints two tables in Markdown: how far the responses that the atlas tells at the true parameters
are from the means, in tolerances (1 degree, 1 %), and the share of its 95 % intervals that hold
them; and the same of true parameters, where the means are measured with the error of a laboratory.
"""

from __future__ import annotations

import argparse
import os
import sys
import time
from collections.abc import Iterator, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path
from statistics import mean, median
from typing import Any, NamedTuple

os.environ["OMP_NUM_THREADS"] = "1"

import numpy as np

from atlas_estimates import HEADING, Tally, estimated, laboratory_error
from atlas_rows import identity_of_row, point
from grainfit.atlas.row import Row
from grainfit.atlas.shelf import Atlas
from grainfit.atlas.strata import ROW_SCALE, Stratum, strata
from grainfit.atlas.surrogate import points_of, row_values
from grainfit.errors import InputError
from grainfit.formatting import number
from grainfit.solvers.dem.lammps.program import Lammps
from kept_runs import read, scatter, simulate, write

#: The first point of the design that no atlas will have.
_FIRST = 4096
_SEEDS, _FEWEST, _TRIED = 20, 16, 4
Records = Mapping["Run", Mapping[str, Any]]


class Run(NamedTuple):
    """One run of a fresh material."""

    stratum: str
    number: int
    seed: int


def made(run: Run) -> dict[str, Any]:
    """Simulate a run."""
    stratum = strata()[run.stratum]
    try:
        test, material = stratum.simulated(point(stratum, run.number))
    except InputError as error:
        return {"why": str(error)}
    return simulate(Lammps(test, material), run.seed)


def simulate_materials(kept: Path, name: str, count: int, processes: int) -> None:
    """Simulate the runs that are missing until there are so many materials of a stratum."""
    stratum, found, at = strata()[name], 0, _FIRST
    records = read(kept, Run)
    with ProcessPoolExecutor(processes) as pool:
        while found < count:
            for seeds in (range(_TRIED), range(_TRIED, _SEEDS)):
                missing = [run for seed in seeds if (run := Run(name, at, seed)) not in records]
                write(kept, zip(missing, pool.map(made, missing), strict=True))
                records = read(kept, Run)
                if len(_whole(records, stratum, at)) < _TRIED - 1:
                    break
            found += fresh_row(records, stratum, at) is not None
            at += 1
            print(f"{name}: {found} of {count} materials of {at - _FIRST} points", file=sys.stderr)


def _whole(records: Records, stratum: Stratum, at: int) -> list[Mapping[str, float]]:
    """Return the responses of the runs of a point that have them all."""
    return [
        found
        for run, record in records.items()
        if (run.stratum, run.number) == (stratum.name, at)
        and (found := record.get("responses", {})).keys() >= stratum.kind.responses.keys()
    ]


def fresh_row(records: Records, stratum: Stratum, at: int) -> Row | None:
    """Return means and standard errors of a point as a row, None where it is no material."""
    own = _whole(records, stratum, at)
    if len(own) < _FEWEST:
        return None
    responses = {}
    for name, info in stratum.kind.responses.items():
        values, unit = [one[name] for one in own], ROW_SCALE.of(info.unit)
        responses[name] = mean(values) / unit, scatter(values) / len(values) ** 0.5 / unit
    inputs = point(stratum, at)
    return Row(at, 0, inputs, identity_of_row(stratum, inputs), responses, "", 0.0, "")


def fresh_rows(kept: Path, stratum: Stratum) -> list[Row]:
    """Return all materials of a stratum that are kept."""
    records = read(kept, Run)
    numbers = sorted({run.number for run in records if run.stratum == stratum.name})
    return [row for at in numbers if (row := fresh_row(records, stratum, at)) is not None]


def of_responses(kept: Path, names: Sequence[str], atlas: Atlas) -> Iterator[str]:
    """Yield the lines of the table of responses at the true parameters."""
    yield "| stratum | response | materials | median error, tolerances | inside 95 %, % |"
    yield "|---" * 5 + "|"
    for name in names:
        stratum = strata()[name]
        rows = fresh_rows(kept, stratum)
        points = points_of(rows, stratum.ranges)
        for response, model in atlas.require(name).models.items():
            values, errors = row_values(stratum, response, rows)
            told, variances = model.predict(points)
            unit = stratum.kind.responses[response].unit
            off = np.abs(told - values)
            tolerances = [laboratory_error(unit, one) for one in values]
            inside = off <= 1.96 * np.sqrt(variances + errors**2)
            yield (
                f"| {name} | {response} | {len(rows)} | {number(median(off / tolerances), 2)} "
                f"| {100 * inside.mean():.0f} |"
            )


def of_parameters(kept: Path, names: Sequence[str], atlas: Atlas) -> Iterator[str]:
    """Yield the lines of the table of true parameters."""
    yield from HEADING
    for name in names:
        stratum, tally, random = strata()[name], Tally(), np.random.default_rng(1)
        for row in fresh_rows(kept, stratum):
            started = time.perf_counter()
            try:
                found = estimated(stratum, row, atlas, random, is_mean=True)
            except InputError:
                continue
            truth = stratum.simulated(row.inputs).material
            tally.add(found, truth, time.perf_counter() - started)
        yield from tally.lines(name)


def main() -> None:
    """Simulate the materials, or print the tables."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--kept", type=Path, required=True)
    parser.add_argument(
        "--strata", nargs="+", default=["heap", "draw_down"], choices=list(strata())
    )
    parser.add_argument("--materials", type=int, default=40)
    parser.add_argument("--processes", type=int, default=1)
    parser.add_argument("--table", action="store_true", help="of what is kept")
    given = parser.parse_args()
    if not given.table:
        for name in given.strata:
            simulate_materials(given.kept, name, given.materials, given.processes)
    atlas = Atlas()
    for lines in (of_responses, of_parameters):
        print("\n".join(lines(given.kept, given.strata, atlas)), end="\n\n")


if __name__ == "__main__":
    main()
