"""Grow the atlas: simulate the rows of its design that are missing, a stratum after the other.

Finished rows are kept in the folder ``--kept``, one file of JSON lines a stratum, so that the
command can be stopped and started again, with more rows as well.

    python benchmarks/grow_atlas.py --kept FOLDER [--strata heap heap-clumps ...] [--rows 128]
        [--repeats 0] [--least-chance 0] [--processes 1 | --cluster FILE] [--solver lammps]
    python benchmarks/grow_atlas.py --kept FOLDER --publish src/grainfit/atlas/rows

With ``--cluster`` the runs are made in the jobs that the ``[cluster]`` of a calibration file
describes; the folder must be one that the nodes share. The second fits the metamodels to the rows
of LAMMPS that are kept, and the differences of other solvers to theirs, and writes what ships.
"""

from __future__ import annotations

import argparse
import os
from collections.abc import Iterator
from concurrent.futures import Executor, ProcessPoolExecutor
from contextlib import contextmanager
from pathlib import Path

from atlas_rows import grow, publish
from grainfit.atlas.differences import REFERENCE
from grainfit.atlas.shelf import rows_of
from grainfit.atlas.strata import strata
from grainfit.calibration_file.build import load_calibration
from grainfit.campaign.cluster.executor import cluster_executor
from grainfit.solvers.registry import DEM_PROGRAMS


def main() -> None:
    """Make the rows that are missing."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--kept", type=Path, required=True)
    parser.add_argument("--strata", nargs="+", default=list(strata()), choices=list(strata()))
    parser.add_argument("--rows", type=int, default=128)
    parser.add_argument("--repeats", type=int, default=0, help="rows with a second seed")
    parser.add_argument(
        "--least-chance", type=float, default=0.0, help="that a row has responses, by those so far"
    )
    parser.add_argument("--processes", type=int, default=1)
    parser.add_argument("--cluster", type=Path, help="calibration file with [cluster]")
    parser.add_argument("--solver", default=REFERENCE, choices=list(DEM_PROGRAMS))
    parser.add_argument("--publish", type=Path, help="folder of the atlas that ships")
    given = parser.parse_args()
    if given.publish:
        print("\n".join(publish(given.kept, given.publish)))
        return
    os.environ.setdefault("OMP_NUM_THREADS", "1")
    given.kept.mkdir(parents=True, exist_ok=True)
    with _executor(given.processes, given.cluster, given.kept) as executor:
        for name in given.strata:
            path = rows_of(given.kept, name, given.solver)
            how = executor, given.solver, given.repeats, given.least_chance
            for row in grow(strata()[name], path, given.rows, *how):
                print(f"{name} {row.number}: {row.seconds} CPU s {row.why[:80]}", flush=True)


@contextmanager
def _executor(processes: int, file: Path | None, kept: Path) -> Iterator[Executor]:
    """Open what makes the runs: the jobs of a cluster, as a calibration has them, or processes."""
    if file is None:
        with ProcessPoolExecutor(processes) as pool:
            try:
                yield pool
            finally:
                pool.shutdown(cancel_futures=True)
        return
    options = load_calibration(file).cluster
    if options is None:
        raise SystemExit(f"{file} has no [cluster].")
    # The workers of the jobs import this folder, too.
    paths = [str(Path(__file__).parent.absolute()), os.environ.get("PYTHONPATH", "")]
    os.environ["PYTHONPATH"] = os.pathsep.join(filter(None, paths))
    with cluster_executor(options, kept) as jobs:
        yield jobs


if __name__ == "__main__":
    main()
