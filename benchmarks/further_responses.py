"""Count the runs that a further response of the same run costs: angle, density, base radius.

Heaps of glass beads are simulated once over density and rolling friction, and kept in the file
``--kept``; calibrations run on an emulator of them (quadratic in the parameters) with the scatter
of the runs, correlated among the responses as theirs is.

    python benchmarks/further_responses.py --kept benchmarks/data/heap_responses.jsonl
        [--problems 20] [--heaps 48]

Prints, for each set of targets, the runs of every calibration, their median, the verdicts, and the
95 % interval of rolling friction.
"""

from __future__ import annotations

import argparse
import json
import statistics
import sys
import tempfile
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

import grainfit as gf
from grainfit.bulk_tests.registry import bulk_tests
from grainfit.evaluation import scalars
from grainfit.metamodels.designs import maximin_latin_hypercube
from grainfit.solvers.base import Workspace
from grainfit.solvers.registry import DEM_PROGRAMS
from grainfit.testing.materials import GLASS_BEADS, ROUGH_PLATE
from kept_runs import records_in

Array = NDArray[np.float64]
RESPONSES = ("angle_of_repose", "bulk_density", "base_radius")
#: Tolerances: absolute for the angle, shares of the value for the others.
TOLERANCES = {"angle_of_repose": "0.5 deg", "bulk_density": "1 %", "base_radius": "1 %"}
SETS = (
    RESPONSES[:1],
    RESPONSES[:2],
    (RESPONSES[0], RESPONSES[2]),
    (RESPONSES[1], RESPONSES[2]),
    RESPONSES,
)
PARAMETERS = [
    gf.Parameter("particle.density", 1407.0, 2793.0),
    gf.Parameter("particle_particle.rolling_friction", 0.449, 0.891),
]


def record(kept: Path, heaps: int) -> list[dict[str, object]]:
    """Simulate the heaps that are not kept yet."""
    found = records_in(kept)
    design = maximin_latin_hypercube(heaps, len(PARAMETERS), 1)
    with kept.open("a") as file:
        for seed in range(len(found) + 1, heaps + 1):
            values = _at(design[seed - 1])
            found.append({"parameters": values, "responses": heap(values, seed)})
            file.write(json.dumps(found[-1]) + "\n")
            file.flush()
            print(f"{seed} of {heaps} heaps", file=sys.stderr)
    return found


def heap(values: Mapping[str, float], seed: int) -> dict[str, float]:
    """Return the responses of one heap."""
    material = {**GLASS_BEADS, **values}
    program = DEM_PROGRAMS["lammps"](bulk_tests()["heap"](diameter=0.01, **ROUGH_PLATE), material)
    with tempfile.TemporaryDirectory() as folder:
        found = scalars(program.run({}, seed, Workspace(Path(folder))))
    return {name: found[name].value for name in RESPONSES}


@dataclass(frozen=True)
class Emulator:
    """Quadratic responses with correlated scatter, from recorded runs."""

    coefficients: Array
    root: Array

    @classmethod
    def of(cls, records: Sequence[Mapping[str, Mapping[str, float]]]) -> Emulator:
        """Fit the recorded runs."""
        points = np.array([[r["parameters"][p.name] for p in PARAMETERS] for r in records])
        values = np.array([[r["responses"][name] for name in RESPONSES] for r in records])
        terms = _terms(points)
        coefficients, *_ = np.linalg.lstsq(terms, values, rcond=None)
        rest = values - terms @ coefficients
        covariance = rest.T @ rest / (len(values) - terms.shape[1])
        return cls(coefficients, np.linalg.cholesky(covariance))

    def expected(self, parameters: Mapping[str, float]) -> Array:
        """Return the expected responses."""
        return _terms(np.array([[parameters[p.name] for p in PARAMETERS]]))[0] @ self.coefficients

    def __call__(self, parameters: Mapping[str, float], seed: int) -> dict[str, float]:
        """Return the responses of a run."""
        noise = self.root @ np.random.default_rng(seed).standard_normal(len(RESPONSES))
        return dict(zip(RESPONSES, (self.expected(parameters) + noise).tolist(), strict=True))


def _at(unit: Array) -> dict[str, float]:
    """Return parameters by their place in the intervals."""
    return {p.name: p.from_unit(u) for p, u in zip(PARAMETERS, unit.tolist(), strict=True)}


def _terms(points: Array) -> Array:
    lows, highs = (np.array([getattr(p, e) for p in PARAMETERS]) for e in ("minimum", "maximum"))
    x, y = (2 * (points - lows) / (highs - lows) - 1).T
    return np.column_stack([np.ones_like(x), x, y, x * x, x * y, y * y])


def runs_of(emulator: Emulator, names: Sequence[str], seed: int) -> tuple[int, str, float]:
    """Return runs, verdict and half-width of a calibration for responses of a random material.

    The half-width is half the 95 % interval of rolling friction, a share of the true value.
    """
    unit = np.random.default_rng(seed).uniform(0.2, 0.8, len(PARAMETERS))
    truth = _at(unit)
    values = dict(zip(RESPONSES, emulator.expected(truth).tolist(), strict=True))
    targets = [gf.Target(name, values[name], tolerance=TOLERANCES[name]) for name in names]
    with tempfile.TemporaryDirectory() as folder:
        work = Path(folder) / "work"
        result = gf.calibrate(gf.Problem(PARAMETERS, targets), emulator, seed=seed, workdir=work)
    rolling = PARAMETERS[1].name
    interval = result.intervals[rolling]
    return result.runs.total, result.status, (interval.high - interval.low) / 2 / truth[rolling]


def main() -> None:
    """Record heaps, and count the runs of calibrations."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--kept", type=Path, required=True)
    parser.add_argument("--heaps", type=int, default=48)
    parser.add_argument("--problems", type=int, default=20)
    options = parser.parse_args()
    emulator = Emulator.of(record(options.kept, options.heaps))
    deviations = np.sqrt((emulator.root**2).sum(axis=1))
    print("scatter:", dict(zip(RESPONSES, deviations.round(5).tolist(), strict=True)))
    for names in SETS:
        found = [runs_of(emulator, names, seed) for seed in range(1, options.problems + 1)]
        runs = [count for count, _, _ in found]
        verdicts = dict(Counter(status for _, status, _ in found))
        width = statistics.median(width for _, _, width in found)
        print(f"{', '.join(names)}: median {statistics.median(runs):g}, {runs}, {verdicts}")
        print(f"    rolling friction to ± {100 * width:.0f} % (median)")


if __name__ == "__main__":
    main()
