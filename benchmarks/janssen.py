"""Measure which share of a bed's weight its floor carries: after the fill, and after a re-seating.

A column of particles falls into a tube, comes to rest, and its floor is then lowered by half a
diameter, quasi-statically. The share of the floor in the weight right after the fill depends on the
height of fall, the width of the tube over the diameter, and the stiffness. The share after the
lowering is compared with Janssen's (1 - exp(-a)) / a, a = 4 m K H / D. K is that of the bed: the
mean normal stress on the tube over the mean vertical stress, which is the sum over all contacts
(`compute stress/atom` of LAMMPS, and the floor's own contacts). m is the force along the tube over
that normal to it. Finished runs are kept in the file ``--kept`` and not repeated, so that the
command can be stopped and started again.

    python benchmarks/janssen.py --kept benchmarks/data/janssen.jsonl [--seeds 2]
        [--widths 8 12] [--drops 0 1 2] [--moduli 1e6] [--height 2.0] [--table]

A drop of 0 begins as a cubic lattice, which falls least; 1 is the random column of the bulk tests;
2 is that column stretched to twice its height.
"""

from __future__ import annotations

import argparse
import math
from collections.abc import Iterator, Mapping
from itertools import product
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from grainfit.bulk_tests.own_scene.bulk_test import OwnScene
from grainfit.materials.sizes import ParticleSizes
from grainfit.scenes import (
    AtRest,
    Box,
    Cylinder,
    Elapsed,
    Force,
    Frames,
    Plane,
    RadialForce,
    Round,
    Scene,
    Series,
    Stage,
    Velocity,
    Wall,
    natural_time,
    random_column,
)
from grainfit.scenes.packing import Column
from grainfit.scenes.run_output import RunOutput
from grainfit.solvers.dem.lammps.program import Lammps
from grainfit.solvers.dem.lammps.scene_deck import LammpsSceneDeck
from grainfit.testing.materials import GLASS_BEADS
from kept_runs import mean_and, read, simulate
from kept_runs import measure as measure_all

DIAMETER = 0.010
#: Ways of the floor at which its share is read, in diameters.
WAYS = (0.1, 0.2, 0.3, 0.4, 0.5)
_STRESS = "c_stress[3]"


class Run(NamedTuple):
    """What is varied: the width in particles, the height in widths, the modulus in Pa."""

    seed: int
    width: float
    height: float
    drop: float
    modulus: float


class StressDeck(LammpsSceneDeck):
    """A deck whose snapshots have the vertical virial of every particle."""

    def head(self) -> Iterator[str]:
        """Iterate over the settings of the simulation."""
        yield from super().head()
        yield "compute stress all stress/atom NULL virial"

    @property
    def snapshot_columns(self) -> str:
        """Columns of a snapshot."""
        return f"{super().snapshot_columns} {_STRESS}"

    def snapshot(self, name: str) -> Iterator[str]:
        """Write the particles into a file: the virial is known at steps of a run only."""
        yield f"dump {name} all custom 1 snapshots/{name}.dump {self.snapshot_columns}"
        yield f"dump_modify {name} sort id"
        yield "run 0 post no"
        yield f"undump {name}"


class StressLammps(Lammps):
    """LAMMPS with these decks."""

    deck = StressDeck


def column_of(sizes: ParticleSizes, options: Mapping[str, float], seed: int) -> Column:
    """Return the particles of the beginning."""
    d, radius, count = sizes.sauter_diameter, options["radius"], int(options["count"])
    if options["drop"] == 0:
        return _lattice(d, radius, count, seed)
    column = random_column(sizes, count, Round(radius), seed)
    places = column.positions.copy()
    places[:, 2] = d + (places[:, 2] - d) * options["drop"]
    return Column(places, column.size_indices, float(places[:, 2].max()) + d)


def _lattice(d: float, radius: float, count: int, seed: int) -> Column:
    spacing, random = 1.03 * d, np.random.default_rng(seed)
    side = np.arange(-radius, radius, spacing)
    reach = radius - 0.53 * d
    flat = np.array([(x, y) for x, y in product(side, side) if math.hypot(x, y) < reach])
    layers = [
        np.column_stack((flat, np.full(len(flat), (n + 0.6) * spacing)))
        for n in range(math.ceil(count / len(flat)))
    ]
    places = np.vstack(layers)[:count] + random.uniform(-0.01, 0.01, (count, 3)) * d
    return Column(places, np.zeros(count, dtype=np.int64), float(places[:, 2].max()) + d)


def scene(
    material: Mapping[str, float],
    sizes: ParticleSizes,
    seed: int,
    gravity: float,
    time_step: float,
    options: Mapping[str, float],
) -> Scene:
    """Return the experiment: fill, lower the floor, come to rest."""
    d, radius = sizes.sauter_diameter, options["radius"]
    column, t = column_of(sizes, options, seed), natural_time(sizes, gravity)
    columns = {"floor": Force("floor", "z"), "along": Force("tube", "z")}
    recorded = Series({**columns, "normal": RadialForce("tube")}, t)
    lower, side = 100 * t, radius + d
    down = {"floor": Velocity("z", -WAYS[-1] * d / lower)}
    fall = 2 * math.sqrt(column.height / gravity)
    return Scene(
        title="Janssen",
        material=material,
        sizes=sizes,
        particles=column,
        box=Box((-side, -side, -2 * d), (side, side, column.height + d)),
        walls={
            "floor": Wall(Plane("z", 0.0)),
            "tube": Wall(Cylinder(radius, -2 * d, column.height + d)),
        },
        stages=(
            Stage("fill", AtRest(600 * t, at_least=20 * t + fall), is_closed=True, snapshot="bed"),
            Stage("hold", Elapsed(6 * t), series=recorded, snapshot="held"),
            Stage("lower", Elapsed(lower), motions=down, series=recorded),
            Stage("stop", AtRest(600 * t, at_least=10 * t), series=recorded),
            Stage("after", Elapsed(6 * t), series=recorded, frames=Frames("ending", 3 * t)),
        ),
        gravity=gravity,
        time_step=time_step,
        quiet_speed=0.002 * math.sqrt(gravity * d),
        check_interval=2 * t,
    )


def vertical_virial(path: Path) -> float:
    """Return the sum of the vertical virial of the particles, N m; positive where they press."""
    lines = path.read_text().split("ITEM: ATOMS")[-1].splitlines()
    at = lines[0].split().index(_STRESS)
    return -sum(float(line.split()[at]) for line in lines[1:])


def measure(
    run: RunOutput, sizes: ParticleSizes, gravity: float, options: Mapping[str, float]
) -> dict[str, float]:
    """Return the shares of the floor, and what Janssen's formula needs."""
    d, radius, found = sizes.sauter_diameter, options["radius"], {}
    bed = run.snapshot("held")
    weight = float(bed.masses.sum()) * gravity
    found["fall"] = (options["centre"] - float(bed.positions[:, 2].mean())) / d
    for stage, snapshot in (("hold", "held"), ("after", "end")):
        forces = {name: float(c[-4:].mean()) for name, c in run.series(stage).items()}
        floor, along, normal = -forces["floor"], -forces["along"], forces["normal"]
        places = run.snapshot(snapshot).positions[:, 2]
        bottom = float(places.min()) - d / 2
        height = 2 * (float(places.mean()) - bottom)
        virial = vertical_virial(run.path_of(f"snapshots/{snapshot}.dump")) + floor * d / 2
        vertical = virial / (math.pi * radius**2 * height)
        ratio = normal / (2 * math.pi * radius * height) / vertical
        exponent = 2 * ratio * along / normal * height / radius
        share = (1 - math.exp(-exponent)) / exponent
        found |= {
            f"{stage}_floor": floor / weight,
            f"{stage}_sum": (floor + along) / weight,
            f"{stage}_mobilised": along / normal,
            f"{stage}_stress_ratio": ratio,
            f"{stage}_height": height / (2 * radius),
            f"{stage}_janssen": share,
        }
    lowered = run.series("lower")
    begin, end = lowered["time"][0], lowered["time"][-1]
    for way in WAYS:
        at = begin + (end - begin) * way / WAYS[-1]
        near = np.abs(lowered["time"] - at) < 0.03 * (end - begin)
        found[f"lowered_{way:g}"] = -float(lowered["floor"][near].mean()) / weight
    return found


def material_of(run: Run) -> Mapping[str, float]:
    """Return the material: sliding friction 0.5 between particles, 0.4 on walls, no rolling."""
    frictions = {"particle_particle": 0.5, "particle_wall": 0.4}
    return {
        **GLASS_BEADS,
        "particle.youngs_modulus": run.modulus,
        **{f"{pair}.sliding_friction": value for pair, value in frictions.items()},
        **{f"{pair}.rolling_friction": 0.0 for pair in frictions},
        **{f"{pair}.rolling_damping": 0.0 for pair in frictions},
        **{f"{pair}.restitution": 0.6 for pair in frictions},
    }


def record_of(run: Run) -> dict[str, Any]:
    """Simulate a run."""
    options = {
        "radius": run.width * DIAMETER / 2,
        "count": round(0.57 * 1.5 * run.width**3 * run.height),
        "drop": run.drop,
    }
    column = column_of(ParticleSizes((DIAMETER,)), options, run.seed)
    options["centre"] = float(column.positions[:, 2].mean())
    here = Path(__file__)
    test = OwnScene(
        diameter=DIAMETER, scene=f"{here}:scene", measure=f"{here}:measure", options=options
    )
    return simulate(StressLammps(test, material_of(run)), run.seed)


def table(records: Mapping[Run, dict[str, Any]]) -> Iterator[str]:
    """Yield the lines of the table in Markdown, one for every setting."""
    yield (
        "| D / d | H / D | modulus, MPa | fall of the centre, d | runs | floor after the fill "
        "| lowered by 0.1 d | by 0.5 d | at rest | Janssen | K | floor + wall |"
    )
    yield "|---" * 12 + "|"
    for setting in dict.fromkeys(run._replace(seed=0) for run in sorted(records)):
        own = [r for run, r in records.items() if run._replace(seed=0) == setting]
        good = [r["responses"] for r in own if "responses" in r]
        if good:
            columns = {name: [one[name] for one in good] for name in good[0]}
            cells = [f"{setting.width:g}", f"{np.mean(columns['hold_height']):.2f}"]
            cells += [f"{setting.modulus / 1e6:g}", f"{np.mean(columns['fall']):.1f}"]
            cells += [str(len(good))]
            names = ("hold_floor", "lowered_0.1", "lowered_0.5", "after_floor", "after_janssen")
            names += ("after_stress_ratio",)
            cells += [mean_and(_scatter, columns[name]) for name in names]
            sums = [*columns["hold_sum"], *columns["after_sum"]]
            cells += [f"{min(sums):.4f} to {max(sums):.4f}"]
            yield f"| {' | '.join(cells)} |"
        yield from (f"{setting}: {r['why']}" for r in own if "why" in r)


def _scatter(values: Any) -> float:
    return float(np.std(values, ddof=1))


def main() -> None:
    """Make the runs that are missing, and print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--kept", type=Path, required=True)
    parser.add_argument("--seeds", type=int, default=2)
    parser.add_argument("--widths", type=float, nargs="+", default=[8.0])
    parser.add_argument("--drops", type=float, nargs="+", default=[0.0, 1.0, 2.0])
    parser.add_argument("--moduli", type=float, nargs="+", default=[1e6])
    parser.add_argument("--height", type=float, default=2.0, help="of the bed, in widths")
    parser.add_argument("--table", action="store_true", help="only print what is known")
    given = parser.parse_args()
    cases = product(range(1, given.seeds + 1), given.widths, given.drops, given.moduli)
    runs = [Run(seed, width, given.height, drop, modulus) for seed, width, drop, modulus in cases]
    if not given.table:
        measure_all(runs, given.kept, record_of)
    print("\n".join(table(read(given.kept, Run))))


if __name__ == "__main__":
    main()
