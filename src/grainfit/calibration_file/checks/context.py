"""What checks see of a calibration file."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from grainfit.calibration_file.content import CalibrationFile
from grainfit.calibration_file.run_time import RunTime
from grainfit.calibration_file.twins import has_twin
from grainfit.problem import Problem
from grainfit.solvers.base import Solver
from grainfit.solvers.check_context import CheckContext


@dataclass(frozen=True)
class FileContext(CheckContext):
    """A calibration file before its first run, as checks see it; see `context_of`.

    Parameters
    ----------
    problem, solvers, fixed, test_keys, twins
        As of a `CheckContext`.
    file : CalibrationFile
        The file.
    costs : mapping of str to float
        Estimated wall time of a run by name of the test, s, where it is known.
    time : RunTime, optional
        Expected time of the calibration; None if it is not known.
    """

    file: CalibrationFile = field(kw_only=True)
    costs: Mapping[str, float] = field(default_factory=dict, kw_only=True)
    time: RunTime | None = field(default=None, kw_only=True)

    @property
    def contact_models(self) -> tuple[str, ...]:
        """Contact models that replace the usual ones of their kind."""
        return self.file.contact_models

    @property
    def dem_solvers(self) -> dict[str, str]:
        """Name of the solver of each bulk test."""
        return {
            test.name: test.options["solver"]
            for test in self.file.tests
            if test.name in self.bulk_tests
        }


def context_of(
    file: CalibrationFile,
    problem: Problem,
    solvers: Mapping[str, Solver],
    costs: Mapping[str, float] | None = None,
    time: RunTime | None = None,
) -> FileContext:
    """Return the context of the checks of a file; costs and time as of a `FileContext`."""
    keys = {test.name: f"test[{test.number}]" for test in file.tests}
    tests = {name: solver.bulk_test for name, solver in solvers.items()}
    twins = [name for name, test in tests.items() if has_twin(test, file.strategy.twins)]
    return FileContext(
        problem, solvers, file.fixed, keys, twins, file=file, costs=costs or {}, time=time
    )
