"""Build the problem and the solvers that a calibration file describes."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import ExitStack, suppress
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path
from typing import Any

from grainfit.bulk_tests.base import BulkTest
from grainfit.calibration.holdout import Holdout
from grainfit.calibration.options import CalibrationOptions
from grainfit.calibration.progress import Progress
from grainfit.calibration.provenance import Provenance
from grainfit.calibration.scopes import restricted, with_scopes
from grainfit.calibration.timeouts import default_timeouts
from grainfit.calibration_file import messages
from grainfit.calibration_file.checks.context import context_of
from grainfit.calibration_file.checks.registry import findings
from grainfit.calibration_file.content import CalibrationFile, SearchOptions, TestSpecification
from grainfit.calibration_file.fault_lines import faults_with_lines, with_lines
from grainfit.calibration_file.load import load_calibration_file
from grainfit.calibration_file.originals import hashes_of, keep_pictures
from grainfit.calibration_file.relatives import relative_solvers, relatives_of
from grainfit.calibration_file.settings import quantity_of, set_values
from grainfit.calibration_file.twins import twin_solvers
from grainfit.campaign.cluster.executor import cluster_executor, is_available
from grainfit.campaign.cluster.options import ClusterOptions
from grainfit.contact_models.registry import material_units
from grainfit.errors import Fault, InputError
from grainfit.evaluation import response_name
from grainfit.formatting import with_unit
from grainfit.materials.particle_shape import ASPECT_RATIO
from grainfit.materials.time_step import RAYLEIGH_NAMES, RayleighTimeStep
from grainfit.one_line import OneLine
from grainfit.options.fields import option_keys
from grainfit.options.kinds import Quantity
from grainfit.problem import Problem, Relative
from grainfit.result import Result
from grainfit.solvers.base import Solver
from grainfit.solvers.file_entry import FileEntry
from grainfit.solvers.registry import types_of_test
from grainfit.strategies.base import Strategy
from grainfit.strategies.registry import changed
from grainfit.verdict.options import VERDICT


@dataclass(frozen=True)
class CalibrationSetup(OneLine):
    """A calibration that is ready to run.

    Parameters
    ----------
    file : CalibrationFile
        The calibration file.
    problem : Problem
        Free parameters and targets; with several tests, targets are called ``test.response``.
    solvers : dict of str to Solver
        By name of the test. They take the values of the free parameters, and of fixed ones that
        replace those of the file.
    local : bool
        Run on this machine even when the file has a cluster.
    relatives : dict of str to Solver
        Solvers of cheaper relatives of the tests, by name of the test.
    twins : dict of str to Solver
        Solvers of smaller apparatus that are simulated instead, by name of the test.
    holdouts : tuple of Holdout
        Tests that take no part in the fit.
    """

    file: CalibrationFile
    problem: Problem
    solvers: dict[str, Solver]
    local: bool = False
    relatives: dict[str, Solver] = field(default_factory=dict)
    twins: dict[str, Solver] = field(default_factory=dict)
    holdouts: tuple[Holdout, ...] = ()

    @property
    def simulated(self) -> dict[str, Solver]:
        """Solvers of the search: of the twins, and of the tests without one."""
        return self.solvers | self.twins

    @property
    def name(self) -> str:
        """Name of the calibration, for people."""
        return self.file.name

    @property
    def strategy(self) -> SearchOptions:
        """Options of the search in the file."""
        return self.file.strategy

    @property
    def timeouts(self) -> dict[str, float]:
        """Longest wall time of a run by name of the test, s, where there is one.

        A bulk test has one even when the file gives none: a solver that hangs must not stop the
        calibration for ever.
        """
        return default_timeouts(self.problem, self.simulated) | self.file.timeouts

    @property
    def repeats(self) -> dict[str, int]:
        """Runs with different seeds whose mean is one evaluation, by name of the test."""
        return self.file.repeats

    @property
    def cluster(self) -> ClusterOptions | None:
        """Cluster jobs for the runs; None to run on this machine."""
        cluster = self.file.cluster
        if cluster is None or self.local or not is_available(cluster):
            return None
        return replace(cluster, cores_per_run=cluster.cores_per_run or self.file.ranks)

    @property
    def workers(self) -> int:
        """Runs at a time: as many as the jobs take, as the file says, or as there are cores for."""
        if self.cluster is not None:
            return self.cluster.workers
        if self.strategy.workers is not None:
            return self.strategy.workers
        return self.file.runs_at_once

    @property
    def provenance(self) -> Provenance:
        """The file and its fixed parameters, for a report."""
        text = ""
        with suppress(OSError):
            text = self.file.path.read_text(encoding="utf-8", errors="replace")
        fixed = self.file.fixed
        laboratory = {name: self.solvers[name].model()["test"] for name in self.twins}
        units = material_units(fixed)
        pictures = hashes_of(self.file.photographed)
        particles = {} if self.file.sizes is None else self.file.sizes.definition()
        options = {test.name: list(test.options) for test in self.file.tests}
        return Provenance(
            self.file.path.name,
            text,
            fixed,
            units,
            laboratory,
            pictures,
            particles,
            options,
            self.file.contact_models,
        )

    @property
    def missing_for_time_step(self) -> tuple[str, ...]:
        """Keys that the Rayleigh time step lacks; empty if it is known, or if the file has none."""
        known = {*self.file.fixed, *(parameter.name for parameter in self.file.parameters)}
        if self.problem.rayleigh is not None or known.isdisjoint(RAYLEIGH_NAMES):
            return ()
        size = () if self.file.sizes is not None else ("particle.diameter",)
        return (*(name for name in RAYLEIGH_NAMES if name not in known), *size)

    @property
    def relative_costs(self) -> list[Relative]:
        """The cheaper relatives of the tests, with their cost."""
        return relatives_of(self.solvers, self.relatives, self.problem)

    @property
    def bulk_tests(self) -> dict[str, BulkTest]:
        """The bulk tests that are simulated, by name of the test."""
        tests = {name: solver.bulk_test for name, solver in self.solvers.items()}
        return {name: test for name, test in tests.items() if test is not None}

    def notes(self) -> tuple[str, ...]:
        """Return what the checks of the calibration find, before any run.

        ``grainfit check`` shows them, and more that need the cost of a run.

        Examples
        --------
        >>> import grainfit as gf
        >>> for note in gf.load("beads.toml").notes():  # doctest: +SKIP
        ...     print(note)
        """
        context = context_of(self.file, self.problem, self.solvers)
        return tuple(finding.text for finding in findings(context))

    def calibrate(
        self,
        workdir: str | Path | None = None,
        *,
        strategy: str | Strategy | None = None,
        runs_from: str | Path | Sequence[str | Path] = (),
        store: str | None = None,
        retry_failed: bool = False,
        full_size: bool = False,
        on_progress: Callable[[Progress], None] | None = None,
        on_phase: Callable[[str], None] = lambda _: None,
        progress: bool = False,
        **given: Any,
    ) -> Result:
        """Calibrate as ``grainfit run`` does, with the file's time-outs and its cluster.

        Parameters
        ----------
        workdir : path, optional
            Where runs and results are kept; by default the file's name with ``.grainfit``, here.
        strategy : str or Strategy, optional
            Another strategy than the file's.
        runs_from, store, retry_failed, on_progress, progress
            See `grainfit.calibrate`.
        full_size : bool
            With `twins`: make one run of each real test at the answer, and judge it by them.
        on_phase : callable, optional
            With `twins`: called with a sentence at the beginning of each phase.
        **given : object
            Options that replace those of the file, such as ``max_runs``, ``workers`` or ``seed``.

        Returns
        -------
        Result
            Also after Ctrl-C, with status ``interrupted``.

        Raises
        ------
        InputError, SolverNotFoundError, RunFailedError, StoreError
            See `grainfit.calibrate`.

        Examples
        --------
        >>> import grainfit as gf
        >>> gf.load("beads.toml").calibrate(progress=True)  # doctest: +SKIP
        """
        # Imported here: `check` runs nothing, and needs no store.
        from grainfit.calibration.calibrate import calibrate
        from grainfit.calibration_file.real_size import RealSizeCalibration, RealSizeOptions
        from grainfit.campaign.work_folder import default_workdir

        folder = Path(workdir) if workdir is not None else default_workdir(self.file.path)
        named = strategy if isinstance(strategy, str) else None
        options = self.options(named, **given)
        if isinstance(strategy, Strategy):
            options["strategy"] = strategy
        if self.file.photographs:
            keep_pictures(self.file.photographed, folder, self.file.path.parent)
        with ExitStack() as stack:
            if self.cluster is not None:
                options["executor"] = stack.enter_context(cluster_executor(self.cluster, folder))
            search = partial(
                calibrate,
                replace(self.problem, relatives=self.relative_costs),
                self.simulated,
                relatives=self.relatives,
                workdir=folder,
                name=self.name,
                timeouts=self.timeouts,
                repeats=self.repeats,
                runs_from=runs_from,
                store=store,
                retry_failed=retry_failed,
                provenance=self.provenance,
                holdouts=self.holdouts,
                on_progress=on_progress,
                progress=progress,
                **options,
            )
            if not self.twins:
                if self.strategy.twins is not None:
                    on_phase(messages.ALL_SMALL(twins=self.strategy.twins))
                return search()
            real = RealSizeOptions(
                getattr(options["strategy"], "confidence", VERDICT.confidence),
                options["workers"],
                self.file.timeouts,
                options.get("executor"),
                full_size,
                on_phase,
            )
            tests = self.solvers, self.twins
            return RealSizeCalibration(
                self.problem, *tests, folder, lambda twins: search(twins=twins), real
            ).run()

    def options(self, strategy: str | None = None, **given: Any) -> dict[str, Any]:
        """Return the arguments of `grainfit.calibrate` for the search; what is given here wins.

        Parameters
        ----------
        strategy : str, optional
            Another strategy, which takes the options of the file.
        **given : object
            Options of the calibration and of the strategy; None leaves what the file says.

        Raises
        ------
        InputError
            The strategy is not known, or does not have or accept an option.
        """
        given = _without_none(given)
        names = [known.name for known in option_keys(CalibrationOptions)]
        in_file = {name: getattr(self.strategy, name) for name in names}
        own = {key: value for key, value in given.items() if key not in names}
        return {
            "strategy": changed(self.strategy.strategy, strategy, own),
            **_without_none(in_file | {"workers": self.workers}),
            **{key: value for key, value in given.items() if key in names},
        }

    def values(
        self, settings: Iterable[str], others: Mapping[str, float] | None = None
    ) -> dict[str, float]:
        """Return the values of all free parameters, and of fixed ones that are set.

        Parameters
        ----------
        settings : iterable of str
            ``NAME=VALUE``; a value may have a unit.
        others : mapping of str to float, optional
            Values of parameters that are not set; by default free ones take the middle of their
            interval.

        Raises
        ------
        InputError
            A setting has another form, names no parameter of the file, or is no possible value.
        """
        return set_values(self.file, settings, others)

    def outside(self, settings: Iterable[str]) -> list[str]:
        """Return a note on each value that is set outside of the interval of its parameter.

        Parameters
        ----------
        settings : iterable of str
            As of `values`.
        """
        values = self.values(settings)
        return [
            f"{p.name} = {with_unit(f'{values[p.name]:g}', p.unit)} is outside of its interval, "
            f"{p.minimum:g} to {with_unit(f'{p.maximum:g}', p.unit)}."
            for p in self.file.parameters
            if not p.contains(values[p.name])
        ]

    def quantity(self, name: str) -> Quantity:
        """Return the unit and the physical limits of a parameter."""
        return quantity_of(self.file, name)


def load_calibration(path: str | Path, work_folder: str | Path | None = None) -> CalibrationSetup:
    """Read a calibration file and make it ready to run; nothing is executed.

    Parameters
    ----------
    path : path
        The calibration file.
    work_folder : path, optional
        Where what is measured on photographs is kept; the default work folder if not given.

    Raises
    ------
    InputError
        With every fault of the file, its key and its line.

    Examples
    --------
    >>> import grainfit as gf
    >>> setup = gf.load("beads.toml")  # doctest: +SKIP
    >>> setup.problem.intervals  # doctest: +SKIP
    {'particle.density': (1400.0, 2800.0)}
    """
    kept = None if work_folder is None else Path(work_folder)
    return build_calibration(load_calibration_file(Path(path), work_folder=kept))


def build_calibration(file: CalibrationFile) -> CalibrationSetup:
    """Build the problem and one solver for each test; nothing is executed.

    Parameters
    ----------
    file : CalibrationFile
        As returned by `grainfit.calibration_file.load_calibration_file`.

    Raises
    ------
    InputError
        A test cannot be simulated; lists all faults of all tests.
    """
    with with_lines(file.path):
        solvers = build_solvers(file)
        problem = with_scopes(_problem(file), solvers, file.repeats)
        relatives = relative_solvers(file, build_solvers, problem)
        solvers = restricted(problem, solvers)
        twins = twin_solvers(file, solvers, problem)
        if twins and file.holdouts:
            raise InputError(messages.TWINS_AND_HOLDOUTS.fault("strategy.twins"))
        return CalibrationSetup(
            file,
            problem,
            solvers,
            relatives=relatives,
            twins=twins,
            holdouts=build_holdouts(file),
        )


def build_solvers(file: CalibrationFile) -> dict[str, Solver]:
    """Build one solver for each test, by name of the test; nothing is executed.

    Raises
    ------
    InputError
        A test cannot be simulated; lists all faults of all tests.
    """
    return _solvers_of(file, file.tests, "test")


def _solvers_of(
    file: CalibrationFile, tests: Iterable[TestSpecification], section: str
) -> dict[str, Solver]:
    solvers: dict[str, Solver] = {}
    faults: list[Fault] = []
    for test in tests:
        try:
            solvers[test.name] = types_of_test()[test.type].make_solver(_entry(file, test))
        except InputError as error:
            faults += _faults_of_test(f"{section}[{test.number}]", error)
    if faults:
        raise InputError(faults_with_lines(file.path, faults), str(file.path))
    return solvers


def build_holdouts(
    file: CalibrationFile, tests: Sequence[TestSpecification] | None = None
) -> tuple[Holdout, ...]:
    """Build the hold-outs of a file; nothing is executed.

    Parameters
    ----------
    file : CalibrationFile
        The file.
    tests : sequence of TestSpecification, optional
        Other tests of the file, in place of its hold-outs.

    Raises
    ------
    InputError
        A test cannot be simulated; lists all faults.
    """
    chosen = file.holdouts if tests is None else tests
    solvers = _solvers_of(file, chosen, "holdout" if tests is None else "test")
    return tuple(
        Holdout(
            test.name,
            solvers[test.name],
            test.targets,
            test.repeats,
            test.options.get("timeout"),
            test.curves,
        )
        for test in chosen
    )


def _problem(file: CalibrationFile) -> Problem:
    def named(test: TestSpecification, response: str) -> str:
        return response_name(test.name, response, len(file.tests))

    targets = [
        replace(target, name=named(test, target.name))
        for test in file.tests
        for target in test.targets
    ]
    curves = [
        replace(curve, name=named(test, curve.name)) for test in file.tests for curve in test.curves
    ]
    return Problem(
        file.parameters,
        targets,
        _rayleigh(file),
        rayleigh_weight=file.strategy.rayleigh_weight or 0,
        correlations=[
            (named(test, first), named(test, second), coefficient)
            for test in file.tests
            for first, second, coefficient in test.correlations
        ],
        curves=curves,
    )


def _rayleigh(file: CalibrationFile) -> RayleighTimeStep | None:
    known = {*file.fixed, *(parameter.name for parameter in file.parameters)}
    if file.sizes is None or not known.issuperset(RAYLEIGH_NAMES):
        return None
    fixed = {name: file.fixed[name] for name in RAYLEIGH_NAMES if name in file.fixed}
    shape = file.sizes.shape
    is_free = any(parameter.name == ASPECT_RATIO for parameter in file.parameters)
    if is_free and shape is not None and shape.has_aspect_ratio:
        return RayleighTimeStep(min(file.sizes.diameters) / 2, fixed, shape.family)
    sizes = file.sizes.with_aspect_ratio(file.fixed.get(ASPECT_RATIO))
    return RayleighTimeStep(sizes.rayleigh_radius, fixed)


def _entry(file: CalibrationFile, test: TestSpecification) -> FileEntry:
    return FileEntry(
        test.options,
        test.responses,
        {parameter.name: (parameter.minimum, parameter.maximum) for parameter in file.parameters},
        file.fixed,
        file.sizes,
        file.contact_models,
        {one.name: one.unit for one in file.parameters}
        | {one.name: one.unit for one in test.targets},
    )


def _faults_of_test(test: str, error: InputError) -> list[Fault]:
    """Add the test to the faults of its solver, which knows only its own arguments."""
    if error.source:
        return [Fault(test, f"{error.source}: {fault}") for fault in error.faults]
    return [replace(fault, key=f"{test}.{fault.key}") for fault in error.faults]


def _without_none(values: Mapping[str, Any]) -> dict[str, Any]:
    return {key: value for key, value in values.items() if value is not None}
