"""Measure which share of a bed's weight its floor carries: after the fill, and after a re-seating.

A column of particles falls into a tube, comes to rest, and its floor is then lowered by half a
diameter, quasi-statically. The share of the floor in the weight right after the fill depends on the
height of fall, the width of the tube over the diameter, and the stiffness. The share after the
lowering is compared with Janssen's (1 - exp(-a)) / a, a = 4 m K H / D. K is that of the bed: the
mean normal stress on the tube over the mean vertical stress (`grainfit.testing.lowered_bed`). m is
the force along the tube over that normal to it, so that a is the force along the tube over the mean
vertical force. Finished runs are kept in the file ``--kept`` and not repeated, so that the command
can be stopped and started again.

    python benchmarks/janssen.py --kept benchmarks/data/janssen.jsonl [--seeds 2]
        [--solvers lammps] [--widths 8 12] [--drops 0 1 2] [--moduli 1e6] [--height 2.0]
        [--law own] [--table]

A drop of 0 begins as a cubic lattice, which falls least; 1 is the random column of the bulk tests;
2 is that column stretched to twice its height. The law ``new`` is that with which ``grainfit new``
begins.
"""

from __future__ import annotations

import argparse
from collections import defaultdict
from collections.abc import Iterator, Mapping
from itertools import product
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from filling import lattice
from grainfit.bulk_tests.own_scene.bulk_test import OwnScene
from grainfit.materials.sizes import ParticleSizes
from grainfit.scenes.packing import Column, Round, random_column
from grainfit.scenes.run_output import RunOutput
from grainfit.scenes.scene import Scene
from grainfit.solvers.registry import DEM_PROGRAMS
from grainfit.testing.lowered_bed import Tube, floor_shares, lowered_bed
from grainfit.testing.materials import GLASS_BEADS
from kept_runs import mean_and, read, scatter, simulate
from kept_runs import measure as measure_all
from new_law import LAWS, NEW, OWN, material_of_new

DIAMETER = 0.010
#: Programs that do not know the radial force of a ring, so that K and m are not known one by one.
WITHOUT_RADIAL = ("liggghts",)


class Run(NamedTuple):
    """What is varied: the width in particles, the height in widths, the modulus in Pa."""

    solver: str
    seed: int
    width: float
    height: float
    drop: float
    modulus: float
    law: str


def column_of(sizes: ParticleSizes, options: Mapping[str, float], seed: int) -> Column:
    """Return the particles of the beginning."""
    d, radius, count = sizes.sauter_diameter, options["radius"], int(options["count"])
    if options["drop"] == 0:
        return lattice(Round(radius), count, seed, d)
    column = random_column(sizes, count, Round(radius), seed)
    places = column.positions.copy()
    places[:, 2] = d + (places[:, 2] - d) * options["drop"]
    return Column(places, column.size_indices, float(places[:, 2].max()) + d)


def _tube(options: Mapping[str, float]) -> Tube:
    return Tube(options["radius"], options["height"], bool(options["radial"]))


def scene(
    material: Mapping[str, float],
    sizes: ParticleSizes,
    seed: int,
    gravity: float,
    time_step: float,
    options: Mapping[str, float],
) -> Scene:
    """Return the experiment: fill, lower the floor, come to rest."""
    column = column_of(sizes, options, seed)
    return lowered_bed(_tube(options), column, material, sizes, gravity, time_step)


def measure(
    run: RunOutput, sizes: ParticleSizes, gravity: float, options: Mapping[str, float]
) -> dict[str, float]:
    """Return the fall of the bed in diameters, and the shares of the floor."""
    places = run.snapshot("held").positions[:, 2]
    fall = (options["centre"] - float(places.mean())) / sizes.sauter_diameter
    return {"fall": fall} | floor_shares(run, _tube(options), sizes, gravity)


def material_of(run: Run) -> Mapping[str, float]:
    """Return the material: sliding friction 0.5 between particles, 0.4 on walls, no rolling.

    That of a new file has its own frictions.
    """
    if run.law == NEW:
        return {**material_of_new(), "particle.youngs_modulus": run.modulus}
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
        "height": run.height * run.width * DIAMETER,
        "radial": float(run.solver not in WITHOUT_RADIAL),
    }
    column = column_of(ParticleSizes((DIAMETER,)), options, run.seed)
    options["centre"] = float(column.positions[:, 2].mean())
    here = Path(__file__)
    test = OwnScene(
        diameter=DIAMETER, scene=f"{here}:scene", measure=f"{here}:measure", options=options
    )
    return simulate(DEM_PROGRAMS[run.solver](test, material_of(run)), run.seed)


def table(records: Mapping[Run, dict[str, Any]]) -> Iterator[str]:
    """Yield the lines of the table in Markdown, one for every setting."""
    yield (
        "| law | solver | D / d | H / D | modulus, MPa | fall of the centre, d | runs "
        "| floor after the fill | lowered by 0.1 d | by 0.5 d | at rest | Janssen | K "
        "| floor + wall |"
    )
    yield "|---" * 14 + "|"
    for setting in dict.fromkeys(run._replace(seed=0) for run in sorted(records)):
        own = [r for run, r in records.items() if run._replace(seed=0) == setting]
        good = [r["responses"] for r in own if "responses" in r]
        if good:
            columns = defaultdict(list, {name: [one[name] for one in good] for name in good[0]})
            cells = [
                setting.law,
                setting.solver,
                f"{setting.width:g}",
                f"{np.mean(columns['hold_height']):.2f}",
            ]
            cells += [f"{setting.modulus / 1e6:g}", f"{np.mean(columns['fall']):.1f}"]
            cells += [str(len(good))]
            names = ("hold_floor", "lowered_0.1", "lowered_0.5", "after_floor", "after_janssen")
            names += ("after_stress_ratio",)
            cells += [mean_and(scatter, columns[name]) if columns[name] else "–" for name in names]
            sums = [*columns["hold_sum"], *columns["after_sum"]]
            cells += [f"{min(sums):.4f} to {max(sums):.4f}"]
            yield f"| {' | '.join(cells)} |"
        yield from (f"{setting}: {r['why']}" for r in own if "why" in r)


def main() -> None:
    """Make the runs that are missing, and print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--kept", type=Path, required=True)
    parser.add_argument("--seeds", type=int, default=2)
    parser.add_argument("--solvers", nargs="+", default=["lammps"], choices=list(DEM_PROGRAMS))
    parser.add_argument("--widths", type=float, nargs="+", default=[8.0])
    parser.add_argument("--drops", type=float, nargs="+", default=[0.0, 1.0, 2.0])
    parser.add_argument("--moduli", type=float, nargs="+", default=[1e6])
    parser.add_argument("--height", type=float, default=2.0, help="of the bed, in widths")
    parser.add_argument("--law", default=OWN, choices=LAWS)
    parser.add_argument("--table", action="store_true", help="only print what is known")
    given = parser.parse_args()
    seeds = range(1, given.seeds + 1)
    cases = product(given.solvers, seeds, given.widths, [given.height], given.drops, given.moduli)
    runs = [Run(*case, given.law) for case in cases]
    if not given.table:
        measure_all(runs, given.kept, record_of)
    print("\n".join(table(read(given.kept, Run))))


if __name__ == "__main__":
    main()
