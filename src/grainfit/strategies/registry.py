"""Which strategy the user wants, by its name and options."""

from __future__ import annotations

from dataclasses import dataclass
from typing import get_args

from grainfit.errors import Fault, InputError
from grainfit.problem import Problem
from grainfit.strategies.base import Strategy, smallest_design
from grainfit.strategies.sequential.options import Preference, SequentialOptions
from grainfit.strategies.sequential.strategy import Sequential
from grainfit.strategies.staged.strategy import Staged, StagedOptions

#: Names of the strategies, the default first.
STRATEGIES = (Sequential.name, Staged.name)
DEFAULT_STRATEGY = STRATEGIES[0]
PREFERENCES: tuple[str, ...] = get_args(Preference)


@dataclass(frozen=True)
class StrategyChoice:
    """A strategy by name, and what the user says of it; None is what the strategy does anyway.

    Parameters
    ----------
    name : str
        One of `STRATEGIES`.
    design_runs : int, optional
        Size of the Latin hypercube.
    prefer : {"time_step", "accuracy"}, optional
        See `SequentialOptions`; the staged strategy knows no such preference.
    extend_intervals : bool, optional
        The same.
    """

    name: str = DEFAULT_STRATEGY
    design_runs: int | None = None
    prefer: Preference | None = None
    extend_intervals: bool | None = None

    def check(self, rayleigh_weight: float = 0.0) -> None:
        """Raise InputError unless there is such a strategy that knows such options.

        Parameters
        ----------
        rayleigh_weight : float
            Weight of the Rayleigh criterion, which is an option of the staged strategy.
        """
        faults = []
        if self.name not in STRATEGIES:
            known = ", ".join(STRATEGIES)
            faults.append(Fault("strategy", f"{self.name!r} is unknown.", f"Use one of: {known}."))
        if self.prefer is not None and self.prefer not in PREFERENCES:
            known = ", ".join(PREFERENCES)
            faults.append(Fault("prefer", f"is {self.prefer!r}.", f"Use one of: {known}."))
        if self.extend_intervals is not None and not isinstance(self.extend_intervals, bool):
            faults.append(
                Fault("extend_intervals", f"is {self.extend_intervals!r}.", "Use true or false.")
            )
        for key in ("prefer", "extend_intervals"):
            if self.name == Staged.name and getattr(self, key) is not None:
                faults.append(
                    Fault(
                        key,
                        "has no meaning for the staged strategy.",
                        'Leave it out, or use strategy "sequential".',
                    )
                )
        if self.name == Sequential.name and rayleigh_weight > 0:
            faults.append(
                Fault(
                    "rayleigh_weight",
                    "has no meaning for the sequential strategy, which takes the largest time "
                    "step that agrees with the measurements anyway.",
                    'Leave it out, or use strategy "staged".',
                )
            )
        if faults:
            raise InputError(faults)

    def make(self, problem: Problem, seed: int, max_evaluations: int | None) -> Strategy:
        """Make the strategy."""
        if self.name == Staged.name:
            return Staged(problem, seed, max_evaluations, StagedOptions(self.design_runs))
        options = SequentialOptions(
            design_runs=self.design_runs,
            prefer=self.prefer or SequentialOptions.prefer,
            extend_intervals=bool(self.extend_intervals),
        )
        return Sequential(problem, seed, max_evaluations, options)


def make_strategy(
    problem: Problem,
    choice: StrategyChoice,
    tests: int,
    seed: int,
    max_runs: int | None,
    verification_runs: int,
) -> Strategy:
    """Make the strategy of a calibration within a budget of DEM runs.

    Parameters
    ----------
    problem : Problem
        What is calibrated.
    choice : StrategyChoice
        What the user wants.
    tests : int
        DEM runs that a parameter set takes.
    seed : int
        Decides the design and all insertion seeds.
    max_runs : int or None
        Largest number of DEM runs, verification included.
    verification_runs : int
        Runs of a verification; the budget keeps room for one.

    Raises
    ------
    InputError
        There is no such strategy, the design is too small, or the budget is too small for the
        design and the verification.
    """
    choice.check(problem.rayleigh_weight)
    if max_runs is None:
        return choice.make(problem, seed, None)
    smallest = (smallest_design(problem.dimension, choice.design_runs) + verification_runs) * tests
    if max_runs < smallest:
        raise InputError(
            Fault(
                "max_runs",
                f"{max_runs} runs are too few for the design and the verification.",
                f"Allow at least {smallest}.",
            )
        )
    return choice.make(problem, seed, max_runs // tests - verification_runs)
