"""Accuracy of the atlas over the number of its rows: errors on rows that were not used.

For every response the metamodels are fitted to the first rows of the design and predict the others;
of the largest number, four random parts are left out in turn. Printed are the root mean square
error, which contains the scatter of a single run, that scatter, Q2, and the share of rows inside
the 95 % intervals for a single run. ``--alone`` leaves out the rows of dry spheres, which are known
of other particles as well.

    python benchmarks/atlas_accuracy.py [--rows FOLDER] [--strata heap ...] [--counts 32 64 96]
        [--alone]

Prints a table in Markdown.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np

from atlas_rows import left_out_in_turn, split
from grainfit.atlas.row import Row, rows_in
from grainfit.atlas.shelf import SHIPPED, Atlas, rows_of
from grainfit.atlas.strata import Stratum, strata
from grainfit.atlas.surrogate import (
    FEWEST_ROWS,
    ResponseModel,
    Surrogate,
    points_of,
    row_values,
)
from grainfit.formatting import number

_FOLDS = 4
_FEWEST_LEFT_OUT = 8


def table(
    folder: Path, names: Sequence[str], counts: Sequence[int], *, is_alone: bool = False
) -> Iterator[str]:
    """Yield the lines of the table."""
    yield "| stratum | response | rows | RMSE | of a run | Q2 | inside 95 %, % |"
    yield "|---" * 7 + "|"
    for name in names:
        stratum, rows = strata()[name], rows_in(rows_of(folder, name))
        dry = [] if is_alone else rows_in(rows_of(folder, stratum.kind.type))
        every = Surrogate(stratum, rows, dry)
        points = sum(not row.is_repeat for row in rows)
        wanted = [*(count for count in counts if count < points), points]
        splits = {count: _splits(stratum, rows, dry, count) for count in wanted}
        for response, model in every.models.items():
            scatter = model.scatter(points_of(rows, stratum.ranges))
            for count, parts in splits.items():
                found = _errors(stratum, response, parts, float(np.sqrt(np.mean(scatter**2))))
                if found is not None:
                    yield f"| {name} | {response} | {count} | {found} |"


def _splits(
    stratum: Stratum, rows: Sequence[Row], dry: Sequence[Row], count: int
) -> list[tuple[Surrogate, Sequence[Row]]]:
    """Return what so many points tell, with the rows that were left out, with their repeats."""
    points = [row.point for row in rows if not row.is_repeat]
    if count < len(points):
        parts = [split(rows, points[count:])]
    else:
        parts = [*left_out_in_turn(rows, _FOLDS, np.random.default_rng(1))]
    return [(Surrogate(stratum, stay, dry), left_out) for stay, left_out in parts]


def _errors(
    stratum: Stratum,
    response: str,
    splits: Sequence[tuple[Surrogate, Sequence[Row]]],
    scatter: float,
) -> str | None:
    """Return the cells of a response, None with too few rows."""
    off, expected, values = [], [], []
    for used, left_out in splits:
        others = [row for row in left_out if response in row.responses]
        model = used.models.get(response)
        if model is None or len(others) < _FEWEST_LEFT_OUT:
            continue
        found, _ = row_values(stratum, response, others)
        mean, deviation = _of_a_run(model, points_of(others, stratum.ranges))
        off.append(mean - found)
        expected.append(deviation)
        values.append(found)
    if not off:
        return None
    errors, deviations, all_values = (np.concatenate(one) for one in (off, expected, values))
    rmse = float(np.sqrt(np.mean(errors**2)))
    inside = float(np.mean(np.abs(errors) <= 1.96 * deviations))
    q2 = 1 - rmse**2 / float(np.var(all_values))
    return " | ".join([number(rmse, 3), number(scatter, 3), number(q2, 3), f"{100 * inside:.0f}"])


def _of_a_run(model: ResponseModel, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    mean, variance = model.predict(points)
    return mean, np.sqrt(variance + model.scatter(points) ** 2)


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--rows", type=Path, default=SHIPPED)
    parser.add_argument("--strata", nargs="+", default=list(Atlas().strata))
    parser.add_argument("--counts", nargs="+", type=int, default=[32, 64, 96, 128])
    parser.add_argument("--alone", action="store_true")
    given = parser.parse_args()
    assert min(given.counts) >= FEWEST_ROWS
    print("\n".join(table(given.rows, given.strata, given.counts, is_alone=given.alone)))


if __name__ == "__main__":
    main()
