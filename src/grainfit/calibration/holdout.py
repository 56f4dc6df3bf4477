"""Simulate tests that took no part in a calibration, and predict them.

Each is simulated at the answer with several seeds, at a few parameter sets drawn from the
posterior, and at a few over the intervals of the parameters. The runs are those of a campaign:
kept, reused, and made again only where they are missing.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from grainfit.bulk_tests.registry import response_info
from grainfit.calibration import messages
from grainfit.calibration.holdout_runs import HoldoutProgress, simulate_holdout
from grainfit.calibration.readiness import measured_faults
from grainfit.calibration.registrations import Draws, HoldoutFile
from grainfit.calibration.scopes import restricted_to_used
from grainfit.calibration.timeouts import read_timeout
from grainfit.errors import Fault, InputError, RunFailedError
from grainfit.evaluation import Evaluation, Proposal
from grainfit.formatting import causes
from grainfit.metamodels.designs import maximin_latin_hypercube
from grainfit.one_line import OneLine
from grainfit.problem import CurveTarget, Problem, Target
from grainfit.problem.messages import NO_TEST_NAME
from grainfit.result import HoldoutResult, Registration
from grainfit.result.holdout import Basis
from grainfit.run_definition import identity_of
from grainfit.solvers.base import Solver
from grainfit.solvers.own_model.python_callable import PythonCallable
from grainfit.strategies.seeds import holdout_seed
from grainfit.validation import list_faults, set_plain, whole_number_faults
from grainfit.verdict.options import HOLDOUT

if TYPE_CHECKING:
    # Imports the store, which a calibration file is read without.
    from grainfit.campaign.campaign import Campaign

#: Largest number of parameter sets over which a prediction is averaged: an end of its interval
#: then lies at 2.5 ± 0.5 %.
_MOST_SETS = 1000


@dataclass(frozen=True)
class Holdout(OneLine):
    """A test that takes no part in the fit, and is predicted afterwards.

    Parameters
    ----------
    name : str
        Name of the test, different from those of the fitted ones.
    solver : Solver or callable
        As of `grainfit.calibrate`.
    targets : sequence of Target
        What was measured, by the names of the responses. Without any, and without curves, the
        responses are predicted and compared with nothing.
    repeats : int
        Runs with different seeds whose mean is one evaluation.
    timeout : float or str, optional
        Longest wall time of a run, s, or a quantity such as ``"10 min"``; by default that of the
        solver.
    curves : sequence of CurveTarget
        Measured curves, by the names of the responses.
    """

    name: str
    solver: Solver | Callable[..., Mapping[str, float]]
    targets: Sequence[Target] = ()
    repeats: int = 1
    timeout: float | None = None
    curves: Sequence[CurveTarget] = ()

    if TYPE_CHECKING:
        # Quantities are read: attributes are numbers.
        def __init__(
            self,
            name: str,
            solver: Solver | Callable[..., Mapping[str, float]],
            targets: Sequence[Target] = (),
            repeats: int = 1,
            timeout: float | str | None = None,
            curves: Sequence[CurveTarget] = (),
        ) -> None: ...

    def __post_init__(self) -> None:
        if not isinstance(self.name, str):
            raise InputError(NO_TEST_NAME.fault("holdout", given=self.name))
        key = f"holdout {self.name}"
        faults = list_faults(f"{key}, targets", self.targets, Target)
        faults += list_faults(f"{key}, curves", self.curves, CurveTarget)
        set_plain(self, "repeats")
        faults += whole_number_faults({f"{key}, repeats": self.repeats})
        if not isinstance(self.solver, Solver) and not callable(self.solver):
            faults.append(messages.NO_SOLVER.fault(f"{key}, solver", given=self.solver))
        if self.timeout is not None:
            seconds, found = read_timeout(f"{key}, timeout", self.timeout)
            object.__setattr__(self, "timeout", seconds)
            faults += found
        InputError.raise_for(faults)

    @property
    def model(self) -> Solver:
        """The solver; of a function, one that calls it."""
        if isinstance(self.solver, Solver):
            return self.solver
        return PythonCallable(self.solver)

    @property
    def runs(self) -> int:
        """Runs that its prediction takes."""
        return HOLDOUT.sets * self.repeats

    @property
    def measured(self) -> tuple[Target | CurveTarget, ...]:
        """All that was measured, numbers first."""
        return (*self.targets, *self.curves)

    @property
    def needed(self) -> set[str]:
        """Responses that every run must give; empty for all of its solver."""
        return {target.name for target in self.measured}


@dataclass(frozen=True)
class Material:
    """What is known of the parameters of a material.

    Parameters
    ----------
    problem : Problem
        Free parameters within their intervals before the calibration.
    answer : mapping of str to float
        Their values, and those of fixed parameters that are set.
    sample : ndarray, shape (n, d)
        Parameter sets that agree with what is known, in the unit cube.
    seed : int
        Seed of the calibration.
    identity : str
        Identity of the calibration; empty for another material.
    basis : {"posterior", "intervals", "values"}
        What the sample is.
    """

    problem: Problem
    answer: Mapping[str, float]
    sample: NDArray[np.float64]
    seed: int = 1
    identity: str = ""
    basis: Basis = "posterior"

    @property
    def key(self) -> str:
        """Key of the parameter sets that are drawn for it."""
        return identity_of(
            {
                "calibration": self.identity,
                "answer": dict(self.answer),
                # Those of a calibration are known by its identity.
                "intervals": {} if self.identity else _plain(self.problem.intervals),
                "basis": self.basis,
                "draws": [HOLDOUT.posterior_draws, HOLDOUT.prior_draws],
            }
        )

    def draws(self) -> Draws:
        """Return parameter sets to simulate, rounded to the digits that people read."""
        random = np.random.default_rng(self.seed)
        count = min(HOLDOUT.posterior_draws, len(self.sample))
        chosen = self.sample[random.choice(len(self.sample), count, replace=False)]
        if self.basis == "values":
            # They are the answer itself.
            chosen = chosen[:0]
        spread = maximin_latin_hypercube(HOLDOUT.prior_draws, self.problem.dimension, self.seed)
        return Draws(self.key, *(tuple(map(self._rounded, part)) for part in (chosen, spread)))

    def _rounded(self, point: NDArray[np.float64]) -> dict[str, float]:
        return {**self.answer, **self.problem.rounded(self.problem.from_unit(point))}


def _plain(intervals: Mapping[str, tuple[float, float]]) -> dict[str, list[float]]:
    return {name: list(ends) for name, ends in intervals.items()}


def require_holdouts(
    problem: Problem, solvers: Mapping[str, Solver], holdouts: Sequence[Holdout]
) -> None:
    """Raise `InputError` for hold-outs that cannot be simulated, or that were fitted.

    Parameters
    ----------
    problem : Problem
        Free parameters and fitted targets.
    solvers : mapping of str to Solver
        Of the fitted tests, by name.
    holdouts : sequence of Holdout
        The hold-outs.

    Raises
    ------
    InputError, SolverNotFoundError
        The first reason.
    """
    InputError.raise_for(list_faults("holdouts", holdouts, Holdout))
    taken = set(solvers)
    for holdout in holdouts:
        key = f"holdout {holdout.name}"
        if holdout.name in taken:
            raise InputError(messages.HOLDOUT_OF_SAME_NAME.fault(key))
        taken.add(holdout.name)
        InputError.raise_for(
            replace(f, key=", ".join(filter(None, (key, f.key)))) for f in _faults(problem, holdout)
        )
        holdout.model.check()
    require_not_fitted(
        problem, {name: identity_of(one.model()) for name, one in solvers.items()}, holdouts
    )


def require_not_fitted(
    problem: Problem, fitted: Mapping[str, str], holdouts: Sequence[Holdout]
) -> None:
    """Raise `InputError` for a hold-out whose measured values were fitted in the same simulation.

    Another measurement of a fitted response, of another sample or session, tells something new.

    Parameters
    ----------
    problem : Problem
        Free parameters and fitted targets.
    fitted : mapping of str to str
        Hash of the model by name of the fitted test.
    holdouts : sequence of Holdout
        The hold-outs.

    Raises
    ------
    InputError
        The first one.
    """
    for holdout in holdouts:
        model = identity_of(holdout.model.model())
        for test in (test for test, other in fitted.items() if other == model):
            known = problem.measured_in(test)
            if any(one.measures_same(known.get(one.name)) for one in holdout.measured):
                fault = messages.HOLDOUT_WAS_FITTED.fault(f"holdout {holdout.name}", test=test)
                raise InputError(fault)


def _faults(problem: Problem, holdout: Holdout) -> Iterator[Fault]:
    try:
        if holdout.targets or holdout.curves:
            Problem(problem.parameters, holdout.targets, curves=holdout.curves)
    except InputError as error:
        yield from error.faults
        return
    known = holdout.model.response_names
    for name in sorted(holdout.needed.difference(known or holdout.needed)):
        responses = ", ".join(sorted(known or ()))
        yield messages.HOLDOUT_WITHOUT_RESPONSE.fault("", name=name, responses=responses)
    yield from measured_faults(holdout.model, {target.name: target for target in holdout.measured})
    try:
        own, solver = restricted_to_used(problem, holdout.model)
    except InputError as error:
        yield from error.faults
        return
    yield from solver.interval_faults(own.intervals)


def predict_holdout(
    holdout: Holdout,
    material: Material,
    file: HoldoutFile,
    make: Callable[[Holdout, Solver], Campaign],
    show: Callable[[HoldoutProgress], None] = lambda _: None,
    registration: Registration | None = None,
) -> HoldoutResult:
    """Simulate a hold-out, or find its runs, and predict its responses.

    Parameters
    ----------
    holdout : Holdout
        The test.
    material : Material
        What is known of the parameters.
    file : HoldoutFile
        File of its parameter sets.
    make : callable
        Returns the campaign of the test, given its solver; it is closed here, and after Ctrl-C
        its unfinished runs are ended.
    show : callable, optional
        Called with the progress, a few times per second.
    registration : Registration, optional
        Registration of its targets.
    """
    if (draws := file.draws(material.key)) is None:
        file.keep(draws := material.draws())
    # Imports SciPy's distributions, which a calibration file is read without.
    from grainfit.analysis.curve_prediction import predict_curve
    from grainfit.analysis.prediction import HoldoutEvaluations, predict_response

    own, solver = restricted_to_used(material.problem, holdout.model)
    proposals = _proposals(material, draws)
    runs, why = simulate_holdout(make(holdout, solver), proposals, holdout.needed, show)
    known = ([runs[p.seed] for p in part if p.seed in runs] for part in proposals)
    parts = HoldoutEvaluations(*known)
    axes = [i for i, p in enumerate(material.problem.parameters) if p in own.parameters]
    step = max(1, len(material.sample) // _MOST_SETS)
    sample = material.sample[::step][:, axes]
    ended = HoldoutResult(
        holdout.name,
        "simulated",
        registration=registration,
        basis=material.basis,
        runs=sum(len(one.runs) for one in parts.all),
        failed=sum(len(one.failed_runs) for one in parts.all),
        why="; ".join(_reasons(parts.all)),
    )
    if why:
        return replace(ended, state="failed", why=why)
    measured = {target.name: target for target in holdout.targets}
    given = dict.fromkeys(sorted({name for one in parts.all for name in one.responses}))
    try:
        if not (holdout.needed or given):
            raise RunFailedError(ended.why)
        found = {
            name: predict_response(own, name, parts, sample, target, _unit(solver, name))
            for name, target in (measured if holdout.needed else given).items()
        }
        curves = {one.name: predict_curve(own, one, parts, sample) for one in holdout.curves}
    except (RunFailedError, InputError) as error:
        return replace(ended, state="failed", why=str(error))
    return replace(ended, responses=found, curves=curves)


def _reasons(evaluations: Sequence[Evaluation]) -> list[str]:
    """Return why runs failed, each cause once."""
    return causes(why for one in evaluations for why in one.failures.values())


def _proposals(material: Material, draws: Draws) -> list[list[Proposal]]:
    """Return the runs at the answer, over the posterior, and over the intervals."""
    parts = [[material.answer] * HOLDOUT.answer_seeds, draws.posterior, draws.prior]
    numbers = iter(range(1, sum(map(len, parts)) + 1))
    return [
        [
            Proposal(dict(values), holdout_seed(material.seed, next(numbers)), "verification")
            for values in part
        ]
        for part in parts
    ]


def _unit(solver: Solver, response: str) -> str:
    known = response_info(response) if solver.bulk_test is not None else None
    return known.unit if known else ""
