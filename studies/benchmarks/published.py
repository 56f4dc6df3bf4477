"""Published figures of the benchmarks, from the tables in ``data``."""

from __future__ import annotations

import csv
from functools import cache
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

DATA = Path(__file__).parent / "data"


def rows_of(file: str, **values: str) -> list[dict[str, str]]:
    """Return the rows of a table in ``data`` whose columns have these values."""
    with (DATA / file).open(encoding="utf-8") as lines:
        rows = csv.DictReader(line for line in lines if not line.startswith("#"))
        return [row for row in rows if values.items() <= row.items()]


@cache
def curve(name: str, series: str) -> NDArray[np.float64]:
    """Return the points of a published curve, shape (n, 2).

    Parameters
    ----------
    name : str
        File in ``data/chung_ooi``, without its ending.
    series : str
        Value of its first column.
    """
    with (DATA / "chung_ooi" / f"{name}.csv").open(encoding="utf-8") as file:
        rows = csv.reader(line for line in file if not line.startswith("#"))
        return np.array([row[1:] for row in rows if row[0] == series], dtype=float)
