"""Measure what the way of filling changes in the responses of the bulk tests, and what it costs.

- ``rain``: the tests' own, a random column that falls.
- ``low``: a cubic lattice, which falls least.
- ``high``: the random column stretched to twice its height.
- ``reseated``: rain, and then the floor is lowered by half a diameter, quasi-statically, and the
  bed comes to rest again, so that it hangs in the friction of the walls (`janssen.py`).

The drum turns its bed over, and the shear has no walls to hang on: they are left out. Finished runs
are kept in the file ``--kept`` and not repeated, so that the command can be stopped and started
again.

    python benchmarks/filling.py --kept benchmarks/data/filling.jsonl [--seeds 12]
        [--tests heap ...] [--ways rain low high reseated] [--table]

Prints each response with its standard deviation, its change from ``rain`` with two standard errors,
and the processor time of a run.
"""

from __future__ import annotations

import argparse
import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from itertools import product
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from grainfit.bulk_tests.base import BulkTest
from grainfit.bulk_tests.registry import bulk_tests
from grainfit.formatting import number
from grainfit.scenes.conditions import AtRest, Elapsed
from grainfit.scenes.packing import Column, Round
from grainfit.scenes.run_output import STAGES, RunOutput
from grainfit.scenes.scene import Scene, Stage, Velocity, natural_time
from grainfit.scenes.shapes import Block, Disc, Plane
from grainfit.solvers.dem.lammps.program import Lammps
from grainfit.testing.materials import ROUGH_PLATE
from kept_runs import mean_and, measure, read, scatter, simulate
from size_series import material_of

DIAMETER = 0.010
WAYS = ("rain", "low", "high", "reseated")
#: Walls below the bed of each test.
FLOORS: Mapping[str, tuple[str, ...]] = {
    "packing": ("floor",),
    "heap": ("plate",),
    "discharge": ("left_shelf", "right_shelf", "door"),
    "draw_down": ("left_shelf", "right_shelf", "door"),
    "compression": ("floor",),
}
#: Way of the floor when a bed is re-seated, in diameters.
_WAY = 0.5
_EXTRA = ("pour", "lower")


class Run(NamedTuple):
    """What is varied."""

    test: str
    way: str
    seed: int


def filled(test: str, way: str) -> BulkTest:
    """Return a test that is filled in some way."""
    kind: Any = bulk_tests()[test]

    @dataclass(frozen=True)
    class Filled(kind):  # type: ignore[misc]
        def column(self, seed: int) -> Column:
            column: Column = super().column(seed)
            if way == "low":
                return lattice(self.footprint, len(column.positions), seed)
            if way == "high":
                places = column.positions.copy()
                places[:, 2] = DIAMETER + (places[:, 2] - DIAMETER) * 2
                return replace(column, positions=places, height=2 * column.height)
            return column

        def scene_of(self, column: Column, material: Mapping[str, float]) -> Scene:
            scene: Scene = super().scene_of(column, material)
            return _reseated(scene, FLOORS[test]) if way == "reseated" else scene

        def measure(self, run: RunOutput) -> Any:
            ends = run.folder / STAGES
            lines = [x for x in ends.read_text().splitlines() if not x.startswith(_EXTRA)]
            ends.write_text("\n".join(lines) + "\n")
            return super().measure(run)

    return Filled(diameter=DIAMETER, **(ROUGH_PLATE if test == "heap" else {}))


def lattice(outline: Any, count: int, seed: int, d: float = DIAMETER) -> Column:
    """Return particles on a cubic lattice that begins at the floor."""
    random = np.random.default_rng(seed)
    spacing, reach = 1.03 * d, 0.53 * d
    if isinstance(outline, Round):
        side = np.arange(-outline.radius, outline.radius, spacing)
        places = [
            (x, y) for x, y in product(side, side) if math.hypot(x, y) < outline.radius - reach
        ]
    else:
        deep = max(int(outline.depth / spacing), 1)
        across = np.arange(-outline.width / 2 + reach, outline.width / 2 - reach, spacing)
        places = [(x, (n + 0.5) * outline.depth / deep) for x in across for n in range(deep)]
    flat = np.array(places)
    layers = [
        np.column_stack((flat, np.full(len(flat), (n + 0.6) * spacing)))
        for n in range(math.ceil(count / len(flat)))
    ]
    found = np.vstack(layers)[:count] + random.uniform(-0.01, 0.01, (count, 3)) * d
    return Column(found, np.zeros(count, dtype=np.int64), float(found[:, 2].max()) + d)


def _reseated(scene: Scene, floors: tuple[str, ...]) -> Scene:
    """Return a scene whose floor begins higher, and is lowered before the procedure begins."""
    way, t = _WAY * DIAMETER, natural_time(scene.sizes, scene.gravity)
    fill, *rest = scene.stages
    raised = {name: replace(scene.walls[name], shape=_raised(scene, name)) for name in floors}
    places = scene.particles.positions + np.array((0.0, 0.0, way))
    column = replace(scene.particles, positions=places, height=scene.particles.height + way)
    slow = 100 * t
    down = dict.fromkeys(floors, Velocity("z", -way / slow))
    stages = (
        replace(fill, name="pour", snapshot="", series=None),
        Stage("lower", Elapsed(slow), motions=down),
        replace(fill, until=AtRest(600 * t, at_least=10 * t)),
        *rest,
    )
    return replace(scene, particles=column, walls={**scene.walls, **raised}, stages=stages)


def _raised(scene: Scene, name: str) -> Any:
    shape, way = scene.walls[name].shape, _WAY * DIAMETER
    if isinstance(shape, Disc):
        return replace(shape, z=shape.z + way)
    if isinstance(shape, Plane):
        return replace(shape, at=shape.at + way)
    assert isinstance(shape, Block)
    (x, y, z), (far_x, far_y, far_z) = shape.low, shape.high
    return Block((x, y, z + way), (far_x, far_y, far_z + way))


def record_of(run: Run) -> dict[str, Any]:
    """Simulate once."""
    return simulate(Lammps(filled(run.test, run.way), material_of(run.test)), run.seed)


def table(records: Mapping[Run, dict[str, Any]]) -> Iterator[str]:
    """Yield the lines of the table in Markdown, one for every response and way of filling."""
    yield "| test | response | unit | filling | runs | mean ± scatter | change, % | CPU s a run |"
    yield "|---" * 8 + "|"
    for test in FLOORS:
        own = {run: r for run, r in records.items() if run.test == test}
        for name, info in bulk_tests()[test].responses.items():
            usual = _values(own, "rain", name)
            for way in WAYS:
                values = _values(own, way, name)
                if len(values) > 1 and len(usual) > 1:
                    seconds = np.mean([r["seconds"] for run, r in own.items() if run.way == way])
                    cells = [test, name, info.unit or "1", way, str(len(values))]
                    cells += [mean_and(scatter, values)]
                    cells += [_change(usual, values) if way != "rain" else ""]
                    yield f"| {' | '.join([*cells, number(float(seconds), 2)])} |"
        yield from (f"{run}: {r['why']}" for run, r in own.items() if "why" in r)


def _values(records: Mapping[Run, dict[str, Any]], way: str, name: str) -> list[float]:
    good = [r["responses"] for run, r in records.items() if run.way == way and "responses" in r]
    return [responses[name] for responses in good if name in responses]


def _change(usual: list[float], values: list[float]) -> str:
    """Return the relative change of a mean in per cent, with two standard errors."""
    error = math.hypot(*(scatter(v) / math.sqrt(len(v)) for v in (usual, values)))
    mean = float(np.mean(usual))
    return f"{100 * (float(np.mean(values)) - mean) / mean:+.1f} ± {200 * error / mean:.1f}"


def main() -> None:
    """Make the runs that are missing, and print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--kept", type=Path, required=True)
    parser.add_argument("--seeds", type=int, default=12)
    parser.add_argument("--tests", nargs="+", default=list(FLOORS), choices=list(FLOORS))
    parser.add_argument("--ways", nargs="+", default=list(WAYS), choices=list(WAYS))
    parser.add_argument("--table", action="store_true", help="only print what is known")
    given = parser.parse_args()
    seeds = range(1, given.seeds + 1)
    runs = [Run(test, way, seed) for seed, test, way in product(seeds, given.tests, given.ways)]
    if not given.table:
        measure(runs, given.kept, record_of)
    print("\n".join(table(read(given.kept, Run))))


if __name__ == "__main__":
    main()
