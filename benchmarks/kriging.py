"""Kriging of few noisy DEM runs compared with other programs: accuracy, coverage, and time.

Fits 12 random subsets of 10, 16 and 26 runs of the heap test (`data/dem_study/data.csv`) and
predicts 20 other runs. Per column: mean RMSE; share of the runs inside their 95 % intervals; and
seconds per fit (mean). STK, the toolbox of Rackl et al. (2016), takes part when Octave and its
package stk are installed, OpenTURNS when it can be imported. A second table has other problems,
to check that the method was not fitted to this one.

    python benchmarks/kriging.py [--json PATH]
"""

from __future__ import annotations

import argparse
import csv
import json
import math
import os
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import gpmp
import numpy as np
from gpmp.kernel import (
    autoselect_parameters,
    make_selection_criterion_with_gradient,
    maternp_covariance,
)
from numpy.typing import NDArray
from scipy.stats import qmc
from threadpoolctl import threadpool_limits

from grainfit.metamodels.kriging import Kriging

Array = NDArray[np.float64]
HERE = Path(__file__).parent
DATA = HERE / "data" / "dem_study"
SIZES = (10, 16, 26)
RESPONSES = {"density": "bulk_density", "angle": "aor"}
# Bounds of the study's free parameters: density, rolling friction; and sliding friction, modulus.
BOUNDS = {
    "density": (714.0, 3486.0),
    "mu_r": (0.2278, 1.1122),
    "mu_s": (0.06, 0.30),
    "E": (2e5, 1e7),
}


@dataclass(frozen=True)
class Case:
    """A fit and the runs to predict; ``expected`` is known for synthetic problems only."""

    column: str
    points: Array
    values: Array
    targets: Array
    runs: Array
    expected: Array | None = None


@dataclass(frozen=True)
class Answer:
    """Mean and variance of a new run at the targets, and the time of the fit."""

    mean: Array
    variance: Array
    seconds: float
    variance_of_mean: Array | None = None


# The problems -------------------------------------------------------------------------------


def read_runs(file: str, split: str) -> tuple[Array, dict[str, Array]]:
    """Points in the unit cube, and the responses by column."""
    with (DATA / file).open() as stream:
        rows = [row for row in csv.DictReader(stream) if row["split"] == split]
    columns = []
    for name in (name for name in BOUNDS if name in rows[0]):
        values = np.array([float(row[name]) for row in rows])
        low, high = BOUNDS[name]
        if name == "E":
            values, low, high = np.log(values), math.log(low), math.log(high)
        columns.append((values - low) / (high - low))
    responses = {
        name: np.array([float(row[column]) for row in rows]) for name, column in RESPONSES.items()
    }
    return np.column_stack(columns), responses


def cases_from(file: str, subsets: dict[int, list[list[int]]]) -> Iterator[Case]:
    points, responses = read_runs(file, "train")
    targets, runs = read_runs(file, "test")
    for name in RESPONSES:
        for size, rows in subsets.items():
            for chosen in rows:
                yield Case(
                    f"{name} {size}",
                    points[chosen],
                    responses[name][chosen],
                    targets,
                    runs[name],
                )


def heap_cases() -> list[Case]:
    """Return the cases of the main table: two free parameters."""
    subsets = {
        size: [
            [int(row) - 1 for row in line.split(",")]
            for line in (DATA / "subsets" / f"train_subsets_{size}.csv").read_text().splitlines()
        ]
        for size in SIZES
    }
    return list(cases_from("data.csv", subsets))


def four_parameter_cases() -> list[Case]:
    random = np.random.default_rng(5)
    subsets = {
        size: [[int(i) for i in random.choice(60, size, replace=False)] for _ in range(12)]
        for size in (20, 32, 52)
    }
    return list(cases_from("data4.csv", subsets))


def _curved(u: Array) -> Array:
    return np.asarray(np.sin(3 * u[:, 0]) * (1 + u[:, 1]) + 0.5 * u[:, 1])


def _saturating(u: Array) -> Array:
    return np.asarray(np.tanh(4 * (u[:, 0] - 0.3)) * (1 + u[:, 1]) + 0.3 * u[:, 2])


def _friedman(u: Array) -> Array:
    first = 2 * np.sin(np.pi * u[:, 0] * u[:, 1]) + 4 * (u[:, 2] - 0.5) ** 2
    return np.asarray(first + 2 * u[:, 3] + u[:, 4])


def _linear(u: Array) -> Array:
    return np.asarray(u @ [2.0, 1.0, 0.5, 0.0, 0.0, 0.0])


SYNTHETIC = {"curved": (2, _curved), "saturating": (3, _saturating)} | {
    "friedman": (5, _friedman),
    "linear": (6, _linear),
}


def synthetic_cases(noise: float) -> list[Case]:
    cases = []
    for name, (d, function) in SYNTHETIC.items():
        for per_parameter in (5, 13):
            n = per_parameter * d
            for seed in range(12):
                random = np.random.default_rng([seed, n])
                points = qmc.LatinHypercube(d, rng=seed).random(n)
                values = function(points) + random.normal(0, noise, n)
                targets = random.random((200, d))
                expected = function(targets)
                runs = expected + random.normal(0, noise, 200)
                cases.append(Case(f"{name} {n}", points, values, targets, runs, expected))
    return cases


# The methods --------------------------------------------------------------------------------


def grainfit_answer(case: Case) -> Answer:
    start = time.perf_counter()
    metamodel = Kriging.fit(case.points, case.values)
    seconds = time.perf_counter() - start
    predicted = metamodel.predict(case.targets)
    return Answer(
        predicted.mean, predicted.variance_of_new_run, seconds, predicted.variance_of_mean
    )


def _gpmp_answer(case: Case, weak_priors: bool) -> Answer:
    """Fit standardised values; parameters: log variance, -log ranges, log noise variance."""
    centre, scale = case.values.mean(), case.values.std(ddof=1)
    values = (case.values - centre) / scale
    d = case.points.shape[1]

    def covariance(x: Any, y: Any, parameters: Any, pairwise: bool = False) -> Any:
        own = maternp_covariance(x, y, 2, parameters[:-1], pairwise)
        return own if pairwise or y is not x else own + np.exp(parameters[-1]) * np.eye(len(x))

    def trend(x: Any, _: Any) -> Any:
        return np.column_stack([np.ones(len(x)), x])

    def criterion(model: Any, parameters: Any, x: Any, z: Any) -> Any:
        value = model.negative_log_restricted_likelihood(parameters, x, z)
        if weak_priors:
            ranges = -parameters[1:-1] - math.log(0.7)
            noise = parameters[-1] - parameters[0] - math.log(0.1)
            value += 0.5 * float(ranges @ ranges) + 0.5 * (noise / 2.0) ** 2
        return value

    start = time.perf_counter()
    model = gpmp.Model(trend, covariance)
    _, evaluate, _, gradient = make_selection_criterion_with_gradient(
        model, criterion, case.points, values
    )
    first = np.concatenate([[0.0], np.full(d, -math.log(0.7)), [math.log(0.1)]])
    model.covparam, _ = autoselect_parameters(first, evaluate, gradient)
    seconds = time.perf_counter() - start
    mean, variance = model.predict(case.points, values, case.targets)
    variance = variance + math.exp(model.covparam[-1])
    return Answer(centre + scale * mean, scale**2 * variance, seconds)


def gpmp_likelihood(case: Case) -> Answer:
    return _gpmp_answer(case, weak_priors=False)


def gpmp_weak_priors(case: Case) -> Answer:
    return _gpmp_answer(case, weak_priors=True)


def openturns_answer(case: Case) -> Answer:
    """Fit by maximum likelihood with an estimated nugget, in OpenTURNS 1.24 or later."""
    import openturns as ot  # type: ignore[import-not-found,unused-ignore]

    d = case.points.shape[1]
    centre, scale = case.values.mean(), case.values.std(ddof=1)
    start = time.perf_counter()
    kernel = ot.MaternModel([0.5] * d, [1.0], 2.5)
    kernel.activateNuggetFactor(True)
    fitter = ot.GaussianProcessFitter(
        ot.Sample(case.points),
        ot.Sample(((case.values - centre) / scale)[:, None]),
        kernel,
        ot.LinearBasisFactory(d).build(),
    )
    fitter.setOptimizationAlgorithm(ot.TNC())
    fitter.run()
    fitted = fitter.getResult()
    regression = ot.GaussianProcessRegression(fitted)
    regression.run()
    seconds = time.perf_counter() - start
    result = regression.getResult()
    targets = ot.Sample(case.targets)
    mean = np.array(result.getMetaModel()(targets)).ravel()
    variance = ot.GaussianProcessConditionalCovariance(result).getConditionalMarginalVariance(
        targets
    )
    estimated = fitted.getCovarianceModel()
    noise = estimated.getNuggetFactor() * estimated.getAmplitude()[0] ** 2
    total = np.array(variance).ravel() + noise
    return Answer(centre + scale * mean, scale**2 * total, seconds)


def octave_with_stk() -> str | None:
    """Return the Octave program, if it has the package stk."""
    octave = shutil.which("octave-cli") or shutil.which("octave")
    if not octave:
        return None
    probe = subprocess.run(
        [octave, "--no-gui", "--eval", "pkg load stk; printf ('%s', stk_version ())"],
        capture_output=True,
        text=True,
        check=False,
    )
    return octave if probe.returncode == 0 and probe.stdout.startswith("2") else None


def stk_answers(cases: Sequence[Case]) -> list[Answer]:
    """Answer all cases in one Octave process."""
    octave = octave_with_stk()
    if octave is None:
        raise ImportError("Octave with its package stk")
    with tempfile.TemporaryDirectory() as folder:
        for number, case in enumerate(cases, 1):
            table = np.column_stack([case.points, case.values])
            np.savetxt(Path(folder, f"case_{number}.csv"), table, "%.17g", ",")
            np.savetxt(Path(folder, f"targets_{number}.csv"), case.targets, "%.17g", ",")
        script = (
            f"FOLDER = '{folder}'; COVARIANCE = 'stk_materncov_aniso'; "
            f"source ('{HERE / 'kriging_stk.m'}');"
        )
        subprocess.run([octave, "--no-gui", "--eval", script], capture_output=True, check=False)
        return [
            Answer(table[:, 0], table[:, 1], float(table[0, 2]))
            for table in (
                np.loadtxt(Path(folder, f"prediction_{number}.csv"), delimiter=",")
                for number in range(1, len(cases) + 1)
            )
        ]


def one_by_one(answer: Callable[[Case], Answer]) -> Callable[[Sequence[Case]], list[Answer]]:
    return lambda cases: [answer(case) for case in cases]


METHODS: dict[str, Callable[[Sequence[Case]], list[Answer]]] = {
    "grainfit": one_by_one(grainfit_answer),
    "gpmp, REML + weak priors": one_by_one(gpmp_weak_priors),
    "gpmp, REML alone": one_by_one(gpmp_likelihood),
    "STK": stk_answers,
    "OpenTURNS, maximum likelihood": one_by_one(openturns_answer),
}


# Measuring ----------------------------------------------------------------------------------

Row = dict[str, dict[str, float]]


def score(cases: Sequence[Case], answers: Sequence[Answer]) -> Row:
    """Return per column: mean RMSE, coverage of new runs and of the expected response, seconds."""
    pairs: dict[str, list[tuple[Case, Answer]]] = {}
    for case, answer in zip(cases, answers, strict=True):
        pairs.setdefault(case.column, []).append((case, answer))
    return {column: _score_column(found) for column, found in pairs.items()}


def _score_column(found: list[tuple[Case, Answer]]) -> dict[str, float]:
    rmse, inside, of_mean = [], [], []
    for case, answer in found:
        off = np.abs(answer.mean - case.runs)
        rmse.append(math.sqrt(np.mean(off**2)))
        inside.append(np.mean(off <= 1.96 * np.sqrt(answer.variance)))
        if case.expected is not None and answer.variance_of_mean is not None:
            off = np.abs(answer.mean - case.expected)
            of_mean.append(np.mean(off <= 1.96 * np.sqrt(answer.variance_of_mean)))
    scores = {
        "rmse": float(np.mean(rmse)),
        "coverage": float(np.mean(inside)),
        "seconds_per_fit": float(np.mean([answer.seconds for _, answer in found])),
    }
    return scores | ({"coverage_of_mean": float(np.mean(of_mean))} if of_mean else {})


def judge(rows: dict[str, Row]) -> dict[str, bool]:
    """Return whether the goals are met; those against STK only if it took part."""
    ours, stk = rows["grainfit"], rows.get("STK")
    goals = {
        "coverage 0.88 to 0.99 in every column": all(
            0.88 <= round(column["coverage"], 2) <= 0.99 for column in ours.values()
        )
    }
    if stk:
        goals["RMSE at most 5 % above STK in every column"] = all(
            ours[column]["rmse"] <= 1.05 * stk[column]["rmse"] for column in ours
        )
        goals["at least 10 times faster than STK in every column"] = all(
            stk[column]["seconds_per_fit"] >= 10 * ours[column]["seconds_per_fit"]
            for column in ours
        )
    return goals


def print_table(rows: dict[str, Row]) -> None:
    columns = list(next(iter(rows.values())))
    print("| | " + " | ".join(columns) + " | s/fit |")
    print("|---" * (len(columns) + 2) + "|")
    for name, row in rows.items():
        cells = [f"{row[c]['rmse']:.3g}, {row[c]['coverage']:.2f}" for c in columns]
        seconds = sorted(row[c]["seconds_per_fit"] for c in columns)
        print(f"| {name} | {' | '.join(cells)} | {seconds[0]:.3f}-{seconds[-1]:.3f} |")


def measure() -> dict[str, Any]:
    """Run all methods and print their tables."""
    cases = heap_cases()
    grainfit_answer(cases[0])
    rows: dict[str, Row] = {}
    for name, method in METHODS.items():
        try:
            rows[name] = score(cases, method(cases))
        except ImportError as missing:
            print(f"Left out: {name} ({missing}).", file=sys.stderr)
    print("Heap test, 2 free parameters: RMSE, coverage of new runs\n")
    print_table(rows)
    goals = judge(rows)
    print()
    for goal, met in goals.items():
        print(f"{'met    ' if met else 'NOT MET'}  {goal}")
    others = {
        "heap test, 4 free parameters": four_parameter_cases(),
        "synthetic, noise 0.02": synthetic_cases(0.02),
        "synthetic, noise 0.2": synthetic_cases(0.2),
    }
    checks = {}
    print("\nOther problems, grainfit: RMSE, coverage of new runs")
    for name, more in others.items():
        checks[name] = score(more, METHODS["grainfit"](more))
        print(f"\n{name}\n")
        print_table({"grainfit": checks[name]})
    return {"heap": rows, "goals": goals, "other": checks}


def main() -> None:
    parser = argparse.ArgumentParser(description="Accuracy, coverage and time of Kriging.")
    parser.add_argument("--json", type=Path, help="write all figures to this file")
    arguments = parser.parse_args()
    # One thread for all methods; Octave takes the number from the environment.
    os.environ["OMP_NUM_THREADS"] = "1"
    with threadpool_limits(limits=1, user_api="blas"):
        figures = measure()
    if arguments.json:
        arguments.json.write_text(json.dumps(figures, indent=2) + "\n")


if __name__ == "__main__":
    main()
