"""Fourteen free parameters on the DEM: is a material found, and is it said which are determined?

All contact parameters of particle and wall are free in three tests (heap, draw-down, compression,
as in `examples/three_tests`). A random material is "measured", the mean of six seeds with the error
of a laboratory, and calibrated with a budget of 150 runs. The 95 % intervals are compared with the
truth. Finished calibrations are kept in the file ``--kept``, runs of unfinished ones in the folder
beside it, so that the command can be stopped and started again.

    python benchmarks/fourteen_parameters.py --kept fourteen.jsonl [--materials 5] [--workers 2]
"""

from __future__ import annotations

import argparse
import json
import os
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path

os.environ["OMP_NUM_THREADS"] = "1"

import numpy as np

import grainfit
from grainfit.bulk_tests.base import BulkTest
from grainfit.bulk_tests.registry import bulk_tests
from grainfit.bulk_tests.time_steps import usual_time_step_fraction
from grainfit.formatting import short_names
from grainfit.problem import Parameter, Problem
from grainfit.solvers.dem.lammps.program import Lammps
from grainfit.testing.materials import ROUGH_PLATE
from kept_runs import records_in
from random_materials import DIAMETER, Record, measured_values, target_of

RUNS, SEEDS = 150, 6
#: True values lie in this middle part of every interval.
MARGIN = 0.15
PARAMETERS = (
    Parameter("particle.youngs_modulus", 5e6, 1e7, scale="log"),
    Parameter("particle.poissons_ratio", 0.15, 0.35),
    Parameter("particle.density", 2400.0, 2800.0),
    Parameter("wall.youngs_modulus", 1e9, 1e11, scale="log"),
    Parameter("wall.poissons_ratio", 0.2, 0.4),
    Parameter("wall.density", 2000.0, 8000.0),
    Parameter("particle_particle.sliding_friction", 0.2, 0.8),
    Parameter("particle_particle.rolling_friction", 0.05, 0.4),
    Parameter("particle_particle.restitution", 0.3, 0.7),
    Parameter("particle_particle.rolling_damping", 0.0, 0.3),
    Parameter("particle_wall.sliding_friction", 0.2, 0.5),
    Parameter("particle_wall.rolling_friction", 0.0, 0.2),
    Parameter("particle_wall.restitution", 0.3, 0.7),
    Parameter("particle_wall.rolling_damping", 0.0, 0.3),
)
LABORATORY: Mapping[str, float | str] = {
    "bulk_density": "1 %",
    "angle_of_repose": 0.8,
    "mass_flow": "4 %",
    "discharged_share": 0.01,
    "loading_modulus": "8 %",
    "unloading_modulus": "8 %",
    "lateral_stress_ratio": 0.02,
}


def tests() -> dict[str, BulkTest]:
    """Return the three tests by name, with the time step that a calibration file gives them."""
    kinds = bulk_tests()
    made = {
        "heap": kinds["heap"](diameter=DIAMETER, **ROUGH_PLATE),
        "draw_down": kinds["draw_down"](diameter=DIAMETER, depth=0.05, floor_rolling_friction=0.3),
        "compression": kinds["compression"](diameter=DIAMETER, stress=5000.0),
    }
    intervals = {p.name: (p.minimum, p.maximum) for p in PARAMETERS}
    return {
        name: replace(test, time_step_fraction=usual_time_step_fraction(test, intervals))
        for name, test in made.items()
    }


def calibrate(number: int, folder: Path, workers: int) -> Record:
    """Measure a random material, calibrate it, and return what is to be compared."""
    random = np.random.default_rng([14, number])
    places = random.uniform(MARGIN, 1 - MARGIN, len(PARAMETERS))
    truth = {p.name: p.from_unit(float(x)) for p, x in zip(PARAMETERS, places, strict=True)}
    real = {name: Lammps(test, truth) for name, test in tests().items()}
    values = measured_values(real, SEEDS, folder / "laboratory")
    targets = [
        target_of(LABORATORY, key, found, number)
        for key, found in values.items()
        if key.rpartition(".")[2] in LABORATORY
    ]
    result = grainfit.calibrate(
        Problem(PARAMETERS, targets),
        {name: Lammps(test, {}) for name, test in tests().items()},
        seed=number,
        max_runs=RUNS,
        workers=workers,
        workdir=folder / "calibration",
        keep="results",
    )
    return {
        "material": number,
        "truth": truth,
        "status": result.status,
        "probability": result.probability_all_met,
        "runs": result.runs.total,
        "intervals": {n: [i.low, i.high, i.determination] for n, i in result.intervals.items()},
        "notices": list(result.notices),
        "wall_seconds": result.wall_seconds,
    }


def table(records: Sequence[Record]) -> str:
    """Return the findings as a table in Markdown."""
    lines = ["| parameter | truth in the 95 % interval | called |", "|---|---|---|"]
    held = 0
    short = short_names([parameter.name for parameter in PARAMETERS])
    for parameter, shown in zip(PARAMETERS, short, strict=True):
        found = [record["intervals"][parameter.name] for record in records]
        inside = sum(
            low <= record["truth"][parameter.name] <= high
            for record, (low, high, _) in zip(records, found, strict=True)
        )
        held += inside
        words = ", ".join(word for _, _, word in found)
        lines.append(f"| {shown} | {inside} | {words} |")
    calibrated = sum(record["status"] == "calibrated" for record in records)
    runs = ", ".join(str(record["runs"]) for record in records)
    lines.append(
        f"\n{calibrated} of {len(records)} calibrated, after {runs} runs; "
        f"{held} of {len(records) * len(PARAMETERS)} intervals hold the truth."
    )
    return "\n".join(lines)


def main() -> None:
    """Calibrate what is not kept yet, and print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--kept", type=Path, required=True, help="file of finished calibrations")
    parser.add_argument("--materials", type=int, default=5)
    parser.add_argument("--workers", type=int, default=2, help="runs at a time")
    given = parser.parse_args()
    known = {record["material"] for record in records_in(given.kept)}
    for number in range(1, given.materials + 1):
        if number in known:
            continue
        folder = given.kept.with_suffix("") / str(number)
        folder.mkdir(parents=True, exist_ok=True)
        record = calibrate(number, folder, given.workers)
        with given.kept.open("a") as file:
            file.write(json.dumps(record) + "\n")
    if records := records_in(given.kept):
        print(table(records))


if __name__ == "__main__":
    main()
