"""Calibrations by twins of a model whose law of the size is known: intervals and verdicts.

Each calibration is that of `strategy.twins`, search, series of sizes and one run at full size
included, of a packing whose bulk density follows a law of the size that is drawn: layers at walls
with a little compression by depth, or depth alone, and a scatter that falls with the number of
particles. Finished calibrations
are kept in the file ``--kept`` and not repeated.

    python benchmarks/real_size.py --kept benchmarks/data/real_size.jsonl [--calibrations 60]
        [--table]

Prints how many 95 % intervals of the prediction hold the response of the real apparatus, and how
many answers that are called calibrated meet their target in it.
"""

from __future__ import annotations

import argparse
import math
import os
import tempfile
from collections import Counter
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from functools import partial
from itertools import product
from pathlib import Path
from typing import Any, NamedTuple, Self

os.environ["OMP_NUM_THREADS"] = "1"

import numpy as np

from grainfit.bulk_tests.packing import Packing
from grainfit.bulk_tests.size import resized
from grainfit.calibration.calibrate import calibrate
from grainfit.calibration_file.real_size import RealSizeCalibration, RealSizeOptions
from grainfit.evaluation import Response
from grainfit.problem import Parameter, Problem, Target
from grainfit.solvers.base import Solver, Workspace
from kept_runs import measure, read

#: Particles of twin and real apparatus.
TWIN, REAL = 500, 20_000
DENSITY, TOLERANCE = 900.0, 0.02
#: Laws that are drawn.
KINDS = ("walls", "depth")


class Run(NamedTuple):
    """Kind of the law, and number of a calibration: it decides the law and all seeds."""

    kind: str
    number: int


@dataclass(frozen=True)
class Law:
    """Bulk density over that of the particles, by the number of particles.

    Parameters
    ----------
    packed : float
        Solid fraction of the twin.
    walls, depth : float
        Relative changes by layers at walls and by depth: 1 - walls / L + depth ln L.
    scatter : float
        Relative standard deviation of a run of the twin.
    """

    packed: float
    walls: float
    depth: float
    scatter: float

    @classmethod
    def drawn(cls, run: Run) -> Self:
        """Draw a law: up to twice the changes of recorded trials, in either direction.

        Walls are the form of the trend, with a little of the other one; depth is the other alone.
        """
        random = np.random.default_rng(run.number)
        packed, walls = random.uniform(0.54, 0.6), random.uniform(-0.02, 0.15)
        depth, scatter = random.normal(0.0, 0.01), random.uniform(0.003, 0.01)
        if run.kind == "depth":
            return cls(packed, 0.0, walls / 3, scatter)
        return cls(packed, walls, depth, scatter)

    def fraction(self, particles: float) -> float:
        """Return the expected solid fraction."""
        scale = math.cbrt(particles / TWIN)
        return self.packed * (1 + self.walls * (1 - 1 / scale) + self.depth * math.log(scale))


@dataclass(frozen=True)
class Known(Solver):
    """Solver that follows a law of the size.

    Parameters
    ----------
    test : Packing
        The test.
    law : Law
        The law.
    """

    test: Packing
    law: Law
    name = "known"
    uses_folder = False

    @property
    def response_names(self) -> tuple[str, ...]:
        """The bulk density."""
        return ("bulk_density",)

    @property
    def bulk_test(self) -> Packing:
        """The test."""
        return self.test

    def of_test(self, test: Any) -> Self:
        """Return the solver with another test."""
        return replace(self, test=test)

    def model(self) -> Mapping[str, Any]:
        """Return law and size."""
        return {"law": vars(self.law), "particles": self.test.number_of_particles}

    def run(
        self, parameters: Mapping[str, float], seed: int, workspace: Workspace
    ) -> Mapping[str, Response]:
        """Return the bulk density with the scatter of a run."""
        del workspace
        count = self.test.number_of_particles
        noise = np.random.default_rng([seed, count]).standard_normal()
        scatter = self.law.scatter * math.sqrt(TWIN / count)
        expected = parameters["particle.density"] * self.law.fraction(count)
        return {"bulk_density": Response(expected * (1 + scatter * noise))}


def calibration(run: Run, folder: Path, *, full_size: bool) -> Any:
    """Return the result of a calibration."""
    test = resized(Packing(diameter="10 mm"), REAL / Packing(diameter="10 mm").number_of_particles)
    solver = Known(test, Law.drawn(run))
    twin = solver.of_test(resized(test, TWIN / test.number_of_particles))
    target = Target("bulk_density", DENSITY, tolerance=TOLERANCE * DENSITY, unit="kg/m^3")
    problem = Problem([Parameter("particle.density", 1000.0, 2600.0)], [target])
    search = partial(calibrate, problem, {"packing": twin}, workdir=folder, seed=run.number)
    options = RealSizeOptions(0.95, full_size=full_size)
    tests = {"packing": solver}, {"packing": twin}
    return RealSizeCalibration(
        problem, *tests, folder, lambda twins: search(twins=twins), options
    ).run()


def record_of(run: Run) -> dict[str, Any]:
    """Calibrate, and compare with the truth at the real size."""
    law = Law.drawn(run)
    found: dict[str, Any] = {}
    with tempfile.TemporaryDirectory() as folder:
        for name, full_size in (("predicted", False), ("verified", True)):
            result = calibration(run, Path(folder), full_size=full_size)
            response = result.responses["bulk_density"]
            particles = result.parameters["particle.density"]
            found[name] = {
                "status": result.status,
                "off": response.predicted / (particles * law.fraction(REAL)) - 1,
                "error": response.standard_error / response.predicted,
                "deviation": particles * law.fraction(REAL) / DENSITY - 1,
            }
    return found


def table(records: Mapping[Run, dict[str, Any]]) -> Iterator[str]:
    """Yield what the intervals hold, and which verdicts are true."""
    for kind, name in product(KINDS, ("predicted", "verified")):
        own = [record[name] for run, record in records.items() if run.kind == kind]
        if not own:
            continue
        held = sum(abs(one["off"]) <= 1.96 * one["error"] for one in own)
        half = 196 * np.median([one["error"] for one in own])
        states = Counter(one["status"] for one in own)
        words = ", ".join(f"{count} {state}" for state, count in states.most_common())
        count = f"{held} of {len(own)} intervals hold the truth"
        yield f"{kind}, {name}: {count}, ± {half:.1f} %; {words}"
        calibrated = [one for one in own if one["status"] == "calibrated"]
        met = sum(abs(one["deviation"]) <= TOLERANCE for one in calibrated)
        if calibrated:
            yield f"  {met} of {len(calibrated)} calibrated answers meet their target"


def main() -> None:
    """Calibrate what is not kept yet, and print the outcome."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--kept", type=Path, required=True)
    parser.add_argument("--calibrations", type=int, default=60)
    parser.add_argument("--table", action="store_true", help="print what is kept, run nothing")
    given = parser.parse_args()
    if not given.table:
        numbers = range(1, given.calibrations + 1)
        runs = [Run(kind, number) for kind, number in product(KINDS, numbers)]
        measure(runs, given.kept, record_of)
    for line in table(read(given.kept, Run)):
        print(line)


if __name__ == "__main__":
    main()
