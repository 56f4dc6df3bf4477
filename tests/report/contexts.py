"""What sections of the report are made from, without a work folder."""

from __future__ import annotations

import json
import shutil
import subprocess
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from importlib.resources import files
from pathlib import Path
from typing import Any

import numpy as np
from scipy.stats import qmc

from grainfit.analysis.analysis import Analysis, analyse
from grainfit.analysis.identifiability import assess_identifiability
from grainfit.analysis.intervals import parameter_intervals
from grainfit.analysis.pareto import pareto_front
from grainfit.analysis.posterior import sample_posterior
from grainfit.analysis.sensitivity import estimate_sensitivity
from grainfit.contact_models.registry import MATERIAL_PARAMETERS
from grainfit.evaluation import Evaluation, Proposal, Response
from grainfit.materials.time_step import RayleighTimeStep
from grainfit.metamodels.metamodels import Metamodels, can_be_fitted
from grainfit.problem import Parameter, Problem, Target
from grainfit.report.section import ReportContext
from grainfit.result import ResponseResult, Result, RunCounts
from grainfit.strategies.answer import metamodel_quality
from grainfit.work_folder.saved_calibration import SavedCalibration

NODE = shutil.which("node")
NASTY = "<script>alert('x')</script> \"Größe\" & {{ 7*7 }}"


def problem(parameters: int, responses: int, *, rayleigh: bool = True) -> Problem:
    """As many of the 14 parameters, the second on a logarithmic scale."""
    names = ["particle.density", "particle.youngs_modulus"]
    needed = [name for name, known in MATERIAL_PARAMETERS.items() if known.default is None]
    names += [name for name in needed if name not in names]
    free = [
        Parameter(name, 1e5, 1e7, "log", "Pa")
        if name.endswith("youngs_modulus")
        else Parameter(name, 0.1, 0.4)
        if name.endswith("poissons_ratio")
        else Parameter(name, 0.2, 0.8)
        for name in names[:parameters]
    ]
    targets = [Target(f"response {i}", 10.0 * (i + 1), tolerance=0.3) for i in range(responses)]
    fixed = {
        "particle.density": 2500.0,
        "particle.youngs_modulus": 1e6,
        "particle.poissons_ratio": 0.25,
    }
    step = RayleighTimeStep(0.005, {n: v for n, v in fixed.items() if n not in names[:parameters]})
    return Problem(free, targets, step if rayleigh else None)


def simulate(wanted: Problem, point: np.ndarray, seed: int) -> dict[str, float]:
    """Responses that meet all targets at 0.4 of every interval; each mostly by one parameter."""
    random = np.random.default_rng(seed)
    off = point - 0.4
    return {
        target.name: target.value
        + 3.0 * float(off[number % len(off)] + 0.3 * off.mean() + 0.5 * off[0] ** 2)
        + 0.1 * random.standard_normal()
        for number, target in enumerate(wanted.targets)
    }


def evaluations(
    wanted: Problem, runs: int, *, failing: Callable[[int, str], bool] = lambda _n, _name: False
) -> list[Evaluation]:
    """Runs of a design; some may fail to give a response, by number (from 1) and its name."""
    points = qmc.LatinHypercube(wanted.dimension, rng=1).random(runs)
    found = []
    for number, point in enumerate(points, start=1):
        given = {
            name: Response(value)
            for name, value in simulate(wanted, point, number).items()
            if not failing(number, name)
        }
        failures = {} if given else {"test": "particles were lost"}
        proposal = Proposal(wanted.from_unit(point), number, "design")
        found.append(Evaluation(proposal, given, failures))
    return found


def reading(wanted: Problem, known: Sequence[Evaluation], *, answered: bool) -> SavedCalibration:
    """What a work folder would tell of these runs."""
    answer = wanted.from_unit([0.4] * wanted.dimension)
    return SavedCalibration(
        folder=Path("work"),
        name="glass beads",
        identity="0",
        state="calibrated" if answered else "interrupted",
        problem=wanted,
        strategy="sequential",
        seed=1,
        evaluations=tuple(known),
        warm_start=(),
        running=0,
        records={},
        result=result_of(wanted, answer) if answered else None,
        result_fault="",
        fixed={},
        units={parameter.name: parameter.unit for parameter in wanted.parameters},
        source="beads.toml",
        source_text="",
        version="0.1.0",
        workers=1,
        started=0.0,
    )


def result_of(wanted: Problem, answer: Mapping[str, float]) -> Result:
    """A result whose responses all meet their targets, without fresh seeds."""
    return Result(
        status="calibrated",
        parameters=answer,
        responses={
            target.name: ResponseResult(
                target=target.value,
                tolerance=target.tolerance,
                unit=target.unit,
                predicted=target.value,
                standard_error=0.1,
                probability=0.99,
                verified_mean=None,
                verified_standard_error=None,
                verified_interval=None,
                deviation_percent=0.0,
                verdict="met",
            )
            for target in wanted.targets
        },
        runs=RunCounts(),
        rayleigh_time_step=None,
        rayleigh_time_step_before=None,
        rayleigh_time_step_limits=None,
        wall_seconds=0.0,
        utilisation=0.0,
        probability_all_met=None,
        name="",
        identity="0",
        strategy="sequential",
        seed=1,
        version="0.1.0",
    )


def context(
    wanted: Problem, known: Sequence[Evaluation], *, answered: bool = True
) -> ReportContext:
    """Context of a calibration that made these runs."""
    told = reading(wanted, known, answered=answered)
    analysis = rough_analysis(wanted, known) if can_be_fitted(wanted, known) else None
    return ReportContext(told, analysis or analyse(wanted, known))


def rough_analysis(wanted: Problem, known: Sequence[Evaluation]) -> Analysis:
    """All parts of an analysis, from so few samples that it takes no time."""
    metamodels = Metamodels.fit(wanted, known)
    posterior = sample_posterior(metamodels, samples=200, max_steps=10)
    return Analysis(
        metamodels=metamodels,
        quality=metamodel_quality(metamodels),
        posterior=posterior,
        intervals=parameter_intervals(posterior, wanted),
        sensitivity=estimate_sensitivity(metamodels, points=32),
        identifiability=assess_identifiability(posterior, wanted),
        pareto=pareto_front(metamodels, points=4),
    )


def renamed(wanted: Problem) -> Problem:
    """The same with names and units that are something else where they are not escaped."""
    return replace(
        wanted,
        parameters=[replace(p, name=f"{NASTY} {p.name}", unit=NASTY) for p in wanted.parameters],
        targets=[replace(t, name=f"{NASTY} {t.name}", unit=NASTY) for t in wanted.targets],
        rayleigh=None,
    )


def in_node(program: str, data: Mapping[str, Any], *scripts: str) -> Any:
    """What a program returns of data, when scripts of the page have run before it."""
    folder = files("grainfit.report") / "scripts"
    loaded = "".join(f"require({json.dumps(str(folder / name))});" for name in scripts)
    whole = (
        f"{loaded} const data = JSON.parse(require('fs').readFileSync(0, 'utf8'));"
        f"process.stdout.write(JSON.stringify((() => {{ {program} }})()));"
    )
    assert NODE is not None
    done = subprocess.run(
        [NODE, "-e", whole], input=json.dumps(data), capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)
