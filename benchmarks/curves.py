"""Measured curves with common errors: do the stated 95 % intervals hold the truth?

An analytic oedometer curve (stress over strain) and a discharge curve (mass over time) of two
parameters each, with scatter from seed to seed. The measured curve has an error that all points
share and one that is independent from point to point, 2 % each. Every calibration has other true
values and other errors. For comparison the same points with all errors called independent, as they
are when the points are so many scalar targets.

    python benchmarks/curves.py [--calibrations 100] [--processes 2]
"""

from __future__ import annotations

import argparse
import os
import statistics
import sys
from collections.abc import Callable, Mapping
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from functools import partial

os.environ["OMP_NUM_THREADS"] = "1"

import numpy as np
from numpy.typing import NDArray

import grainfit as gf

Array = NDArray[np.float64]

#: Standard uncertainties of the laboratory, over the values.
INDEPENDENT, COMMON = 0.02, 0.02
#: Scatter of a whole simulated curve, and of its points.
SCATTER, JITTER = 0.02, 0.01


def oedometer(parameters: Mapping[str, float], strains: Array) -> Array:
    """Stress of a bed that stiffens, Pa."""
    bend = 1 + 20 * parameters["stiffening"] * strains
    return np.asarray(parameters["modulus"] * strains * bend)


def discharge(parameters: Mapping[str, float], times: Array) -> Array:
    """Mass that has left a container whose flow slows down, kg."""
    flow, mass = parameters["flow"], parameters["mass"]
    return np.asarray(mass * (1 - np.exp(-flow * times / mass)))


@dataclass(frozen=True)
class Case:
    """A family of curves, its intervals, and measured and simulated coordinates."""

    curve: Callable[[Mapping[str, float], Array], Array]
    intervals: Mapping[str, tuple[float, float]]
    measured: Array
    simulated: Array


CASES = {
    "oedometer": Case(
        oedometer,
        {"modulus": (1e5, 4e5), "stiffening": (0.0, 1.0)},
        np.linspace(0.002, 0.04, 20),
        np.linspace(0.0, 0.05, 60),
    ),
    "discharge": Case(
        discharge,
        {"flow": (0.5, 2.0), "mass": (1.5, 4.0)},
        np.linspace(0.2, 5.0, 30),
        np.linspace(0.0, 6.0, 80),
    ),
}


def simulate(case: Case, parameters: Mapping[str, float], seed: int) -> dict[str, gf.Curve]:
    """Return the curve of one run."""
    random = np.random.default_rng([seed, 7])
    factors = (1 + SCATTER * random.normal()) * (
        1 + JITTER * random.normal(size=len(case.simulated))
    )
    values = case.curve(parameters, case.simulated) * factors
    return {"curve": gf.Curve(case.simulated.tolist(), values.tolist())}


def calibrate(name: str, as_curve: bool, number: int) -> dict[str, tuple[bool, float, str]]:
    """Calibrate one material; return, by parameter, whether its interval holds, and its width."""
    case = CASES[name]
    random = np.random.default_rng([2008, number])
    truth = {
        key: float(random.uniform(low + 0.2 * (high - low), high - 0.2 * (high - low)))
        for key, (low, high) in case.intervals.items()
    }
    errors = (1 + COMMON * random.normal()) * (
        1 + INDEPENDENT * random.normal(size=len(case.measured))
    )
    measured = case.curve(truth, case.measured) * errors
    shares = ("2 %", "2 %") if as_curve else (f"{100 * np.hypot(INDEPENDENT, COMMON):.4f} %", 0.0)
    target = gf.CurveTarget(
        "curve", case.measured.tolist(), measured.tolist(), shares[0], systematic=shares[1]
    )
    problem = gf.Problem(
        [gf.Parameter(key, *ends) for key, ends in case.intervals.items()], [], curves=[target]
    )
    solver = gf.solvers.PythonCallable(partial(simulate, case), name=name)
    result = gf.calibrate(problem, solver, seed=number)
    return {
        key: (
            found.low <= truth[key] <= found.high,
            (found.high - found.low) / 2 / truth[key],
            result.status,
        )
        for key, found in result.intervals.items()
    }


def report(name: str, as_curve: bool, results: list[dict[str, tuple[bool, float, str]]]) -> str:
    """Return a row of the table for each parameter."""
    words = "common and independent errors" if as_curve else "all called independent"
    rows = []
    for key in CASES[name].intervals:
        found = [result[key] for result in results if key in result]
        held = sum(inside for inside, _, _ in found)
        width = 100 * statistics.median(width for _, width, _ in found)
        calibrated = sum(status == "calibrated" for _, _, status in found)
        rows.append(
            f"| {name}, {key} | {words} | {held} of {len(results)} | {width:.1f} % | {calibrated} |"
        )
    return "\n".join(rows)


def main() -> None:
    """Calibrate, and print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--calibrations", type=int, default=100)
    parser.add_argument("--processes", type=int, default=2)
    options = parser.parse_args()
    print("| curve, parameter | errors | truth inside | median half-width | calibrated |")
    print("|---|---|---|---|---|")
    with ProcessPoolExecutor(options.processes) as pool:
        for as_curve in (True, False):
            for name in CASES:
                numbers = range(1, options.calibrations + 1)
                found = list(pool.map(partial(calibrate, name, as_curve), numbers))
                print(report(name, as_curve, found))
                sys.stdout.flush()


if __name__ == "__main__":
    main()
