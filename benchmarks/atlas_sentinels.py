"""Compare the installed LAMMPS with the one of the atlas: 20 of its rows, made again.

A release is admitted, so that rows of it may be published, when all responses agree within the
errors of the rows (`sentinels`). Rows made again are kept in the file ``--kept`` and
not repeated.

    python benchmarks/atlas_sentinels.py --kept FILE [--record]

Prints the deviations of every test, and whether the release is admitted; ``--record`` writes the
outcome into the package.
"""

from __future__ import annotations

import argparse
import os
from pathlib import Path
from typing import Any, NamedTuple

from atlas_rows import made, record
from grainfit.atlas.row import Row
from grainfit.atlas.shelf import Atlas
from grainfit.atlas.strata import strata
from grainfit.solvers.dem.lammps.program import Lammps
from kept_runs import measure, read
from sentinels import compare, sentinels


class Sentinel(NamedTuple):
    """One row that is made again."""

    program: str
    stratum: str
    number: int


def _installed(atlas: Atlas) -> str:
    kind = strata()[atlas.strata[0]].kind
    solver = Lammps(kind(diameter=0.01), {})
    return f"{solver.title} {solver.version()}"


def _made(one: Sentinel) -> dict[str, Any]:
    surrogate = Atlas().require(one.stratum)
    [inputs] = [row.inputs for row in surrogate.rows if row.number == one.number]
    return {"row": made(strata()[one.stratum], one.number, inputs=inputs).to_text()}


def main() -> None:
    """Make the rows that are missing, and compare."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--kept", type=Path, required=True)
    parser.add_argument("--record", action="store_true")
    given = parser.parse_args()
    os.environ.setdefault("OMP_NUM_THREADS", "1")
    atlas = Atlas()
    program = _installed(atlas)
    wanted = [Sentinel(program, name, row.number) for name, row in sentinels(atlas)]
    measure(wanted, given.kept, _made)
    kept = read(given.kept, Sentinel)
    found = compare(atlas, [(one.stratum, Row.from_text(kept[one]["row"])) for one in wanted])
    print(f"{program}: {found.runs} rows, {len(found.deviations)} responses")
    for name, shift in found.shifts.items():
        print(f"{name}: mean deviation {shift:+.2f} standard errors")
    print(f"largest deviation {found.largest:.2f}, limit {found.limit:.2f}")
    print("\n".join(f"missing: {name}" for name in found.missing))
    print("admitted" if found.agrees else "not admitted")
    if given.record:
        record(found.to_plain())


if __name__ == "__main__":
    main()
