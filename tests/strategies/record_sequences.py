"""Calibrations with one test whose proposals are recorded in ``recorded_sequences.json``.

``python tests/strategies/record_sequences.py`` writes the file. A change of the search that is not
meant to change the proposals of one test must leave it as it is.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np

import grainfit as gf
from grainfit.errors import RunFailedError

RECORDED = Path(__file__).with_name("recorded_sequences.json")


def _simulate(parameters: dict[str, float], seed: int) -> dict[str, float]:
    x, y = parameters["x"], parameters["y"]
    noise = np.random.default_rng(seed).standard_normal(2)
    return {"a": 30 + 8 * x + 3 * y**2 + 0.3 * noise[0], "b": 50 - 9 * x * y + noise[1]}


def _material(parameters: dict[str, float], seed: int) -> dict[str, float]:
    modulus = np.log10(parameters["particle.youngs_modulus"])
    density, friction = parameters["particle.density"], parameters["friction"]
    if friction > 0.8:
        raise RunFailedError("the particles flew away")
    noise = np.random.default_rng(seed).standard_normal(2)
    return {
        "a": 0.6 * density - 4 * modulus + noise[0],
        "b": 20 + 15 * friction + modulus + 0.2 * noise[1],
    }


_TWO = gf.Problem(
    [gf.Parameter("x", 0.0, 1.0), gf.Parameter("y", 0.0, 2.0)],
    [gf.Target("a", 37.0, tolerance=0.6), gf.Target("b", 45.5, tolerance=1.5)],
)
_THREE = gf.Problem(
    [
        gf.Parameter("particle.density", 1000.0, 3000.0),
        gf.Parameter("particle.youngs_modulus", 1e6, 1e8, "log"),
        gf.Parameter("friction", 0.1, 0.9),
    ],
    [gf.Target("a", 1190.0, tolerance=3.0), gf.Target("b", 33.0, tolerance=0.4)],
    gf.RayleighTimeStep(0.005, {"particle.poissons_ratio": 0.22}),
)
CASES: dict[str, Any] = {
    "sequential": (_TWO, _simulate, gf.Sequential(), None),
    "sequential, with failures and a time step": (_THREE, _material, gf.Sequential(), None),
    "staged": (_TWO, _simulate, gf.Staged(design_runs=12), None),
}


def sequence(name: str) -> dict[str, Any]:
    """Calibrate, and return all proposals and the status."""
    problem, simulate, strategy, budget = CASES[name]
    result = gf.calibrate(problem, simulate, strategy=strategy, max_runs=budget, seed=3)
    runs = [
        [run.stage, run.seed, *(run.parameters[p.name] for p in problem.parameters)]
        for run in result.history
    ]
    answer = [result.parameters[p.name] for p in problem.parameters]
    return {
        "status": result.status,
        "answer": answer,
        "probability": result.probability_all_met,
        "runs": runs,
    }


if __name__ == "__main__":
    found = {name: sequence(name) for name in CASES}
    RECORDED.write_text(json.dumps(found, indent=1) + "\n", encoding="utf-8")
