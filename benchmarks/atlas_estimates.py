"""Do the intervals of estimates by the atlas hold the truth? On rows that the atlas was not given.

The rows of a stratum are divided into four random parts. For each, an atlas is made of the others,
and every row of the part is a material and an apparatus, its responses are measured values (one
run, whose scatter is added to a laboratory's error of 1 % of the density or length and 1 degree),
and both frictions and the density of the particles are estimated.

    python benchmarks/atlas_estimates.py [--rows FOLDER] [--strata heap]

Prints a table in Markdown: materials, share of the 95 % intervals that hold the truth, the median
width of an interval over that of the one that was given, and the median time of an estimate.
"""

from __future__ import annotations

import argparse
import math
import shutil
import tempfile
import time
from collections import defaultdict
from collections.abc import Iterator, Sequence
from pathlib import Path
from statistics import median

import numpy as np

from atlas_rows import publish, write_rows
from grainfit.atlas.estimate import Estimate, estimate_of
from grainfit.atlas.row import Row, rows_in
from grainfit.atlas.shelf import SHIPPED, Atlas, rows_of
from grainfit.atlas.strata import ROW_SCALE, Stratum, strata
from grainfit.atlas.surrogate import points_of
from grainfit.bulk_tests.parameter_names import DENSITY, ROLLING, SLIDING
from grainfit.bulk_tests.size import size_power
from grainfit.errors import InputError
from grainfit.problem import Parameter, Problem, Target
from grainfit.solvers.dem.lammps.program import Lammps

_PARTS = 4
#: Interval of the density about the true one: its place in it is random.
_DENSITY_SPAN = 1.3
_FREE = (SLIDING, ROLLING, DENSITY)
#: Friction from which a logarithmic interval begins at least.
_LEAST = 0.01


def table(folder: Path, names: Sequence[str]) -> Iterator[str]:
    """Yield the lines of the table."""
    yield "| stratum | parameter | materials | inside 95 %, % | width | s |"
    yield "|---" * 6 + "|"
    for name in names:
        stratum, rows = strata()[name], rows_in(rows_of(folder, name))
        random = np.random.default_rng(1)
        part_of = random.permutation(len(rows)) % _PARTS
        inside, widths, seconds = defaultdict(list), defaultdict(list), []
        for part in range(_PARTS):
            left_out = [row for row, own in zip(rows, part_of, strict=True) if own == part]
            others = [row for row, own in zip(rows, part_of, strict=True) if own != part]
            with tempfile.TemporaryDirectory() as place:
                atlas = atlas_of(stratum, others, Path(place))
                for row in left_out:
                    if row.responses.keys() < stratum.kind.responses.keys():
                        continue
                    started = time.perf_counter()
                    try:
                        found = _estimate(stratum, row, atlas, random)
                    except InputError:
                        # In the middle of its intervals, the material lies beyond the rows.
                        continue
                    seconds.append(time.perf_counter() - started)
                    truth = stratum.simulated(row.inputs).material
                    for one in found.parameters:
                        given = one.parameter
                        inside[given.name].append(one.low <= truth[given.name] <= one.high)
                        ends = [given.to_unit(end) for end in (one.low, one.high)]
                        widths[given.name].append(ends[1] - ends[0])
        for free in inside:
            share, count = 100 * float(np.mean(inside[free])), len(inside[free])
            yield (
                f"| {name} | {free} | {count} | {share:.0f} | {median(widths[free]):.2f} "
                f"| {median(seconds):.1f} |"
            )


def atlas_of(stratum: Stratum, rows: Sequence[Row], folder: Path) -> Atlas:
    """Return an atlas of some rows of a stratum, published in an empty folder."""
    source, place = folder / "rows", folder / "atlas"
    source.mkdir()
    place.mkdir()
    shutil.copy(rows_of(SHIPPED, stratum.kind.type), source)
    write_rows(rows, rows_of(source, stratum.name))
    list(publish(source, place))
    atlas = Atlas(place)
    assert atlas.of_stratum(stratum.name) is not None
    return atlas


def _estimate(stratum: Stratum, row: Row, atlas: Atlas, random: np.random.Generator) -> Estimate:
    test, material = stratum.simulated(row.inputs)
    ranges = stratum.ranges
    start = float(random.uniform(1 / _DENSITY_SPAN, 1.0)) * material[DENSITY]
    parameters = [
        *(
            Parameter(name, max(ranges[name].low, _LEAST), ranges[name].high, scale="log")
            for name in (SLIDING, ROLLING)
        ),
        Parameter(DENSITY, start, _DENSITY_SPAN * start),
    ]
    surrogate = atlas.of_stratum(stratum.name)
    assert surrogate is not None
    at = points_of([row], stratum.ranges)
    targets = []
    for name, (value, _) in row.responses.items():
        unit = ROW_SCALE.of(stratum.kind.responses[name].unit)
        grown = row.inputs["size"] ** (size_power(stratum.kind, name) or 0.0)
        scatter = float(surrogate.models[name].scatter(at)[0]) * unit * grown
        measured = 1.0 if stratum.kind.responses[name].unit == "deg" else 0.01 * value * unit
        error = math.hypot(scatter, measured)
        targets.append(Target(name, value * unit, uncertainty=error))
    fixed = {name: one for name, one in material.items() if name not in _FREE}
    return estimate_of(
        Problem(parameters, targets), {stratum.kind.type: Lammps(test, fixed)}, atlas
    )


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--rows", type=Path, default=SHIPPED)
    parser.add_argument("--strata", nargs="+", default=["heap"])
    given = parser.parse_args()
    print("\n".join(table(given.rows, given.strata)))


if __name__ == "__main__":
    main()
