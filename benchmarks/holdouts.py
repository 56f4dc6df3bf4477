"""Predictions of hold-outs against the truth: how often a measurement is in its interval.

Every calibration is that of `grainfit.calibrate` with its defaults, of an emulated material whose
parameters are drawn from their intervals. Fitted and held-out tests are measured with errors of
their stated uncertainty. Of a third kind, the material of the hold-out is another one, and the
prediction has to fail. Finished calibrations are kept in the file ``--kept`` and not repeated.

    python benchmarks/holdouts.py --kept holdouts.jsonl [--calibrations 60]
"""

from __future__ import annotations

import argparse
import math
import os
import zlib
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

os.environ["OMP_NUM_THREADS"] = "1"

import numpy as np
from scipy.stats import beta

import grainfit as gf
from grainfit.result import HoldoutResponse
from kept_runs import measure, read

#: Scatter of a response from seed to seed, and standard uncertainty of a measured value, °.
SCATTER, UNCERTAINTY = 0.6, 0.4
#: Change of the parameters of another material, over their intervals.
OTHER = 0.35
NAMES = ("sliding", "rolling", "restitution")
RESPONSES = ("heap", "drum", "funnel")
#: Kinds, with the number of free parameters: all determined by the two fitted tests, one left
#: open, and a hold-out of another material.
KINDS: Mapping[str, int] = {"determined": 2, "left open": 3, "another material": 2}


class Calibration(NamedTuple):
    """One calibration: its kind, and the seed of its material and its measurements."""

    kind: str
    seed: int


def expected(values: Mapping[str, float]) -> dict[str, float]:
    """Return the mean responses, °, at parameters between 0 and 1; others are 0.5."""
    s, r, e = (values.get(name, 0.5) for name in NAMES)
    return {
        "heap": 18 + 10 * s + 9 * r * (1 - 0.3 * r) - 2 * e,
        "drum": 22 + 16 * math.sqrt(s + 0.1) + 4 * r - 3 * e,
        "funnel": 15 + 8 * s * r + 11 * r + 5 * s**2 - 6 * e,
    }


def one_run(parameters: dict[str, float], seed: int) -> dict[str, float]:
    """Return the responses of one run."""
    return {
        name: value + SCATTER * np.random.default_rng([seed, place]).standard_normal()
        for place, (name, value) in enumerate(expected(parameters).items())
    }


def calibrated(one: Calibration) -> dict[str, Any]:
    """Return status, verdict and prediction of one calibration."""
    random = np.random.default_rng([zlib.crc32(one.kind.encode()), one.seed])
    names = NAMES[: KINDS[one.kind]]
    material = dict(zip(names, random.uniform(0.05, 0.95, len(names)), strict=True))
    held_out = material
    if one.kind == "another material":
        held_out = {
            name: value + OTHER * (1 if value < 0.5 else -1) for name, value in material.items()
        }
    truth = expected(material) | {"funnel": expected(held_out)["funnel"]}
    targets = {
        name: gf.Target(
            name, truth[name] + UNCERTAINTY * random.standard_normal(), uncertainty=UNCERTAINTY
        )
        for name in RESPONSES
    }
    problem = gf.Problem(
        [gf.Parameter(name, 0.0, 1.0) for name in names], [targets["heap"], targets["drum"]]
    )
    held = gf.Holdout("held", one_run, [targets["funnel"]])
    result = gf.calibrate(problem, one_run, seed=one.seed + 1, holdouts=[held])
    record: dict[str, Any] = {"status": result.status, "runs": result.runs.total}
    [found] = result.holdouts
    if found.state != "simulated":
        return record | {"verdict": found.state}
    prediction: HoldoutResponse = found.responses["funnel"]
    low, high = prediction.interval
    before = prediction.prior
    off = truth["funnel"] - prediction.predicted
    return record | {
        "verdict": prediction.verdict,
        "inside": low <= targets["funnel"].value <= high,
        "truth off": off / prediction.standard_error,
        "width": (high - low) / (before[1] - before[0]),
    }


def table(records: Mapping[Calibration, Mapping[str, Any]]) -> str:
    """Return the counts of each kind as a table."""
    lines = [
        "| kind | calibrations | calibrated | predicts | does not predict | does not tell "
        "| measured inside its 95 % interval | truth inside | width over that before |",
        "|---|---:|---:|---:|---:|---:|---:|---:|---:|",
    ]
    for kind in KINDS:
        every = [record for one, record in records.items() if one.kind == kind]
        told = [record for record in every if "inside" in record]
        if not told:
            continue
        verdicts = [
            str(sum(record["verdict"] == verdict for record in told))
            for verdict in ("predicts", "does not predict", "does not tell")
        ]
        truth = [abs(record["truth off"]) <= 1.96 for record in told]
        cells = [
            *(kind, str(len(every)), str(len(told)), *verdicts),
            _share([record["inside"] for record in told]),
            "-" if kind == "another material" else _share(truth),
            f"{np.median([record['width'] for record in told]):.2f}",
        ]
        lines.append(f"| {' | '.join(cells)} |")
    return "\n".join(lines)


def _share(hits: Sequence[bool]) -> str:
    """Return a share with its 95 % interval (Clopper and Pearson)."""
    count, of = sum(hits), len(hits)
    low = beta.ppf(0.025, count, of - count + 1) if count else 0.0
    high = beta.ppf(0.975, count + 1, of - count) if count < of else 1.0
    return f"{100 * count / of:.0f} % ({100 * low:.0f} to {100 * high:.0f})"


def main() -> None:
    """Make the calibrations that are missing, and print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--kept", type=Path, required=True)
    parser.add_argument("--calibrations", type=int, default=60)
    given = parser.parse_args()
    runs = [Calibration(kind, seed) for seed in range(given.calibrations) for kind in KINDS]
    measure(runs, given.kept, calibrated)
    print(table(read(given.kept, Calibration)))


if __name__ == "__main__":
    main()
