"""Measure the flow out of hoppers: Beverloo's law for round outlets and slots, and half angles.

Finished runs are kept in the file ``--kept`` and not repeated, so that the command can be stopped
and started again.

    python benchmarks/hopper.py --kept benchmarks/data/hopper.jsonl [--seeds 3]
        [--solvers lammps] [--orifices round slot] [--half-angles 30 90]
        [--law own] [--table]

The first two tables are flat-bottomed vessels of three outlets each: the exponent n of
``flow = C rho_b sqrt(g) ... (W - k d)^n`` with k = 1.5, and C and k with n = 5/2 (round) or 3/2
(slot). The third has the flow over the half angle of a cone and a wedge, over that of a flat floor.
The law ``new`` is that with which ``grainfit new`` begins.

References
----------
Beverloo, Leniger & van de Velde (1961), Chem. Eng. Sci. 15, 260-269.
"""

from __future__ import annotations

import argparse
import math
from collections.abc import Iterator, Mapping
from dataclasses import replace
from itertools import product
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from grainfit.bulk_tests.hopper import Hopper
from grainfit.bulk_tests.time_steps import safe_time_step_fraction
from grainfit.solvers.registry import DEM_PROGRAMS
from grainfit.testing.materials import ROUGH_SPHERES
from kept_runs import mean_and, measure, read, scatter, simulate
from new_law import LAWS, NEW, OWN, material_of_new

DIAMETER, GRAVITY = 0.010, 9.81
#: Outlets in diameters, and the one of all half angles in degrees.
OUTLETS, OUTLET, HALF_ANGLES = (5.0, 6.5, 8.0), 6.0, (15.0, 30.0, 45.0, 60.0, 90.0)
#: Width of flat-bottomed vessels in diameters, and height of the bed: a slot empties sooner.
FLAT_WIDTH, FLAT_HEIGHT = {"round": 18.0, "slot": 24.0}, {"round": 15.0, "slot": 24.0}
#: Width of the vessels of all half angles, height of the bed above the slope, depth of a slot.
WIDTH, HEIGHT, DEPTH = 15.0, 10.0, 6.0
#: k of the fit of the exponent, and the exponents of the law.
K, EXPONENTS = 1.5, {"round": 2.5, "slot": 1.5}
#: Rolling dashpots differ between programs: without them they have one law.
MATERIAL = {
    **ROUGH_SPHERES,
    **{f"particle_{other}.rolling_damping": 0.0 for other in ("particle", "wall")},
}


class Run(NamedTuple):
    """What is varied: lengths in diameters, the half angle in degrees."""

    solver: str
    seed: int
    orifice: str
    outlet: float
    half_angle: float
    width: float
    law: str


def record_of(run: Run) -> dict[str, Any]:
    """Simulate a run."""
    opening = {"round": "orifice_diameter", "slot": "slot_width"}[run.orifice]
    options: dict[str, Any] = {opening: run.outlet * DIAMETER, "half_angle": run.half_angle}
    if run.orifice == "slot":
        options["depth"] = DEPTH * DIAMETER
    if run.width == FLAT_WIDTH[run.orifice]:
        options["fill_height"] = FLAT_HEIGHT[run.orifice] * DIAMETER
    else:
        slope = (run.width - run.outlet) / 2 / math.tan(math.radians(run.half_angle))
        options["fill_height"] = (slope + HEIGHT) * DIAMETER
    material = material_of_new() if run.law == NEW else MATERIAL
    width = run.width * DIAMETER
    test = Hopper(diameter=DIAMETER, orifice=run.orifice, width=width, **options)
    test = replace(test, time_step_fraction=safe_time_step_fraction(test, material))
    return simulate(DEM_PROGRAMS[run.solver](test, material), run.seed)


def runs_of(given: argparse.Namespace) -> list[Run]:
    """Return all runs, those of the first seed first."""
    found, law = [], given.law
    for seed, orifice, solver in product(range(1, given.seeds + 1), given.orifices, given.solvers):
        start = (solver, seed, orifice)
        found += [Run(*start, outlet, 90.0, FLAT_WIDTH[orifice], law) for outlet in OUTLETS]
        found += [Run(*start, OUTLET, angle, WIDTH, law) for angle in given.half_angles]
    # YADE has no flat floor with a round outlet.
    return [r for r in found if not (r.solver == "yade" and r.orifice == "round")]


def natural_flow(run: Run, responses: Mapping[str, float]) -> float:
    """Return the mass flow over rho_b sqrt(g) d^2.5, and over the depth of a slot in diameters."""
    scale = responses["bulk_density"] * math.sqrt(GRAVITY * DIAMETER**5)
    return responses["mass_flow"] / scale / (DEPTH if run.orifice == "slot" else 1.0)


def beverloo(known: Mapping[Run, dict[str, Any]]) -> Iterator[str]:
    """Yield the table of the laws."""
    widths = ", ".join(f"{outlet:g} d" for outlet in OUTLETS)
    yield f"| law | solver | outlet | flow, kg/s, at {widths} | runs | n with k = {K} | k | C |"
    yield "|---" * 8 + "|"
    for law, solver, orifice in product(LAWS, DEM_PROGRAMS, EXPONENTS):
        flat = (law, solver, orifice, FLAT_WIDTH[orifice])
        own = {
            run: record["responses"]
            for run, record in known.items()
            if (run.law, run.solver, run.orifice, run.width) == flat
        }
        if len({run.outlet for run in own}) < len(OUTLETS):
            continue
        outlets = np.array([run.outlet for run in own])
        flows = np.array([natural_flow(*item) for item in own.items()])
        fit, covariance = np.polyfit(np.log(outlets - K), np.log(flows), 1, cov="unscaled")
        rest = np.log(flows) - np.polyval(fit, np.log(outlets - K))
        error = math.sqrt(covariance[0, 0] * float(rest @ rest) / (len(own) - 2))
        exponent = EXPONENTS[orifice]
        slope, start = np.polyfit(outlets, flows ** (1 / exponent), 1)
        means = ", ".join(
            f"{np.mean([found['mass_flow'] for run, found in own.items() if run.outlet == w]):.3f}"
            for w in OUTLETS
        )
        cells = [law, solver, orifice, means, str(len(own)), f"{fit[0]:.2f} ± {error:.2f}"]
        cells += [f"{-start / slope:.2f}", f"{slope**exponent:.2f}"]
        yield f"| {' | '.join(cells)} |"


def half_angles(known: Mapping[Run, dict[str, Any]]) -> Iterator[str]:
    """Yield the table of half angles."""
    names = ("mass_flow", "discharge_time", "residual_mass", "bulk_density")
    yield "| law | solver | outlet | half angle, deg | runs | over flat | mass flow, kg/s | " + (
        "discharge time, s | residual mass, kg | bulk density, kg/m^3 |"
    )
    yield "|---" * 10 + "|"
    for law, solver, orifice in product(LAWS, DEM_PROGRAMS, EXPONENTS):
        flat = float("nan")
        for angle in reversed(HALF_ANGLES):
            own = [
                record["responses"]
                for run, record in known.items()
                if (run.law, run.solver, run.orifice) == (law, solver, orifice)
                and (run.width, run.half_angle) == (WIDTH, angle)
            ]
            if not own:
                continue
            flow = float(np.mean([one["mass_flow"] for one in own]))
            flat = flow if angle == HALF_ANGLES[-1] else flat
            cells = [law, solver, orifice, f"{angle:g}", str(len(own)), f"{flow / flat:.2f}"]
            cells += [mean_and(scatter, [one[name] for one in own]) for name in names]
            yield f"| {' | '.join(cells)} |"


def main() -> None:
    """Make the runs that are missing, and print the tables."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--kept", type=Path, required=True)
    parser.add_argument("--seeds", type=int, default=3)
    parser.add_argument("--solvers", nargs="+", default=["lammps"], choices=list(DEM_PROGRAMS))
    parser.add_argument("--orifices", nargs="+", default=list(EXPONENTS), choices=EXPONENTS)
    parser.add_argument("--half-angles", type=float, nargs="*", default=HALF_ANGLES)
    parser.add_argument("--law", default=OWN, choices=LAWS)
    parser.add_argument("--table", action="store_true", help="only print what is known")
    given = parser.parse_args()
    if not given.table:
        measure(runs_of(given), given.kept, record_of)
    known = read(given.kept, Run)
    good = {run: record for run, record in known.items() if "responses" in record}
    print("\n".join([*beverloo(good), "", *half_angles(good)]))
    for run, record in known.items():
        if "why" in record:
            print(f"{run}: {record['why']}")


if __name__ == "__main__":
    main()
