"""Maximin Latin hypercubes: annealing compared with the best of many random ones, and with STK.

The reference is the practice of the paper, `stk_sampling_maximinlhs` with 5,000 x d random Latin
hypercubes (jittered, as STK draws them), written here in batches of NumPy operations, which is
faster than STK itself. STK runs too when Octave and its package stk are installed.

    python benchmarks/latin_hypercube.py [--seeds 5] [--json]
"""

from __future__ import annotations

import argparse
import json
import os
import shutil
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from typing import Any

os.environ["OMP_NUM_THREADS"] = "1"

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.distance import pdist

from grainfit.metamodels.designs import maximin_latin_hypercube

SIZES = ((26, 2), (21, 5), (60, 8))
LARGE_SIZES = ((140, 14), (300, 14))
_BATCH = 500

Design = NDArray[np.float64]
Row = dict[str, Any]


def best_of_random(n: int, d: int, seed: int) -> Design:
    """Return the best of 5,000 x d random Latin hypercubes by smallest distance, shape (n, d)."""
    random = np.random.default_rng(seed)
    strata = np.tile(np.arange(n, dtype=np.float32), (_BATCH * d, 1))
    first, second = np.triu_indices(n, 1)
    best, best_squared = np.empty((n, d)), -1.0
    for _ in range(5_000 * d // _BATCH):
        designs = random.permuted(strata, axis=1).reshape(_BATCH, d, n)
        designs = (designs + random.random(designs.shape, dtype=np.float32)) / n
        squared = np.zeros((_BATCH, len(first)), dtype=np.float32)
        for k in range(d):
            difference = designs[:, k, first] - designs[:, k, second]
            squared += difference * difference
        smallest = squared.min(axis=1)
        if smallest.max() > best_squared:
            best_squared = smallest.max()
            best = designs[smallest.argmax()].T.astype(float)
    return best


def timed(make: Callable[[int, int, int], Design], n: int, d: int, seed: int) -> Row:
    start = time.perf_counter()
    points = make(n, d, seed)
    return {"seconds": time.perf_counter() - start, "distance": float(pdist(points).min())}


_STK = """
pkg load stk;
rand('twister', {seed});
tic; x = stk_sampling_maximinlhs({n}, {d}, [], 5000 * {d}); t = toc;
printf('%.10g %.10g', t, stk_mindist(x));
"""


def stk(n: int, d: int, seed: int) -> Row | None:
    """Make the design with STK in Octave; None if it is not installed."""
    if shutil.which("octave") is None:
        return None
    done = subprocess.run(
        ["octave", "--quiet", "--no-gui", "--eval", _STK.format(n=n, d=d, seed=seed + 1)],
        capture_output=True,
        text=True,
    )
    if done.returncode != 0:
        return None
    seconds, distance = map(float, done.stdout.split()[-2:])
    return {"seconds": seconds, "distance": distance}


def measure(seeds: int) -> Iterator[Row]:
    for n, d in SIZES:
        # In turn, so that other load of the machine affects all of them equally.
        for seed in range(seeds):
            for method, make in (
                ("grainfit", maximin_latin_hypercube),
                ("best of random", best_of_random),
            ):
                yield {"n": n, "d": d, "seed": seed, "method": method} | timed(make, n, d, seed)
        if (result := stk(n, d, 0)) is not None:
            yield {"n": n, "d": d, "seed": 0, "method": "STK"} | result
    for n, d in LARGE_SIZES:
        row = {"n": n, "d": d, "seed": 0, "method": "grainfit"}
        yield row | timed(maximin_latin_hypercube, n, d, 0)


def print_table(rows: list[Row]) -> None:
    print(
        f"{'n':>4} {'d':>3}  {'method':<15} {'seeds':>5}  smallest distance (min, mean)   time, s"
    )
    groups: dict[tuple[object, ...], list[Row]] = {}
    for row in rows:
        groups.setdefault((row["n"], row["d"], row["method"]), []).append(row)
    for (n, d, method), group in groups.items():
        distances = [float(row["distance"]) for row in group]
        seconds = np.median([float(row["seconds"]) for row in group])
        print(
            f"{n:>4} {d:>3}  {method:<15} {len(group):>5}  "
            f"{min(distances):>14.4f} {np.mean(distances):>13.4f} {seconds:>12.3f}"
        )


def main() -> int:
    """Print the table, or JSON; return 1 if annealing is worse or slower at any size."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seeds", type=int, default=5, help="designs of each kind and size")
    parser.add_argument("--json", action="store_true", help="print JSON instead of a table")
    arguments = parser.parse_args()
    maximin_latin_hypercube(10, 2, 0)  # the first call also loads parts of NumPy
    rows = list(measure(arguments.seeds))
    if arguments.json:
        print(json.dumps(rows, indent=1))
    else:
        print_table(rows)

    def of(method: str, size: tuple[int, int], key: str) -> list[float]:
        chosen = [r for r in rows if r["method"] == method and (r["n"], r["d"]) == size]
        return [float(row[key]) for row in chosen]

    good = all(
        min(of("grainfit", size, "distance")) >= max(of("best of random", size, "distance"))
        and np.median(of("grainfit", size, "seconds"))
        <= np.median(of("best of random", size, "seconds"))
        for size in SIZES
    )
    return 0 if good else 1


if __name__ == "__main__":
    sys.exit(main())
