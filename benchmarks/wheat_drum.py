"""Simulate a drum with a published angle of wheat: 36.17 degrees with a deviation of 3.1.

Sugirbay et al. (2022, Agriculture 12:1497) turned wheat (grains of 3.8 mm, 1400 kg/m^3) in an
upright drum of 150 x 50 mm, half full, at 5 rpm. Here it is a slice without end walls, of a lined
drum, with clumps of the same volume as a sphere of 3.8 mm and an aspect ratio of a wheat grain. The
frictions of the grains are not known here, so they are varied. Finished runs are kept in the file
``--kept`` and not repeated, so that the command can be stopped and started again.

    python benchmarks/wheat_drum.py --kept wheat.jsonl [--solver lammps] [--seeds 1]
        [--shapes two_spheres] [--aspect-ratio 1.9] [--slidings 0.3 0.5] [--rolling 0]
        [--length 0.0152] [--table]
"""

from __future__ import annotations

import argparse
import statistics
from collections.abc import Iterator, Mapping
from itertools import product
from pathlib import Path
from typing import Any, NamedTuple

from grainfit.bulk_tests.drum import Drum
from grainfit.materials.particle_shape import FAMILIES, ParticleShape
from grainfit.materials.sizes import ParticleSizes
from grainfit.solvers.registry import DEM_PROGRAMS
from grainfit.testing.materials import GLASS_BEADS
from kept_runs import mean_and, measure, read, simulate

#: Measured angle and its deviation, degrees.
MEASURED, DEVIATION = 36.17, 3.1
DIAMETER = 0.0038
#: The bed is half of the drum at the measured bulk density of 780 kg/m^3; the fill level counts
#: with a solid fraction of 0.58.
FILL_LEVEL = 0.5 * 780 / 1400 / 0.58
ANGLES = ("dynamic_angle", "surface_angle")


class Run(NamedTuple):
    """What is varied; the length of the slice in m."""

    seed: int
    solver: str
    shape: str
    aspect_ratio: float
    sliding: float
    rolling: float
    length: float


def material_of(run: Run) -> Mapping[str, float]:
    """Return the material of a run; 1 MPa is 19,000 times the weight of a grain on its section."""
    return {
        **GLASS_BEADS,
        "particle.density": 1400.0,
        "particle.poissons_ratio": 0.3,
        "particle.youngs_modulus": 1e6,
        **{
            f"{pair}.{name}": value
            for pair in ("particle_particle", "particle_wall")
            for name, value in (
                ("sliding_friction", run.sliding),
                ("rolling_friction", run.rolling),
                ("restitution", 0.5),
                ("rolling_damping", 0.0),
            )
        },
    }


def record_of(run: Run) -> dict[str, Any]:
    """Simulate a run."""
    shape = (
        None if run.shape == "sphere" else ParticleShape(run.shape, aspect_ratio=run.aspect_ratio)
    )
    drum = Drum(
        ParticleSizes((DIAMETER,), shape=shape),
        drum_radius="75 mm",
        drum_length=run.length,
        rotational_speed="5 rpm",
        fill_level=FILL_LEVEL,
        discarded_turns=0.3,
        averaged_turns=0.4,
    )
    return simulate(DEM_PROGRAMS[run.solver](drum, material_of(run)), run.seed)


def table(records: Mapping[Run, dict[str, Any]]) -> Iterator[str]:
    """Yield the lines of the table in Markdown, one for every setting."""
    yield (
        "| solver | shape | sliding friction | rolling friction | slice, mm | seeds "
        "| dynamic angle, ° | surface angle, ° | CPU s |"
    )
    yield "|---" * 9 + "|"
    for setting in dict.fromkeys(run._replace(seed=0) for run in sorted(records)):
        own = {run: r for run, r in records.items() if run._replace(seed=0) == setting}
        found = [r["responses"] for r in own.values() if "responses" in r]
        if found:
            shape = "sphere" if setting.shape == "sphere" else _words(setting)
            cells = [setting.solver, shape, f"{setting.sliding:g}", f"{setting.rolling:g}"]
            cells += [f"{1000 * setting.length:g}", str(len(found))]
            cells += [mean_and(statistics.stdev, [r[name] for r in found]) for name in ANGLES]
            cells += [f"{statistics.median(r['seconds'] for r in own.values()):.0f}"]
            yield f"| {' | '.join(cells)} |"
        yield from (f"{run}: {r['why']}" for run, r in own.items() if "why" in r)
    yield f"Measured: {MEASURED}° ± {DEVIATION}°."


def _words(setting: Run) -> str:
    return f"{setting.shape}, {setting.aspect_ratio:g}"


def main() -> None:
    """Make the runs that are missing, and print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--kept", type=Path, required=True)
    parser.add_argument("--solver", choices=sorted(DEM_PROGRAMS), default="lammps")
    parser.add_argument("--seeds", type=int, default=1)
    parser.add_argument(
        "--shapes", nargs="+", choices=("sphere", *FAMILIES), default=["two_spheres"]
    )
    parser.add_argument("--aspect-ratio", type=float, default=1.9)
    parser.add_argument("--slidings", type=float, nargs="+", default=[0.3, 0.5])
    parser.add_argument("--rolling", type=float, default=0.0)
    parser.add_argument("--length", type=float, default=4 * DIAMETER)
    parser.add_argument("--table", action="store_true", help="only print what is known")
    given = parser.parse_args()
    cases = product(range(1, given.seeds + 1), given.shapes, given.slidings)
    runs = [
        Run(seed, given.solver, shape, given.aspect_ratio, sliding, given.rolling, given.length)
        for seed, shape, sliding in cases
    ]
    if not given.table:
        measure(runs, given.kept, record_of)
    print("\n".join(table(read(given.kept, Run))))


if __name__ == "__main__":
    main()
