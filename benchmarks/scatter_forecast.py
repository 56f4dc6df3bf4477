"""How calibrations end whose runs scatter by a multiple of the tolerance, and after how many.

One response is linear in one or two parameters, and scatters by a multiple of its tolerance.

    python benchmarks/scatter_forecast.py [--calibrations 10]
"""

from __future__ import annotations

import argparse
from collections.abc import Mapping
from statistics import median

import numpy as np

import grainfit
from grainfit.solvers import PythonCallable
from grainfit.strategies.budget import runs_with_scatter

RATIOS = (0.5, 1.0, 1.5, 2.0, 2.5, 3.0, 4.0)


def calibrate(ratio: float, seed: int, dimension: int) -> grainfit.Result:
    """Calibrate a problem whose response scatters by a multiple of its tolerance."""
    random = np.random.default_rng([seed, dimension])
    slopes = random.uniform(10, 30, dimension)
    centre = random.uniform(0.3, 0.7, dimension)

    def run(parameters: Mapping[str, float], seed: int) -> dict[str, float]:
        point = np.array(list(parameters.values()))
        place = int(1e9 * point.sum()) % 2**31
        noise = ratio * np.random.default_rng([seed, place]).normal()
        return {"angle": float(40 + slopes @ (point - centre) + noise)}

    names = [f"friction_{number}" for number in range(dimension)]
    problem = grainfit.Problem(
        [grainfit.Parameter(name, 0.0, 1.0) for name in names],
        [grainfit.Target("angle", 40.0, tolerance=1.0, unit="deg")],
    )
    return grainfit.calibrate(problem, PythonCallable(run), seed=seed + 1)


def main() -> None:
    """Print a row of Markdown for each number of parameters and ratio."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--calibrations", type=int, default=10)
    count = parser.parse_args().calibrations
    print("| parameters | scatter / tolerance | forecast | runs to calibrated | not calibrated |")
    print("|---|---|---|---|---|")
    for dimension in (1, 2):
        for ratio in RATIOS:
            results = [calibrate(ratio, seed, dimension) for seed in range(count)]
            runs = [one.runs.total for one in results if one.status == "calibrated"]
            forecast = runs_with_scatter(ratio, dimension)
            middle = f"{median(runs):g}" if runs else "-"
            lost = f"{count - len(runs)} of {count}"
            print(f"| {dimension} | {ratio:g} | {forecast} | {middle} | {lost} |", flush=True)


if __name__ == "__main__":
    main()
