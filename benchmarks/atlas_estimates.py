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
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from statistics import median

import numpy as np

from atlas_rows import left_out_in_turn, publish, write_rows
from grainfit.atlas.estimate import Estimate, estimate_of
from grainfit.atlas.row import Row, rows_in
from grainfit.atlas.shelf import SHIPPED, Atlas, rows_of
from grainfit.atlas.strata import ROW_SCALE, Stratum, strata
from grainfit.atlas.surrogate import points_of
from grainfit.bulk_tests.parameter_names import DENSITY, ROLLING, SLIDING
from grainfit.errors import InputError
from grainfit.problem import Parameter, Problem, Target
from grainfit.solvers.dem.lammps.program import Lammps

_PARTS = 4
#: Interval of the density about the true one: its place in it is random.
_DENSITY_SPAN = 1.3
_FREE = (SLIDING, ROLLING, DENSITY)
#: Of the table.
HEADING = ("| stratum | parameter | materials | inside 95 %, % | width | s |", "|---" * 6 + "|")
#: Friction from which a logarithmic interval begins at least.
_LEAST = 0.01


def table(folder: Path, names: Sequence[str]) -> Iterator[str]:
    """Yield the lines of the table."""
    yield from HEADING
    for name in names:
        stratum, rows = strata()[name], rows_in(rows_of(folder, name))
        random, tally = np.random.default_rng(1), Tally()
        for others, left_out in left_out_in_turn(rows, _PARTS, random):
            with tempfile.TemporaryDirectory() as place:
                atlas = atlas_of(stratum, others, Path(place))
                for row in left_out:
                    if row.responses.keys() < stratum.kind.responses.keys():
                        continue
                    started = time.perf_counter()
                    try:
                        found = estimated(stratum, row, atlas, random)
                    except InputError:
                        continue
                    truth = stratum.simulated(row.inputs).material
                    tally.add(found, truth, time.perf_counter() - started)
        yield from tally.lines(name)


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


def estimated(
    stratum: Stratum,
    row: Row,
    atlas: Atlas,
    random: np.random.Generator,
    *,
    is_mean: bool = False,
) -> Estimate:
    """Return the estimate for the responses of a row, measured with the error of a laboratory.

    Raises
    ------
    InputError
        In the middle of its intervals, the material lies beyond the rows.
    """
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
    surrogate = atlas.require(stratum.name)
    at = points_of([row], stratum.ranges)
    targets = []
    for name, model in surrogate.models.items():
        unit = ROW_SCALE.of(stratum.kind.responses[name].unit)
        value, error = (unit * one for one in row.responses[name])
        laboratory = laboratory_error(stratum.kind.responses[name].unit, value)
        if is_mean:
            value += laboratory * float(random.standard_normal())
        else:
            scatter = float(model.scatter(at)[0]) * stratum.proportion(name, row.inputs)
            error = scatter * unit
        targets.append(Target(name, value, uncertainty=math.hypot(error, laboratory)))
    fixed = {name: one for name, one in material.items() if name not in _FREE}
    return estimate_of(
        Problem(parameters, targets), {stratum.kind.type: Lammps(test, fixed)}, atlas
    )


def laboratory_error(unit: str, value: float) -> float:
    """Return the standard uncertainty of a measured value, in its unit."""
    return 1.0 if unit == "deg" else 0.01 * value


class Tally:
    """Intervals of estimates that hold the truth, and how wide they are."""

    def __init__(self) -> None:
        self._inside: dict[str, list[bool]] = defaultdict(list)
        self._widths: dict[str, list[float]] = defaultdict(list)
        self._seconds: list[float] = []

    def add(self, found: Estimate, truth: Mapping[str, float], seconds: float) -> None:
        """Add the estimate of a material, which took some seconds."""
        self._seconds.append(seconds)
        for one in found.parameters:
            given = one.parameter
            self._inside[given.name].append(one.low <= truth[given.name] <= one.high)
            ends = [given.to_unit(end) for end in (one.low, one.high)]
            self._widths[given.name].append(ends[1] - ends[0])

    def lines(self, name: str) -> Iterator[str]:
        """Yield the lines of a stratum in the table."""
        for free, inside in self._inside.items():
            yield (
                f"| {name} | {free} | {len(inside)} | {100 * float(np.mean(inside)):.0f} "
                f"| {median(self._widths[free]):.2f} | {median(self._seconds):.1f} |"
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
