"""Rows of the atlas: simulate those of its design, admit programs, and publish what ships.

Rows belong to a revision of the physics (`grainfit.atlas.shelf`), not to a version of the program:
`sentinels` compares a release of it with the rows that there are.
"""

from __future__ import annotations

import json
import os
import tempfile
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from concurrent.futures import Executor, as_completed
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from scipy.stats import qmc

from grainfit.arrays import Array
from grainfit.atlas.differences import FEWEST_PAIRS, REFERENCE, Difference, difference
from grainfit.atlas.expectation import relative_scatter
from grainfit.atlas.row import REPEATS, Row, rows_in
from grainfit.atlas.shelf import CONTENTS, SHIPPED, hash_of, models_of, revision_of, rows_of
from grainfit.atlas.strata import ROW_SCALE, Stratum, strata
from grainfit.atlas.surrogate import FEWEST_OWN, FEWEST_ROWS, Surrogate, points_of, shares_of
from grainfit.errors import GrainfitError, InputError
from grainfit.evaluation import scalars
from grainfit.files import write_atomically
from grainfit.metamodels.kriging import Kriging
from grainfit.run_definition import identity_of
from grainfit.solvers.base import Workspace
from grainfit.solvers.registry import DEM_PROGRAMS

#: Outcomes of the releases that were compared.
OUTCOMES = SHIPPED.parent / "admitted.json"
#: Digits of the hash of a row's test.
_HASH = 12
#: Scrambling of the design: it stays as it is.
_SCRAMBLING = 20261127
#: Digits of inputs and responses: more than a run tells.
_DIGITS = 6
_ZERO = (0.0, 0.0)


def point(stratum: Stratum, number: int) -> dict[str, float]:
    """Return the inputs of a row: a point of a scrambled Sobol' sequence, which never ends.

    Parameters
    ----------
    stratum : Stratum
        Test and particles.
    number : int
        Of the row, from 0 on.
    """
    ranges = stratum.ranges
    sequence = qmc.Sobol(len(ranges), seed=_SCRAMBLING)
    if number:
        sequence.fast_forward(number)
    shares = sequence.random(1)[0]
    pairs = zip(ranges.items(), shares, strict=True)
    return {name: _rounded(span.at(share), _DIGITS) for (name, span), share in pairs}


def made(
    stratum: Stratum,
    number: int,
    solver_name: str = REFERENCE,
    inputs: Mapping[str, float] | None = None,
) -> Row:
    """Simulate a row of a stratum, at its point of the design or at inputs that it has already."""
    inputs, seed = inputs or point(stratum, number), number + 1
    try:
        test, material = stratum.simulated(inputs)
        solver = DEM_PROGRAMS[solver_name](test, material)
    except GrainfitError as error:
        return Row(number, seed, inputs, "", {}, str(error), 0.0, "")
    row = partial(Row, number, seed, inputs, identity_of_row(stratum, inputs))
    before = os.times().children_user
    found, why = {}, ""
    with tempfile.TemporaryDirectory() as folder:
        try:
            found = scalars(solver.run({}, seed, Workspace(Path(folder))))
        except GrainfitError as error:
            why = str(error)
    seconds = os.times().children_user - before
    units = {name: ROW_SCALE.of(info.unit) for name, info in stratum.kind.responses.items()}
    responses = {
        name: (
            _rounded(one.value / units[name], _DIGITS),
            _rounded(one.standard_error / units[name], 3),
        )
        for name, one in found.items()
    }
    return row(responses, why, round(seconds, 1), f"{solver.title} {solver.version()}")


def grow(
    stratum: Stratum,
    path: Path,
    count: int,
    executor: Executor,
    solver: str = REFERENCE,
    repeats: int = 0,
    least_chance: float = 0.0,
) -> Iterator[Row]:
    """Make the rows of a stratum that are missing, and yield each when it is kept.

    Parameters
    ----------
    stratum : Stratum
        Test and particles.
    path : Path
        File of its rows, which are added at its end.
    count : int
        Rows that the design has then.
    executor : concurrent.futures.Executor
        Makes the runs, here or in the jobs of a cluster. Who opened it ends those that are left.
    solver : str
        That simulates them.
    repeats : int
        So many of the first rows that have responses are there twice then, with another seed: what
        they differ by is the scatter of a run, and not what the metamodel misses.
    least_chance : float
        Points are left for later at which a run has a response with less chance than this, by the
        rows so far: no heap of particles that roll away is another row of none.
    """
    design = {number: point(stratum, number) for number in range(count)}
    likely = likely_points(stratum, rows_in(path), design, least_chance)
    yield from _make(stratum, path, likely, executor, solver)
    rows = [row for row in rows_in(path) if row.responses and not row.is_repeat]
    again = {REPEATS + row.number: row.inputs for row in rows[:repeats]}
    yield from _make(stratum, path, again, executor, solver)


def _make(
    stratum: Stratum,
    path: Path,
    wanted: Mapping[int, Mapping[str, float]],
    executor: Executor,
    solver: str,
) -> Iterator[Row]:
    """Make the rows that are missing, inputs by number, and yield each when it is kept.

    Those that are lost with a job are missing still: the first error is raised after the others.
    """
    known = {row.number for row in rows_in(path) if is_of_today(stratum, row)}
    missing = {number: inputs for number, inputs in wanted.items() if number not in known}
    lost: list[BaseException] = []
    with path.open("a", encoding="utf-8") as file:
        # A line that was cut off must not swallow the next one.
        file.write("\n" if file.tell() else "")
        of_rows = [(stratum, number, solver, inputs) for number, inputs in missing.items()]
        for done in as_completed([executor.submit(made, *of_row) for of_row in of_rows]):
            if error := done.exception():
                lost.append(error)
                continue
            row = done.result()
            file.write(row.to_text() + "\n")
            file.flush()
            os.fsync(file.fileno())
            yield row
    if lost:
        raise lost[0]


def likely_points(
    stratum: Stratum,
    rows: Sequence[Row],
    design: Mapping[int, Mapping[str, float]],
    least: float,
) -> Mapping[int, Mapping[str, float]]:
    """Return the points, inputs by number, at which a run has a response with this chance."""
    if len(rows) < FEWEST_ROWS or least == 0:
        return design
    has = np.array([float(bool(row.responses)) for row in rows])
    chance = Kriging.fit(points_of(rows, stratum.ranges), has, linear_trend=False)
    found = chance.mean(shares_of(design.values(), stratum.ranges))
    return {n: design[n] for n, share in zip(design, found, strict=True) if share >= least}


def left_out_in_turn(
    rows: Sequence[Row], parts: int, random: np.random.Generator
) -> Iterator[tuple[list[Row], list[Row]]]:
    """Yield the rows that stay and those that are left out, for every random part of the points.

    Repeats are left out with the row that they repeat, and are none of those that are looked at.
    """
    # Every fourth point of a Sobol' sequence lies in the same part of the cube: random parts.
    points = np.array([row.point for row in rows if not row.is_repeat])
    part_of = random.permutation(len(points)) % parts
    for part in range(parts):
        yield split(rows, points[part_of == part])


def split(rows: Sequence[Row], points: Sequence[int] | Array) -> tuple[list[Row], list[Row]]:
    """Return the rows of all other points, and those of these without repeats."""
    out = {int(point) for point in points}
    stay = [row for row in rows if row.point not in out]
    return stay, [row for row in rows if row.point in out and not row.is_repeat]


def identity_of_row(stratum: Stratum, inputs: Mapping[str, float]) -> str:
    """Return a short hash of the test of a row, but for its time step, with all its options."""
    return identity_of(stratum.apparatus(inputs, ROW_SCALE).definition())[:_HASH]


def is_of_today(stratum: Stratum, row: Row) -> bool:
    """Return whether a row was simulated in the apparatus that its inputs mean today."""
    try:
        return row.test == identity_of_row(stratum, row.inputs)
    except InputError:
        return not row.test


def admitted_programs(path: Path = OUTCOMES) -> frozenset[str]:
    """Return the programs, solver and version, whose rows are admitted."""
    found = _read(path)
    agreeing = (one["program"] for one in found["compared"] if one["agrees"])
    return frozenset({found["first"], *agreeing})


def record(outcome: Mapping[str, Any], path: Path = OUTCOMES) -> None:
    """Keep the outcome of a comparison, instead of an earlier one of the same program.

    Parameters
    ----------
    outcome : mapping
        Has the ``program``, and whether it ``agrees``.
    path : Path
        File of the outcomes.
    """
    found = _read(path)
    others = [one for one in found["compared"] if one["program"] != outcome["program"]]
    found["compared"] = [*others, dict(outcome)]
    write_atomically(path, json.dumps(found, indent=1) + "\n")


def _read(path: Path) -> dict[str, Any]:
    found: dict[str, Any] = json.loads(path.read_text(encoding="utf-8"))
    return found


def publish(source: Path, folder: Path) -> Iterator[str]:
    """Fit the metamodels to the rows of a folder and write both into another, and yield the strata.

    Rows of an apparatus that their inputs do not mean any more are left out, and those of a program
    that is not admitted.

    Parameters
    ----------
    source : Path
        Has a file ``NAME.jsonl`` of rows for every stratum.
    folder : Path
        Where the atlas is written.
    """
    contents: dict[str, Any] = {}
    published: dict[str, list[Row]] = {}
    # A point that is no possible test was simulated by none.
    admitted = {*admitted_programs(), ""}
    for name, stratum in strata().items():
        rows = [row for row in rows_in(rows_of(source, name)) if is_of_today(stratum, row)]
        for program, count in Counter(row.program for row in rows).items():
            if program not in admitted:
                yield (
                    f"{name}: {count} rows of {program} are left out, which is not admitted: run "
                    "benchmarks/atlas_sentinels.py with it."
                )
        rows = [row for row in rows if row.program in admitted]
        # Strata of dry spheres come first: their rows are a limit of the others'.
        least = FEWEST_OWN if stratum.limit else FEWEST_ROWS
        if len(rows) < least or stratum.kind.type not in {name, *published}:
            continue
        published[name] = rows
        surrogate = Surrogate(stratum, rows, published[stratum.kind.type])
        write_rows(rows, rows_of(folder, name))
        write_atomically(
            models_of(folder, name), json.dumps(surrogate.to_plain(), separators=(",", ":"))
        )
        contents[name] = {
            "revision": revision_of(stratum.kind),
            "rows": hash_of(rows_of(folder, name)),
            "models": hash_of(models_of(folder, name)),
            "count": len(rows),
            "solvers": _differences(stratum, surrogate, source, folder),
        }
        yield f"{name}: {len(rows)} rows, {len(surrogate.models)} responses"
    found = {"licence": "CC0-1.0", "strata": contents}
    write_atomically(folder / CONTENTS, json.dumps(found, indent=1) + "\n")


def _differences(
    stratum: Stratum, surrogate: Surrogate, source: Path, folder: Path
) -> dict[str, dict[str, tuple[float, float]]]:
    """Return how far other solvers are from LAMMPS, and write their rows into the folder."""
    found = {}
    for solver in DEM_PROGRAMS:
        path = rows_of(source, stratum.name, solver)
        if solver != REFERENCE and path.exists():
            own = [row for row in rows_in(path) if is_of_today(stratum, row)]
            found[solver] = dict(differences_of(stratum, surrogate, own))
            write_rows(own, rows_of(folder, stratum.name, solver))
    return found


def write_rows(rows: Sequence[Row], path: Path) -> None:
    """Write the rows of `rows_in`."""
    write_atomically(path, "".join(f"{row.to_text()}\n" for row in rows))


def differences_of(
    stratum: Stratum, surrogate: Surrogate, rows: Sequence[Row]
) -> Iterator[tuple[str, Difference]]:
    """Yield how far rows of another solver are from those of the same numbers, by response.

    Parameters
    ----------
    stratum : Stratum
        Test and particles.
    surrogate : Surrogate
        Has the rows of LAMMPS.
    rows : sequence of Row
        Of the other solver.
    """
    for name in surrogate.models:
        pairs = pairs_of(stratum, surrogate, rows, name)
        if len(pairs.own) >= FEWEST_PAIRS:
            told = difference(*pairs)
            yield name, Difference(_rounded(told.mean, 3), _rounded(told.spread, 3))


class Pairs(NamedTuple):
    """A response in rows that two solvers made, each of shape (n,)."""

    own: Array
    reference: Array
    scatter: Array


def pairs_of(stratum: Stratum, surrogate: Surrogate, rows: Sequence[Row], name: str) -> Pairs:
    """Return a response in rows of another solver and in those of LAMMPS at the same inputs.

    The scatter is that of a run over its response. A response that is zero, as the flow out of an
    arched outlet is, has no relative difference, and is left out.
    """
    known = {row.number: row for row in surrogate.rows if row.responses.get(name, _ZERO)[0]}
    own = [
        row
        for row in rows
        if row.number in known
        and row.inputs == known[row.number].inputs
        and row.responses.get(name, _ZERO)[0]
    ]
    info, model = stratum.kind.responses[name], surrogate.models[name]
    return Pairs(
        np.array([row.responses[name][0] for row in own]),
        np.array([known[row.number].responses[name][0] for row in own]),
        relative_scatter(info, model, points_of(own, stratum.ranges)) if own else np.empty(0),
    )


def _rounded(value: float, digits: int) -> float:
    return float(f"{value:.{digits}g}")
