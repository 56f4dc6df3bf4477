"""Analyse runs without a calibration: what a table, or an earlier work folder, says."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from grainfit.analysis.analysis import Analysis, analyse
from grainfit.analysis.posterior import Posterior
from grainfit.analysis.soft_particles import known_biases, of_hertz
from grainfit.calibration_file.build import CalibrationSetup, load_calibration
from grainfit.campaign.repeats import seeds_of
from grainfit.campaign.reuse import runs_of
from grainfit.campaign.store.source import open_source
from grainfit.errors import InputError
from grainfit.evaluation import Evaluation, Proposal, response_name
from grainfit.formatting import counted, in_unit, number, plain_ends, plain_interval
from grainfit.metamodels.curve_reduction import ComponentTarget
from grainfit.one_line import OneLine
from grainfit.problem import Parameter, Problem, Target
from grainfit.tables import TextTable, as_html, as_text
from grainfit.work_folder import messages
from grainfit.work_folder.import_table import read_import_table
from grainfit.work_folder.run_columns import COMMON_COLUMNS

#: Deviation of an expected response in standard deviations from which nothing agrees with it.
_DISAGREES = 3.0


@dataclass(frozen=True)
class RunsAnalysis(OneLine):
    """Analysis of runs, in words.

    Parameters
    ----------
    problem : Problem
        Free parameters and targets.
    analysis : Analysis
        Posterior, intervals, sensitivities, and more.
    runs : int
        Number of runs.
    ignored : tuple of str
        Columns of tables that are not used, and what was given a second time.
    """

    problem: Problem
    analysis: Analysis
    runs: int
    ignored: tuple[str, ...] = ()

    @property
    def disagreement(self) -> str:
        """Reason why the intervals mean little: no parameter set agrees; "" where some do."""
        metamodels, posterior = self.analysis.metamodels, self.analysis.posterior
        if metamodels is None or posterior is None:
            return ""
        means, variances = metamodels.predict(posterior.points)
        targets = metamodels.problem.targets
        if not targets:
            return ""
        squares = np.array([target.standard_uncertainty**2 for target in targets])
        off = np.abs(means - [target.value for target in targets]) / np.sqrt(squares + variances)
        best = int(off.max(axis=1).argmin())
        worst = int(off[best].argmax())
        if off[best, worst] <= _DISAGREES:
            return ""
        target = targets[worst]
        found = f"is {number(float(means[best, worst]))} instead of {number(target.value)}, "
        name = target.name
        if isinstance(target, ComponentTarget):
            # Its values are distances from the mean curve of the runs, which nobody knows.
            name, found = f"{metamodels.reduction.parts[name]},", "is "
        return (
            f"No parameter set within the intervals agrees with the measurements: where all are "
            f"closest, {name} {found}{number(float(off[best, worst]), 2)} standard "
            "deviations away. The intervals below are those of the least bad parameter sets."
        )

    def summary(self) -> tuple[str | TextTable, ...]:
        """Return the tables and sentences that `print` and a notebook show."""
        found = self.analysis
        headline = f"{counted(self.runs, 'run')}, nothing was simulated."
        tables = () if found.posterior is None else self._tables(found.posterior)
        sensitivity = found.sensitivity.in_words() if found.sensitivity else ()
        known = found.identifiability
        verdicts = (*known.verdicts, *known.further_tests) if known else ()
        warnings = (
            f"Metamodel of {quality.part or name}: {warning}"
            for name, quality in found.quality.items()
            for warning in quality.warnings
        )
        ignored = (f"Not used: {', '.join(self.ignored)}.",) if self.ignored else ()
        about = filter(None, (self.disagreement,))
        return (
            headline,
            *about,
            *tables,
            *verdicts,
            *sensitivity,
            *warnings,
            *found.notes,
            *ignored,
        )

    def __str__(self) -> str:
        return as_text(self.summary())

    def _repr_html_(self) -> str:
        return as_html(self.summary())

    def _tables(self, posterior: Posterior) -> Iterator[TextTable]:
        yield TextTable(
            ("parameter", "median", "95 % interval", ""),
            tuple(self._parameter_row(posterior, p) for p in self.problem.parameters),
        )
        metamodels = self.analysis.metamodels
        targets = () if metamodels is None else metamodels.problem.targets
        rows = tuple(
            _response_row(target, posterior.responses[:, i])
            for i, target in enumerate(targets)
            if not isinstance(target, ComponentTarget)
        )
        if not rows:
            return
        yield TextTable(
            ("response", "measured", "expected"),
            rows,
            "± standard uncertainty of the measured value, 95 % interval of the expected response",
        )

    def _parameter_row(self, posterior: Posterior, parameter: Parameter) -> tuple[str, ...]:
        found = self.analysis.intervals[parameter.name]
        return (
            in_unit(parameter.name, parameter.unit),
            f"{posterior.median(parameter.name):.4g}",
            plain_ends(found.low, found.high),
            found.determination,
        )


def _response_row(target: Target, expected: np.ndarray) -> tuple[str, ...]:
    low, high = np.quantile(expected, [0.025, 0.975])
    measured = plain_interval(target.value, target.standard_uncertainty)
    return in_unit(target.name, target.unit), measured, plain_ends(float(low), float(high))


def analyse_runs(
    source: str | Path | CalibrationSetup,
    runs: str | Path | Sequence[str | Path],
    *,
    seed: int = 1,
) -> RunsAnalysis:
    """Analyse the runs of tables or work folders; nothing is simulated.

    Parameters
    ----------
    source : path or CalibrationSetup
        The calibration file: free parameters with their intervals, and targets.
    runs : path or sequence of path
        Tables of runs (CSV), as ``grainfit runs import`` reads them: a column for each free
        parameter that a test depends on and each of its targets, perhaps ``seed`` and standard
        errors. With several tests a table is given as ``TEST=TABLE.csv``; its column ``test``, if
        it has one, tells the runs apart. A folder is a work folder, whose runs of the same tests
        are used. What is given twice counts once.
    seed : int
        The same seed gives the same analysis.

    Returns
    -------
    RunsAnalysis
        `print` shows it; ``.analysis`` has posterior, intervals and sensitivities.

    Raises
    ------
    InputError
        With every fault of the file or of a table, or because there are no runs.
    StoreError
        A work folder cannot be read.

    Examples
    --------
    >>> import grainfit as gf
    >>> print(gf.analyse_runs("beads.toml", "runs.csv"))  # doctest: +SKIP
    """
    setup = source if isinstance(source, CalibrationSetup) else load_calibration(source)
    given = [runs] if isinstance(runs, str | Path) else list(runs)
    if not given:
        raise InputError(messages.NO_TABLES.fault("runs"))
    known = _Runs(setup)
    ignored: list[str] = []
    seen: set[tuple[str, Path]] = set()
    for name in given:
        is_store = Path(name).is_dir() or "://" in str(name)
        test, path = ("", Path(name)) if is_store else _test_of(setup, str(name))
        if (test, path.resolve()) in seen:
            ignored.append(f"{name} a second time")
            continue
        seen.add((test, path.resolve()))
        if is_store:
            with open_source(name, "runs") as store:
                found = runs_of(setup.problem, setup.solvers, store.runs(), setup.repeats)
            repeated = sum(not known.add(evaluation) for evaluation in found)
        else:
            rows, unused = _of_table(setup, test, path)
            repeated = sum(not known.add(*row) for row in rows)
            ignored += [column for column in unused if column not in ignored]
        if repeated:
            ignored.append(f"{counted(repeated, 'run')} of {name} a second time")
    evaluations = known.evaluations
    if not evaluations:
        names = ", ".join(map(str, given))
        raise InputError(messages.NO_RUN_OF_THE_FILE.fault("runs", names=names))
    tests = of_hertz(setup.bulk_tests, setup.file.contact_models)
    biases = known_biases(setup.problem, tests, setup.file.fixed)
    analysis = analyse(setup.problem, evaluations, seed=seed, biases=biases)
    return RunsAnalysis(setup.problem, analysis, len(evaluations), tuple(ignored))


@dataclass
class _Runs:
    """Evaluations of a calibration file, each run of a test once."""

    setup: CalibrationSetup
    evaluations: list[Evaluation] = field(default_factory=list)
    _seen: set[tuple[object, ...]] = field(default_factory=set)

    def add(self, evaluation: Evaluation, table: str = "") -> bool:
        """Add the runs that are not there yet; return whether there are any.

        A run is known again by its parameters and its seed. Lines without a seed, of the
        ``table``, are runs of their own.
        """
        tests = evaluation.proposal.tests or tuple(self.setup.solvers)
        keys = {test: self._keys(evaluation, test, table) for test in tests}
        repeated = [test for test in tests if keys[test] <= self._seen]
        self._seen.update(*keys.values())
        if len(repeated) < len(tests):
            self.evaluations.append(evaluation.without(repeated) if repeated else evaluation)
        return len(repeated) < len(tests)

    def _keys(self, evaluation: Evaluation, test: str, table: str) -> set[tuple[object, ...]]:
        proposal, problem = evaluation.proposal, self.setup.problem
        scopes = {scope.name: scope.parameters for scope in problem.tests}
        values = [proposal.parameters[name] for name in scopes.get(test, proposal.parameters)]
        count = self.setup.repeats.get(test, 1) if evaluation.runs else 1
        return {(table, test, *values, seed) for seed in seeds_of(proposal.seed, count)}


def _of_table(
    setup: CalibrationSetup, test: str, path: Path
) -> tuple[list[tuple[Evaluation, str]], list[str]]:
    """Return the evaluations, those without a seed with their table, and unused columns."""
    specification = next(one for one in setup.file.tests if one.name == test)
    table = read_import_table(path, setup, specification)
    count = len(setup.file.tests)
    tests = (test,) if count > 1 else None
    evaluations = [
        (
            Evaluation(
                # Parameters that the test does not depend on have the middle of their interval.
                Proposal(
                    setup.problem.middle | dict(row.parameters),
                    number if row.seed is None else row.seed,
                    "design",
                    tests,
                ),
                {response_name(test, name, count): r for name, r in row.responses.items()},
            ),
            str(path.resolve()) if row.seed is None else "",
        )
        for number, row in enumerate(table.rows, start=1)
    ]
    ignored = table.ignored
    if tests:
        # Another test may use a column of the same name.
        ignored = [c if c in COMMON_COLUMNS else f"{c} ({test}={path})" for c in ignored]
    return evaluations, ignored


def _test_of(setup: CalibrationSetup, given: str) -> tuple[str, Path]:
    tests = [test.name for test in setup.file.tests]
    name, separator, path = given.partition("=")
    if separator and name in tests:
        return name, Path(path)
    if len(tests) == 1:
        return tests[0], Path(given)
    raise InputError(messages.WHICH_TEST.fault("runs", given=given, tests=", ".join(tests)))
