"""Accuracy of the atlas over the number of its rows: errors on rows that were not used.

For every response the metamodels are fitted to the first rows of the design and predict the others;
of the largest number, four random parts are left out in turn. Printed are the root mean square
error, which contains the scatter of a single run, that scatter, Q2, and the share of rows inside
the 95 % intervals for a single run.

    python benchmarks/atlas_accuracy.py [--rows FOLDER] [--tests heap ...] [--counts 32 64 96]

Prints a table in Markdown.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np

from grainfit.atlas.inputs import ranges_of
from grainfit.atlas.row import Row, rows_in
from grainfit.atlas.shelf import SHIPPED, Atlas
from grainfit.atlas.surrogate import (
    FEWEST_ROWS,
    ResponseModel,
    Surrogate,
    points_of,
    row_values,
)
from grainfit.bulk_tests.base import BulkTest
from grainfit.bulk_tests.registry import bulk_tests
from grainfit.formatting import number

_FOLDS = 4
_FEWEST_LEFT_OUT = 8


def table(folder: Path, tests: Sequence[str], counts: Sequence[int]) -> Iterator[str]:
    """Yield the lines of the table."""
    yield "| test | response | rows | RMSE | of a run | Q2 | inside 95 %, % |"
    yield "|---" * 7 + "|"
    for name in tests:
        kind, rows = bulk_tests()[name], rows_in(folder / f"{name}.jsonl")
        every = Surrogate(kind, rows)
        splits = {count: _splits(kind, rows, count) for count in counts if count < len(rows)}
        splits[len(rows)] = _splits(kind, rows, len(rows))
        for response, model in every.models.items():
            scatter = model.scatter(points_of(rows, ranges_of(kind)))
            for count, parts in splits.items():
                found = _errors(kind, response, parts, float(np.sqrt(np.mean(scatter**2))))
                if found is not None:
                    yield f"| {name} | {response} | {count} | {found} |"


def _splits(
    kind: type[BulkTest], rows: Sequence[Row], count: int
) -> list[tuple[Surrogate, Sequence[Row]]]:
    """Return what so many rows tell, with the rows that were left out."""
    if count < len(rows):
        return [(Surrogate(kind, rows[:count]), rows[count:])]
    # Every fourth point of a Sobol' sequence lies in the same part of the cube: no such folds.
    fold_of = np.random.default_rng(1).permutation(len(rows)) % _FOLDS
    return [
        (
            Surrogate(kind, [row for row, own in zip(rows, fold_of, strict=True) if own != fold]),
            [row for row, own in zip(rows, fold_of, strict=True) if own == fold],
        )
        for fold in range(_FOLDS)
    ]


def _errors(
    kind: type[BulkTest],
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
        found, _ = row_values(kind, response, others)
        mean, deviation = _of_a_run(model, points_of(others, ranges_of(kind)))
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
    parser.add_argument("--tests", nargs="+", default=list(Atlas().tests))
    parser.add_argument("--counts", nargs="+", type=int, default=[32, 64, 96, 128])
    given = parser.parse_args()
    assert min(given.counts) >= FEWEST_ROWS
    print("\n".join(table(given.rows, given.tests, given.counts)))


if __name__ == "__main__":
    main()
