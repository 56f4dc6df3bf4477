"""Interface of all solvers.

A *solver* turns values of the free parameters and a seed into responses. Its life cycle:

1. it is created once per test of a calibration and does not change afterwards;
2. `Solver.check` is called once, before the first run, and raises an error if something is missing;
3. `Solver.definition` is called for every run that is needed. It combines `Solver.model`, the
   parameters and the seed: everything that determines the outcome. Its hash is the identity of the
   run: equal definitions are the same run, and a known run is never repeated;
4. `Solver.run` is called from worker threads, several at a time, each with its own folder. It
   returns the responses or raises `RunFailedError`. It keeps no state between runs.
"""

from __future__ import annotations

import threading
from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar, Literal, Self, TypeAlias

from grainfit.bulk_tests.workload import workload
from grainfit.errors import Fault
from grainfit.evaluation import Measured
from grainfit.one_line import OneLine
from grainfit.run_definition import RunDefinition, without_defaults
from grainfit.solvers.run_cost import RunCost
from grainfit.solvers.speed import Speed

if TYPE_CHECKING:
    # Imports NumPy, which the state of a calibration does without.
    from grainfit.bulk_tests.base import BulkTest
    from grainfit.scenes.scene import Scene


#: Whether a model can read the seed of a run: it may; as far as its text tells, it does not; or it
#: is not given it.
SeedUse: TypeAlias = Literal["read", "unread", "none"]


@dataclass(frozen=True)
class Workspace(OneLine):
    """Folder and limits of one run.

    Parameters
    ----------
    folder : Path
        Empty folder of this run alone, which is kept (only for solvers that use one).
    timeout : float, optional
        Longest wall time, s.
    cancelled : threading.Event
        Set when the user stops the calibration: the run must end soon.
    """

    folder: Path
    timeout: float | None = None
    cancelled: threading.Event = field(default_factory=threading.Event)


@dataclass(frozen=True)
class SourceRecord(OneLine):
    """Record that a run reads instead of being made.

    Parameters
    ----------
    name : str
        Name of the record among all of its solver.
    parameters : mapping of str to float
        Values with which it was made.
    is_at_parameters : bool
        Whether these are the values of the run.
    """

    name: str
    parameters: Mapping[str, float]
    is_at_parameters: bool


class Solver(ABC, OneLine):
    """Interface of solvers: turn parameter values and a seed into responses."""

    #: Short name shown to the user, as in the calibration file.
    name: str
    #: Whether runs need their own folder; in-process functions and tables do not.
    uses_folder: bool = True
    #: Contact models that replace the usual ones, of solvers of bulk tests.
    contact_models: tuple[str, ...] = ()
    #: Speed that run times of bulk tests are estimated from; that of a slow program by default.
    speed: ClassVar[Speed] = Speed(0.4e6)

    @property
    @abstractmethod
    def response_names(self) -> tuple[str, ...] | None:
        """Names of the responses of a run; None if they are known only after a run."""

    @abstractmethod
    def model(self) -> Mapping[str, Any]:
        """Return everything that determines the outcome except parameters and seed, as JSON.

        It is the same for all runs of the solver. Runs with different models are different runs.

        Raises
        ------
        SolverNotFoundError
            A program whose version is part of the model is not found.
        """

    @property
    def bulk_test(self) -> BulkTest | None:
        """The bulk test that it simulates; None for a model of the user."""
        return None

    @property
    def absent(self) -> Mapping[str, str]:
        """Responses that a valid run may be without, with the reason; none by default."""
        return {}

    def of_test(self, test: BulkTest) -> Self:
        """Return the solver with another bulk test of the same type.

        Raises
        ------
        TypeError
            It is a model of the user.
        """
        raise TypeError(f"{self.name} has no bulk test, not even {test.type}")

    def within(self, intervals: Mapping[str, tuple[float, float]]) -> Self:  # noqa: ARG002
        """Return the solver with what follows from the intervals of the free parameters.

        Parameters
        ----------
        intervals : mapping of str to tuple of float
            Bounds of the free parameters, SI; those that it does not have are of no effect.
        """
        return self

    def filming(self, frames: int, duration: float | None = None) -> Self:
        """Return the solver such that its runs keep frames of the particles; they are the same.

        A model of the user keeps none.

        Parameters
        ----------
        frames : int
            About how many frames a run is to be shown with; it keeps more.
        duration : float, optional
            Simulated time of the run, s, where it is known.
        """
        del frames, duration
        return self

    @property
    def walls(self) -> Mapping[str, str]:
        """Walls with a name by the parts of its bulk test; the others are of the plain wall."""
        return {}

    def run_parameters(self, parameters: Mapping[str, float]) -> dict[str, float]:
        """Return the values of all parameters that a run depends on, free or fixed.

        Parameters
        ----------
        parameters : mapping of str to float
            Values of the free parameters.

        Raises
        ------
        InputError
            A value is missing or impossible.
        """
        return {name: float(value) for name, value in parameters.items()}

    def depends_on(self, names: Sequence[str]) -> tuple[str, ...]:
        """Return those of some free parameters that runs can depend on; all by default.

        With several tests, a run is passed only these, and its responses get metamodels of these.
        """
        return tuple(names)

    @property
    def defaults(self) -> Mapping[str, float]:
        """Default values of parameters; none by default."""
        return {}

    def definition(self, parameters: Mapping[str, float], seed: int) -> RunDefinition:
        """Return everything that determines the outcome of this run.

        Raises
        ------
        InputError
            A parameter is missing or has an impossible value.
        SolverNotFoundError
            See `Solver.model`.
        """
        given = without_defaults(self.run_parameters(parameters), self.defaults)
        return RunDefinition(self.model(), given, int(seed))

    @abstractmethod
    def run(
        self, parameters: Mapping[str, float], seed: int, workspace: Workspace
    ) -> Mapping[str, Measured]:
        """Run one simulation.

        Raises
        ------
        RunFailedError
            The run gave no responses; the error has the reason and the end of the log.
        """

    def record_of(
        self,
        parameters: Mapping[str, float],  # noqa: ARG002
        seed: int,  # noqa: ARG002
    ) -> SourceRecord | None:
        """Return the record that a run reads; None, the default, for a run that is made.

        Runs that read one record are no independent evidence, whatever their seeds.
        """
        return None

    @property
    def seed_use(self) -> SeedUse:
        """Whether a run can depend on its seed; without one, the model is deterministic."""
        return "read"

    def raw_output(self, folder: Path) -> Sequence[Path]:  # noqa: ARG002
        """Return the files from which the responses of a run are measured; none by default.

        They tell whether two runs gave the same output: equal responses do not.

        Parameters
        ----------
        folder : Path
            Folder of the run.
        """
        return ()

    def check(self) -> None:
        """Raise `SolverNotFoundError` or `InputError` if no run can succeed."""

    def interval_faults(
        self,
        intervals: Mapping[str, tuple[float, float]],  # noqa: ARG002
    ) -> list[Fault]:
        """Return why runs cannot succeed in a part of the intervals; empty by default.

        Parameters
        ----------
        intervals : mapping of str to tuple of float
            Bounds of the free parameters.
        """
        return []

    def version(self) -> str:
        """Return the version of the program, for display and for the identity of runs."""
        return ""

    def executes(self) -> tuple[str, ...]:
        """Describe what a run executes, in one line for each program or function.

        Nothing is executed for this.

        Raises
        ------
        SolverNotFoundError
            A program is not found.
        """
        return ()

    def readiness(self) -> str:
        """Return the message that the solver is ready; called after `check`."""
        return f"{self.name} {self.version()}".rstrip() + " is ready."

    def experiment(self, parameters: Mapping[str, float], seed: int) -> Scene:
        """Return the scene of a run of its bulk test, even if the program cannot simulate it.

        Raises
        ------
        InputError
            The material is impossible.
        RunFailedError
            The test is of the user, and its function failed.
        """
        assert self.bulk_test is not None, "models of the user have no scene"
        return self.bulk_test.scene(self.run_parameters(parameters), seed)

    def estimate_cost(self, parameters: Mapping[str, float]) -> RunCost | None:  # noqa: ARG002
        """Estimate the cost of a run; None if it is unknown."""
        return None

    def seconds_on(self, ranks: int, parameters: Mapping[str, float]) -> float | None:  # noqa: ARG002
        """Estimate the wall time of a run on a number of MPI ranks, s; None if it is unknown.

        Also None where the program does not run on so many.
        """
        return None

    def starts_anew(self, parameters: Mapping[str, float]) -> str:  # noqa: ARG002
        """Return why a long run that is killed starts anew; empty if it goes on, or is short.

        Models of the user, which write no restart files of grainfit, return an empty text.
        """
        return ""

    def estimate_cost_of(self, test: BulkTest, material: Mapping[str, float]) -> RunCost:
        """Estimate the cost of a run of any bulk test.

        Parameters
        ----------
        test : BulkTest
            The test.
        material : mapping of str to float
            At least density, Young's modulus and Poisson's ratio of the particles.
        """
        return self.speed.cost(workload(test, material))

    def default_timeout(self, parameters: Mapping[str, float]) -> float | None:  # noqa: ARG002
        """Return the default time-out of a run, s; None for no time-out."""
        return None
