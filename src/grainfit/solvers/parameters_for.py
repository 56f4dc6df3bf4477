"""Pass to a solver only the parameters that it takes."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from typing_extensions import override

from grainfit.contact_models.registry import is_material_parameter
from grainfit.errors import Fault
from grainfit.evaluation import Measured
from grainfit.solvers.base import SeedUse, Solver, SourceRecord, Workspace
from grainfit.solvers.run_cost import RunCost

if TYPE_CHECKING:
    # Imports NumPy, which the state of a calibration does without.
    from grainfit.bulk_tests.base import BulkTest
    from grainfit.scenes.scene import Scene


@dataclass(frozen=True)
class AllBut:
    """Predicate of names: True for all but some. Other processes can be sent it.

    Parameters
    ----------
    names : frozenset of str
        The names for which it is False.
    """

    names: frozenset[str]

    def __call__(self, name: str) -> bool:
        """Return True if the name is none of these."""
        return name not in self.names


class ParametersFor(Solver):
    """Wrapper that passes to a solver only the parameters that it takes, and fixed values.

    Parameters
    ----------
    solver : Solver
        The wrapped solver.
    fixed : mapping of str to float, optional
        Values of parameters that are not free.
    takes : callable, optional
        Predicate: True for the names of parameters that the solver takes; by default all.
    depends_on_all : bool
        Whether runs depend on all parameters that the solver takes, also those that it does not
        mention.
    """

    def __init__(
        self,
        solver: Solver,
        fixed: Mapping[str, float] | None = None,
        takes: Callable[[str], bool] | None = None,
        *,
        depends_on_all: bool = False,
    ) -> None:
        self.solver = solver
        self.name = solver.name
        self.uses_folder = solver.uses_folder
        self.contact_models = solver.contact_models
        self._fixed = dict(fixed or {})
        self._takes = takes
        self._depends_on_all = depends_on_all

    @property
    @override
    def response_names(self) -> tuple[str, ...] | None:
        return self.solver.response_names

    @property
    @override
    def bulk_test(self) -> BulkTest | None:
        return self.solver.bulk_test

    @override
    def of_test(self, test: BulkTest) -> ParametersFor:
        return self._of(self.solver.of_test(test))

    @override
    def within(self, intervals: Mapping[str, tuple[float, float]]) -> ParametersFor:
        return self._of(self.solver.within(self._taken_intervals(intervals)))

    def _of(self, solver: Solver) -> ParametersFor:
        return ParametersFor(solver, self._fixed, self._takes, depends_on_all=self._depends_on_all)

    @property
    @override
    def absent(self) -> Mapping[str, str]:
        return self.solver.absent

    @property
    @override
    def walls(self) -> Mapping[str, str]:
        return self.solver.walls

    @override
    def model(self) -> Mapping[str, Any]:
        return self.solver.model()

    @override
    def run_parameters(self, parameters: Mapping[str, float]) -> dict[str, float]:
        return self.solver.run_parameters(self._taken(parameters))

    @override
    def depends_on(self, names: Sequence[str]) -> tuple[str, ...]:
        takes = self._takes
        taken = [name for name in names if takes is None or takes(name)]
        return tuple(taken) if self._depends_on_all else self.solver.depends_on(taken)

    @property
    @override
    def defaults(self) -> Mapping[str, float]:
        return self.solver.defaults

    @override
    def run(
        self, parameters: Mapping[str, float], seed: int, workspace: Workspace
    ) -> Mapping[str, Measured]:
        return self.solver.run(self._taken(parameters), seed, workspace)

    @override
    def record_of(self, parameters: Mapping[str, float], seed: int) -> SourceRecord | None:
        return self.solver.record_of(self._taken(parameters), seed)

    @property
    @override
    def seed_use(self) -> SeedUse:
        return self.solver.seed_use

    @override
    def raw_output(self, folder: Path) -> Sequence[Path]:
        return self.solver.raw_output(folder)

    @override
    def check(self) -> None:
        self.solver.check()

    @override
    def interval_faults(self, intervals: Mapping[str, tuple[float, float]]) -> list[Fault]:
        return self.solver.interval_faults(self._taken_intervals(intervals))

    @override
    def version(self) -> str:
        return self.solver.version()

    @override
    def executes(self) -> tuple[str, ...]:
        return self.solver.executes()

    @override
    def readiness(self) -> str:
        return self.solver.readiness()

    @override
    def experiment(self, parameters: Mapping[str, float], seed: int) -> Scene:
        return self.solver.experiment(self._taken(parameters), seed)

    @override
    def estimate_cost(self, parameters: Mapping[str, float]) -> RunCost | None:
        return self.solver.estimate_cost(self._taken(parameters))

    @override
    def estimate_cost_of(self, test: BulkTest, material: Mapping[str, float]) -> RunCost:
        return self.solver.estimate_cost_of(test, material)

    @override
    def default_timeout(self, parameters: Mapping[str, float]) -> float | None:
        return self.solver.default_timeout(self._taken(parameters))

    def _taken_intervals(
        self, intervals: Mapping[str, tuple[float, float]]
    ) -> dict[str, tuple[float, float]]:
        fixed = {name: (value, value) for name, value in self._fixed.items()}
        given = {**fixed, **intervals}
        takes = self._takes
        return {name: ends for name, ends in given.items() if takes is None or takes(name)}

    def _taken(self, parameters: Mapping[str, float]) -> dict[str, float]:
        values = {**self._fixed, **parameters}
        takes = self._takes
        return {name: v for name, v in values.items() if takes is None or takes(name)}


def of_material(solver: Solver, free: Iterable[str]) -> Solver:
    """Return a solver of bulk tests that is passed only the material parameters among free ones."""
    if all(is_material_parameter(name) for name in free):
        return solver
    return ParametersFor(solver, takes=is_material_parameter)
