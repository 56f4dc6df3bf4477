"""A solver that gets exactly the parameters that it takes"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from grainfit.evaluation import Response
from grainfit.solvers.base import Solver, Workspace


class ParametersFor(Solver):
    """A solver that gets exactly the parameters that it takes.

    Parameters
    ----------
    solver : Solver
        Gets them.
    fixed : mapping of str to float, optional
        Values that it gets besides those of the free parameters.
    takes : callable, optional
        Whether it takes the parameter of a name; all by default.
    """

    def __init__(
        self,
        solver: Solver,
        fixed: Mapping[str, float] | None = None,
        takes: Callable[[str], bool] | None = None,
    ) -> None:
        self.solver = solver
        self.name = solver.name
        self.uses_folder = solver.uses_folder
        self._fixed = dict(fixed or {})
        self._takes = takes

    @property
    def response_names(self) -> tuple[str, ...] | None:
        """Names of the responses."""
        return self.solver.response_names

    def model(self) -> Mapping[str, Any]:
        """Return the model of the solver."""
        return self.solver.model()

    def run_parameters(self, parameters: Mapping[str, float]) -> dict[str, float]:
        """Return the parameters that the solver takes."""
        return self.solver.run_parameters(self._taken(parameters))

    @property
    def defaults(self) -> Mapping[str, float]:
        """Defaults of the solver."""
        return self.solver.defaults

    def run(
        self, parameters: Mapping[str, float], seed: int, workspace: Workspace
    ) -> dict[str, Response]:
        """Simulate once; see `Solver.run`."""
        return self.solver.run(self._taken(parameters), seed, workspace)

    def check(self) -> None:
        """Raise when no run could ever succeed."""
        self.solver.check()

    def version(self) -> str:
        """Version of the program behind it."""
        return self.solver.version()

    def executes(self) -> tuple[str, ...]:
        """Say what a run executes."""
        return self.solver.executes()

    def _taken(self, parameters: Mapping[str, float]) -> dict[str, float]:
        values = {**self._fixed, **parameters}
        takes = self._takes
        return {name: v for name, v in values.items() if takes is None or takes(name)}
