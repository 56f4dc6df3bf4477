"""Check the atlas beyond its rows: the recorded series of larger apparatus, and its usual one.

The runs of `size_series.py` (rough soft spheres in apparatus of 1, 4 and 10 times the particles)
are no rows of the atlas; the larger ones lie beyond its sizes, on the trend.

    python benchmarks/atlas_trends.py [--kept benchmarks/data/size_series.jsonl]

Prints a table in Markdown: the mean of the runs with its standard error, what the atlas expects
with its standard error, and the difference over both errors.
"""

from __future__ import annotations

import argparse
import math
from collections import defaultdict
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from grainfit.atlas.reading import NotInAtlasError, Reading
from grainfit.atlas.shelf import Atlas
from grainfit.bulk_tests.registry import bulk_tests
from grainfit.formatting import number
from grainfit.solvers.dem.lammps.program import Lammps
from kept_runs import read
from size_series import Run, larger, material_of

_KEPT = Path(__file__).parent / "data" / "size_series.jsonl"


def table(kept: Path) -> Iterator[str]:
    """Yield the lines of the table."""
    yield "| test | times the particles | response | runs | simulated | atlas | off, errors |"
    yield "|---" * 7 + "|"
    groups = defaultdict(list)
    for run, record in read(kept, Run).items():
        if "responses" in record:
            groups[run._replace(seed=0)].append(record["responses"])
    atlas = Atlas()
    for run, found in sorted(groups.items()):
        surrogate = atlas.of_stratum(run.test)
        if surrogate is None:
            continue
        test, material = larger(run.test, run.times), material_of(run.test, run.modulus)
        try:
            reading = Reading(Lammps(test, material), {})
            reading.require_inside(material)
        except NotInAtlasError as error:
            yield f"| {run.test} | {run.times:g} | {error} | | | | |"
            continue
        values = {name: np.array([value]) for name, value in material.items()}
        for name, model in surrogate.models.items():
            simulated = [one[name] for one in found if name in one]
            if len(simulated) < 2:
                continue
            unit = float(reading.unit(name, values).item())
            mean, variance = model.predict(reading.shares(values))
            mine, error = float(mean[0]) * unit, math.sqrt(float(variance[0])) * unit
            theirs = float(np.mean(simulated))
            of_mean = float(np.std(simulated, ddof=1)) / math.sqrt(len(simulated))
            off = (mine - theirs) / math.hypot(error, of_mean)
            info = bulk_tests()[run.test].responses[name]
            yield (
                f"| {run.test} | {run.times:g} | {name}, {info.unit or '1'} | {len(simulated)} "
                f"| {number(theirs, 4)} ± {number(of_mean, 2)} | {number(mine, 4)} ± "
                f"{number(error, 2)} | {off:+.1f} |"
            )


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--kept", type=Path, default=_KEPT)
    print("\n".join(table(parser.parse_args().kept)))


if __name__ == "__main__":
    main()
