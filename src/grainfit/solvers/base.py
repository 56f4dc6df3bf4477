"""The one small interface behind which every simulated experiment stands.

A *solver* turns values of the free parameters and a seed into responses. Its life is short:

1. it is made once per test of a calibration and is immutable from then on;
2. `Solver.check` is called once, before anything is run, and says in words what is missing;
3. `Solver.definition` is called for every run that is wanted. It puts together the `Solver.model`,
   the parameters and the seed: all that decides the run's outcome. Its hash is the run's identity:
   equal definitions are the same run, and a run that is already known is never repeated;
4. `Solver.run` is called from worker threads, several at a time, each with a folder of its own.
   It returns the responses or raises `RunFailedError`. It keeps no state between runs.
"""

from __future__ import annotations

import threading
from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from grainfit.bulk_tests.run_cost import RunCost
from grainfit.evaluation import Response
from grainfit.run_definition import RunDefinition


@dataclass(frozen=True)
class Workspace:
    """Where and under which limits one run happens.

    Parameters
    ----------
    folder : Path
        Exists, is empty, belongs to this run alone, and is kept (only for solvers that use one).
    timeout : float, optional
        Longest wall time, s.
    cancelled : threading.Event
        Set when the user stops the calibration: the run must end soon.
    """

    folder: Path
    timeout: float | None = None
    cancelled: threading.Event = field(default_factory=threading.Event)


class Solver(ABC):
    """Anything that turns parameter values and a seed into responses."""

    #: Short name shown to the user, as in the calibration file.
    name: str
    #: Whether runs need a folder of their own; in-process functions and tables do not.
    uses_folder: bool = True

    @property
    @abstractmethod
    def response_names(self) -> tuple[str, ...] | None:
        """Names of the responses that a run yields; None when only a run can tell."""

    @abstractmethod
    def model(self) -> Mapping[str, Any]:
        """Return all that decides the outcome of runs besides parameters and seed, as JSON.

        It is the same for all runs of the solver; one with another model makes other runs.

        Raises
        ------
        SolverNotFoundError
            A program of which the version is part of the model is not there.
        """

    def run_parameters(self, parameters: Mapping[str, float]) -> dict[str, float]:
        """Return the values of all parameters that a run depends on, free or fixed.

        Parameters
        ----------
        parameters : mapping of str to float
            Values of the free parameters.

        Raises
        ------
        InputError
            A value is missing or cannot be.
        """
        return {name: float(value) for name, value in parameters.items()}

    @property
    def defaults(self) -> Mapping[str, float]:
        """Values of parameters that need not be given; none by default."""
        return {}

    def definition(self, parameters: Mapping[str, float], seed: int) -> RunDefinition:
        """Return all that decides the outcome of this run.

        Raises
        ------
        InputError
            A parameter is missing or has an impossible value.
        SolverNotFoundError
            See `Solver.model`.
        """
        values, defaults = self.run_parameters(parameters), self.defaults
        given = {name: value for name, value in values.items() if defaults.get(name) != value}
        return RunDefinition(self.model(), given, int(seed))

    @abstractmethod
    def run(
        self, parameters: Mapping[str, float], seed: int, workspace: Workspace
    ) -> dict[str, Response]:
        """Simulate once.

        Raises
        ------
        RunFailedError
            The run gave no responses: why, and the tail of the log.
        """

    def check(self) -> None:
        """Raise `SolverNotFoundError` or `InputError` when no run could ever succeed."""

    def version(self) -> str:
        """Version of the program behind it, for people and for the run's identity."""
        return ""

    def executes(self) -> tuple[str, ...]:
        """Say what a run executes, one line for each program or function, for people.

        Nothing is executed to find out.

        Raises
        ------
        SolverNotFoundError
            A program is not there.
        """
        return ()

    def readiness(self) -> str:
        """Say that it is ready, for people; called after `check`."""
        return f"{self.name} {self.version()}".rstrip() + " is ready."

    def estimate_cost(self, parameters: Mapping[str, float]) -> RunCost | None:  # noqa: ARG002
        """Estimate the cost of a run; None where it cannot be known."""
        return None

    def default_timeout(self, parameters: Mapping[str, float]) -> float | None:  # noqa: ARG002
        """Wall time after which a run hangs, s; None where that cannot be known."""
        return None
