"""Growing the atlas: the runs of its design that are not made yet."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor, as_completed
from functools import partial
from pathlib import Path

from scipy.stats import qmc

from grainfit.atlas.inputs import ROW_SCALE, identity_of_row, is_of_today, ranges_of, simulated
from grainfit.atlas.row import Row, rows_in
from grainfit.bulk_tests.base import BulkTest
from grainfit.errors import GrainfitError
from grainfit.evaluation import scalars
from grainfit.solvers.base import Workspace
from grainfit.solvers.dem.lammps.program import Lammps

#: Scrambling of the design: it stays as it is.
_SCRAMBLING = 20261127
#: Digits of inputs and responses: more than a run tells.
_DIGITS = 6


def point(kind: type[BulkTest], number: int) -> dict[str, float]:
    """Return the inputs of a row: a point of a scrambled Sobol' sequence, which never ends.

    Parameters
    ----------
    kind : type
        Class of the test.
    number : int
        Of the row, from 0 on.
    """
    ranges = ranges_of(kind)
    sequence = qmc.Sobol(len(ranges), seed=_SCRAMBLING)
    if number:
        sequence.fast_forward(number)
    shares = sequence.random(1)[0]
    pairs = zip(ranges.items(), shares, strict=True)
    return {name: _rounded(span.at(share), _DIGITS) for (name, span), share in pairs}


def made(kind: type[BulkTest], number: int) -> Row:
    """Simulate a row of the atlas."""
    inputs, seed = point(kind, number), number + 1
    try:
        test, material = simulated(kind, inputs)
        solver = Lammps(test, material)
    except GrainfitError as error:
        return Row(number, seed, inputs, "", {}, str(error), 0.0, "")
    row = partial(Row, number, seed, inputs, identity_of_row(kind, inputs))
    before = os.times().children_user
    found, why = {}, ""
    with tempfile.TemporaryDirectory() as folder:
        try:
            found = scalars(solver.run({}, seed, Workspace(Path(folder))))
        except GrainfitError as error:
            why = str(error)
    seconds = os.times().children_user - before
    units = {name: ROW_SCALE.of(info.unit) for name, info in kind.responses.items()}
    responses = {
        name: (
            _rounded(one.value / units[name], _DIGITS),
            _rounded(one.standard_error / units[name], 3),
        )
        for name, one in found.items()
    }
    return row(responses, why, round(seconds, 1), f"{solver.title} {solver.version()}")


def grow(kind: type[BulkTest], path: Path, count: int, processes: int = 1) -> Iterator[Row]:
    """Make the rows of a test that are missing, and yield each when it is kept.

    Parameters
    ----------
    kind : type
        Class of the test.
    path : Path
        File of its rows, which are added at its end.
    count : int
        Rows that the design has then.
    processes : int
        Runs at a time.
    """
    known = {row.number for row in rows_in(path) if is_of_today(kind, row)}
    missing = [number for number in range(count) if number not in known]
    with ProcessPoolExecutor(processes) as pool, path.open("a", encoding="utf-8") as file:
        # A line that was cut off must not swallow the next one.
        file.write("\n" if file.tell() else "")
        waiting = [pool.submit(made, kind, number) for number in missing]
        try:
            for done in as_completed(waiting):
                row = done.result()
                file.write(row.to_text() + "\n")
                file.flush()
                os.fsync(file.fileno())
                yield row
        finally:
            pool.shutdown(cancel_futures=True)


def _rounded(value: float, digits: int) -> float:
    return float(f"{value:.{digits}g}")
