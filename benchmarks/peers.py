"""Other calibration methods, with which `strategies.py` compares those of grainfit.

Each is a function of a case, a budget and a seed. It makes `budget` noisy runs, each with an
insertion seed of its own, and returns its answers after 1, 2, ... runs. All of them get
the same start, a maximin Latin hypercube of 2 (d + 1) points, and the same misfit, the sum of
squared deviations in units of the tolerances. Until the start is over the answer is its best run.

They need `optuna`, `bayesian-optimization`, `cma`, and GrainLearning in an interpreter of its own,
because it needs NumPy 1; the environment variable GRAINLEARNING_PYTHON has the path of that:

    pip install optuna bayesian-optimization cma
    python -m venv grainlearning && grainlearning/bin/pip install "GrainLearning==2.0.5"
    export GRAINLEARNING_PYTHON=$PWD/grainlearning/bin/python

Every peer has the best configuration of those that were tried, with seeds from 101 on, at the
budgets of the comparison; its docstring lists what was tried.
"""

from __future__ import annotations

import contextlib
import io
import json
import os
import subprocess
import warnings
from collections.abc import Callable, Iterator, Sequence
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray
from threadpoolctl import threadpool_limits

from calibration_problems import Case
from grainfit.metamodels.designs import maximin_latin_hypercube
from grainfit.strategies.seeds import insertion_seed

Array = NDArray[np.float64]
Parameters = dict[str, float]
Peer = Callable[[Case, int, int], list[Parameters]]

GRAINLEARNING = "GRAINLEARNING_PYTHON"


class Calibration:
    """Runs made so far, in the unit cube, and the answer after each; begins with the start runs."""

    def __init__(self, case: Case, budget: int, seed: int) -> None:
        self.case, self.budget, self.seed = case, budget, seed
        self.points: list[Array] = []
        self.responses: list[Array] = []
        self.misfits: list[float] = []
        self.answers: list[Array] = []
        d = case.problem.dimension
        start = maximin_latin_hypercube(2 * (d + 1), d, seed)[:budget]
        for number, point in enumerate(start, 1):
            self._run(point, insertion_seed(seed, "design", number))
            self.answers.append(self.best)
        self.started_with = len(start)

    @property
    def left(self) -> int:
        """Number of runs that are left of the budget."""
        return self.budget - len(self.points)

    @property
    def best(self) -> Array:
        """Point of the run with the smallest misfit."""
        return self.points[int(np.argmin(self.misfits))]

    def run(self, point: ArrayLike) -> float:
        """Run at a point and return the misfit; the answer stays as it was."""
        number = len(self.points) - self.started_with + 1
        misfit = self._run(point, insertion_seed(self.seed, "optimisation", number))
        self.answers.append(self.answers[-1])
        return misfit

    def answer(self, point: ArrayLike) -> None:
        """Set the answer after the last run, which holds until another answer."""
        self.answers[-1] = np.clip(np.asarray(point, dtype=float), 0, 1)

    def parameters(self) -> list[Parameters]:
        """Answers after 1, 2, ... runs; the last of them for runs that were not made."""
        answers = self.answers + self.answers[-1:] * self.left
        return [self.case.problem.from_unit(point) for point in answers]

    def _run(self, point: ArrayLike, seed: int) -> float:
        position = np.clip(np.asarray(point, dtype=float), 0, 1)
        responses = self.case.simulate(self.case.problem.from_unit(position), seed=seed)
        self.points.append(position)
        self.responses.append(responses)
        self.misfits.append(self.case.misfit(responses))
        return self.misfits[-1]


@contextlib.contextmanager
def _quietly() -> Iterator[None]:
    """Suppress warnings and threads: the matrices are small and the cores are shared."""
    with warnings.catch_warnings(), threadpool_limits(limits=1):
        warnings.simplefilter("ignore")
        yield


# Optuna -------------------------------------------------------------------------------------


def optuna_tpe(case: Case, budget: int, seed: int) -> list[Parameters]:
    """Tree-structured Parzen estimator of Optuna; answers the best trial, as Optuna does.

    Multivariate, which is its default; independent marginals were worse. 96 candidates per
    trial were a little better than the default of 24. Its model begins after the start runs.
    """
    import optuna

    optuna.logging.set_verbosity(optuna.logging.ERROR)
    with _quietly():
        runs = Calibration(case, budget, seed)
        space: dict[str, Any] = {
            parameter.name: optuna.distributions.FloatDistribution(0, 1)
            for parameter in case.problem.parameters
        }
        sampler = optuna.samplers.TPESampler(
            n_startup_trials=runs.started_with, n_ei_candidates=96, multivariate=True, seed=seed
        )
        study = optuna.create_study(sampler=sampler)
        for point, misfit in zip(runs.points, runs.misfits, strict=True):
            values = dict(zip(space, point.tolist(), strict=True))
            study.add_trial(
                optuna.trial.create_trial(params=values, distributions=space, value=misfit)
            )
        while runs.left:
            trial = study.ask(space)
            study.tell(trial, runs.run([trial.params[name] for name in space]))
            runs.answer([study.best_params[name] for name in space])
    return runs.parameters()


# Bayesian optimisation ----------------------------------------------------------------------


def gaussian_process(case: Case, budget: int, seed: int) -> list[Parameters]:
    """Bayesian optimisation by the package bayesian-optimization: expected improvement.

    Answers the run with the smallest posterior mean of the misfit. Its Gaussian process has a
    noise term and an amplitude, and a range of its own for every parameter, refitted after each
    run. Ranges are kept below 2 cube edges: with a limit of 20, the parameter of the smaller effect
    was soon taken for irrelevant, and the search stuck at a bound. The misfit is not transformed.

    Tried: its defaults (one range, no noise, upper confidence bound with kappa 2.576), which were
    worse in more than two dimensions; the square root and log(1 + misfit), which amplify the noise
    near the optimum; upper confidence bounds with kappa 1 and 2; improvement over the best
    posterior mean; several starts of the likelihood search; the luckiest run as the answer, which
    was about as good.
    """
    from bayes_opt.acquisition import KnowledgeGradient
    from bayes_opt.target_space import TargetSpace
    from sklearn.gaussian_process import GaussianProcessRegressor
    from sklearn.gaussian_process.kernels import ConstantKernel, Matern, WhiteKernel

    with _quietly():
        runs = Calibration(case, budget, seed)
        d = case.problem.dimension
        random = np.random.RandomState(seed)
        kernel = ConstantKernel(1.0, (1e-2, 1e3)) * Matern([1.0] * d, (0.1, 2.0), nu=2.5)
        model = GaussianProcessRegressor(
            kernel + WhiteKernel(1e-3, (1e-6, 0.1)),
            normalize_y=True,
            random_state=random,
        )
        bounds = {parameter.name: (0.0, 1.0) for parameter in case.problem.parameters}
        space = TargetSpace(None, bounds, allow_duplicate_points=True)
        for point, misfit in zip(runs.points, runs.misfits, strict=True):
            space.register(point, -misfit)
        acquisition = KnowledgeGradient(xi=0.0)
        while True:
            model.fit(space.params, space.target)
            runs.answer(runs.points[int(np.argmax(model.predict(np.array(runs.points))))])
            if not runs.left:
                break
            candidate = acquisition.suggest(
                model, space, n_random=1000, n_smart=1, fit_gp=False, random_state=random
            )
            misfit = runs.run(candidate)
            # It prints when a point is repeated.
            with contextlib.redirect_stdout(io.StringIO()):
                space.register(candidate, -misfit)
    return runs.parameters()


# CMA-ES -------------------------------------------------------------------------------------


def cma_es(case: Case, budget: int, seed: int) -> list[Parameters]:
    """CMA-ES of the package cma, from the best start run; answers the best run.

    Population by default. Of the first step sizes 0.1, 0.15, 0.2 and 0.3 the smallest was the
    best: few generations are affordable. The best run was better than the mean of the
    distribution with all of them.
    """
    import cma

    with _quietly():
        runs = Calibration(case, budget, seed)
        # With seed 0 it takes the time as its seed.
        options = {"bounds": [0, 1], "seed": seed + 1, "verbose": -9}
        evolution = cma.CMAEvolutionStrategy(runs.best, 0.1, options)
        while runs.left:
            candidates = evolution.ask()
            misfits = []
            for candidate in candidates[: runs.left]:
                misfits.append(runs.run(candidate))
                runs.answer(runs.best)
            if len(misfits) == len(candidates):
                evolution.tell(candidates, misfits)
    return runs.parameters()


# GrainLearning ------------------------------------------------------------------------------


class _GrainLearning:
    """Process that runs GrainLearning, and the messages to and from it."""

    def __init__(self, interpreter: str) -> None:
        script = str(Path(__file__).with_name("peer_grainlearning.py"))
        try:
            self._process = subprocess.Popen(
                [interpreter, script],
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                stderr=subprocess.DEVNULL,
                text=True,
            )
        except OSError as error:
            raise ImportError(f"{GRAINLEARNING} cannot be run: {error}") from error
        if not self._reply():
            raise ImportError(f"{interpreter} has no GrainLearning: pip install GrainLearning.")

    def begin(self, **calibration: int) -> None:
        self._send({"begin": calibration})

    def iterate(self, points: Sequence[Array], deviations: Sequence[Array]) -> dict[str, Any]:
        """Send an ensemble; see `peer_grainlearning.py` for the reply."""
        self._send(
            {
                "points": [point.tolist() for point in points],
                "deviations": [deviation.tolist() for deviation in deviations],
            }
        )
        reply = self._reply()
        if not reply:
            raise RuntimeError("GrainLearning has ended unexpectedly.")
        return reply

    def _send(self, request: dict[str, Any]) -> None:
        assert self._process.stdin is not None
        self._process.stdin.write(json.dumps(request) + "\n")
        self._process.stdin.flush()

    def _reply(self) -> dict[str, Any]:
        assert self._process.stdout is not None
        line = self._process.stdout.readline()
        return dict(json.loads(line)) if line else {}


@cache
def _grainlearning(interpreter: str, owner: int) -> _GrainLearning:
    """Return the GrainLearning of process `owner`: a fork must not use that of its parent."""
    del owner
    return _GrainLearning(interpreter)


def grainlearning(case: Case, budget: int, seed: int) -> list[Parameters]:
    """Iterative Bayesian filter of GrainLearning; answers the weighted mean of the last ensemble.

    The start is its first ensemble, and all ensembles have that size, as is usual there. It is
    given the deviations in units of the tolerances, not the misfit. Runs of an ensemble that
    the budget cuts short are not used. It ends when its mixture can no longer be fitted.

    Tried: effective sample sizes of 0.3 (its default), 0.4, 0.5 and 0.7; full, tied and diagonal
    covariances; one or two components; slice sampling and plain sampling of the mixture, which
    collapses early; sigma kept between iterations or not; the most probable member
    instead of the mean.
    """
    interpreter = os.environ.get(GRAINLEARNING)
    if not interpreter:
        raise ImportError(
            f"GrainLearning needs NumPy 1: install it (pip install GrainLearning) in a virtual "
            f"environment of its own, and set {GRAINLEARNING} to the interpreter there."
        )
    child = _grainlearning(interpreter, os.getpid())
    runs = Calibration(case, budget, seed)
    size = runs.started_with
    child.begin(
        dimension=case.problem.dimension, responses=len(case.targets), samples=size, seed=seed
    )
    while size:
        deviations = [
            (responses - case.targets) / case.tolerances for responses in runs.responses[-size:]
        ]
        reply = child.iterate(runs.points[-size:], deviations)
        if "estimate" in reply:
            runs.answer(reply["estimate"])
        ensemble = reply.get("points", [])
        size = len(ensemble) if len(ensemble) <= runs.left else 0
        for point in ensemble[: runs.left]:
            runs.run(point)
    return runs.parameters()


PEERS: dict[str, Peer] = {
    "Optuna TPE": optuna_tpe,
    "Bayesian optimisation (scalar)": gaussian_process,
    "CMA-ES": cma_es,
    "GrainLearning": grainlearning,
}
