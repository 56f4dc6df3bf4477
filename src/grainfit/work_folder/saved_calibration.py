"""The calibration in a work folder, read from outside while it may be running."""

from __future__ import annotations

import shlex
from collections.abc import Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from functools import cached_property, partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, get_args

from grainfit.bulk_tests.base import BulkTest
from grainfit.bulk_tests.registry import recreate_test
from grainfit.calibration.provenance import Provenance
from grainfit.campaign.absent_responses import failed_if_incomplete
from grainfit.campaign.campaign import evaluation_of
from grainfit.campaign.store.records import CalibrationRecord, RequestRecord, RunRecord
from grainfit.campaign.work_folder import RESULT_NAME
from grainfit.contact_models.registry import material_parameter
from grainfit.errors import Fault, InputError, StoreError
from grainfit.evaluation import ERROR_SUFFIX, Evaluation, names_of_tests, response_name
from grainfit.formatting import counted
from grainfit.materials.sizes import ParticleSizes
from grainfit.materials.time_step import RayleighTimeStep
from grainfit.problem import CurveTarget, Parameter, Problem, Target, TestScope
from grainfit.relative_names import is_relative
from grainfit.result import ParameterInterval, Result, YieldLocusResult, damaged_result
from grainfit.strategies.distinct_runs import distinct_runs
from grainfit.tables import TextTable, as_html, as_text
from grainfit.verdict.rule import Status
from grainfit.work_folder import messages
from grainfit.work_folder.open_folder import OpenFolder, open_folder
from grainfit.work_folder.run_table import runs_table

if TYPE_CHECKING:
    import pandas as pd

    from grainfit.analysis.analysis import Analysis


@dataclass(frozen=True, repr=False)
class SavedCalibration:
    """The calibration that was started last in a work folder.

    Parameters
    ----------
    folder : Path
        The work folder.
    name, identity : str
        Its name, and its identity.
    state : str
        ``running``, or how it ended; ``interrupted`` also when its process died.
    problem : Problem
        Parameters and targets; the intervals include all proposals, also where a bound was moved.
    strategy, seed : str, int
        Name of the strategy, and its seed.
    evaluations : tuple of Evaluation
        Every parameter set of which all runs have ended, in the order in which it was asked for.
    warm_start : tuple of Evaluation
        Evaluations from other calibrations, used for a warm start.
    running : int
        Runs under way.
    records : mapping of str to RunRecord
        Runs of the evaluations, by identity.
    result : Result, optional
        Content of result.json; None while it runs.
    result_fault : str
        Reason why the result cannot be used; empty if it can.
    fixed : mapping of str to float
        Parameters that are not free, SI, as far as they are known.
    units : mapping of str to str
        SI units of free and fixed parameters.
    source, source_text : str
        Name of the calibration file and its text; empty when started from Python.
    version : str
        Version of grainfit that started it.
    workers : int
        Runs at a time.
    started : float
        When it was started last, seconds since the epoch.
    max_runs : int, optional
        Largest number of DEM runs, where there was a limit.
    failure : str
        Reason why it stopped, if it failed.
    strategy_options : mapping
        Options of the strategy that determine its runs.
    laboratory : mapping of str to mapping
        Definitions of the tests of which a smaller apparatus is simulated, by name.
    sizes : ParticleSizes, optional
        Of the calibration file; None where it has none, or is not known.
    options : mapping of str to sequence of str
        Options of the tests that the calibration file gives, as far as that is known.
    contact_models : tuple of str
        Contact models that replace the usual ones, the same in all tests.
    in_holdouts : bool
        Whether its hold-outs are simulated: it has its verdict, and its process is at work.
    """

    folder: Path
    name: str
    identity: str
    state: str
    problem: Problem
    strategy: str
    seed: int
    evaluations: tuple[Evaluation, ...]
    warm_start: tuple[Evaluation, ...]
    running: int
    records: Mapping[str, RunRecord]
    result: Result | None
    result_fault: str
    fixed: Mapping[str, float]
    units: Mapping[str, str]
    source: str
    source_text: str
    version: str
    workers: int
    started: float
    max_runs: int | None = None
    failure: str = ""
    strategy_options: Mapping[str, Any] = field(default_factory=dict)
    laboratory: Mapping[str, Mapping[str, Any]] = field(default_factory=dict)
    sizes: ParticleSizes | None = None
    options: Mapping[str, Sequence[str]] = field(default_factory=dict)
    contact_models: tuple[str, ...] = ()
    in_holdouts: bool = False

    @classmethod
    def of(cls, source: str | Path | SavedCalibration) -> SavedCalibration:
        """Return a calibration that was read already, or that of a work folder, as of `open`."""
        return source if isinstance(source, SavedCalibration) else cls.open(source)

    @classmethod
    def open(cls, folder: str | Path) -> SavedCalibration:
        """Read a work folder once, without changing it or disturbing a running calibration.

        Parameters
        ----------
        folder : path
            The work folder, also of a calibration that is running.

        Raises
        ------
        StoreError
            The folder is not a work folder, its store cannot be read, or nothing was ever
            calibrated in it.
        """
        folder = Path(folder)
        with open_folder(folder) as opened:
            calibration = opened.calibration
            if calibration is None:
                raise StoreError(messages.NOTHING_CALIBRATED(folder=str(folder)))
            warm_start = opened.warm_start_requests()
            records = opened.records_of([*opened.requests, *warm_start])
        with opened.naming():
            return _saved(opened, calibration, warm_start, records)

    def runs(self) -> pd.DataFrame:
        """Return the runs that this calibration asked for and that have ended, one row for each.

        Returns
        -------
        pandas.DataFrame
            See `grainfit.work_folder.run_table.runs_table`; ``attrs["units"]`` has the units of the
            problem too.

        Raises
        ------
        InputError
            pandas is not installed.
        """
        table = runs_table(self.records.values())
        units = {name: self.units[name] for name in table.columns if name in self.units}
        targets = {target.name: target.unit for target in self.problem.targets if target.unit}
        tests = table["test"].unique()
        for name in table.attrs["responses"]:
            found = {targets.get(response_name(test, name, len(tests))) for test in tests} - {None}
            if len(found) == 1:
                units |= dict.fromkeys((name, f"{name}{ERROR_SUFFIX}"), found.pop())
        table.attrs["units"] = {**units, **table.attrs["units"]}
        return table

    @property
    def why_nothing_agrees(self) -> str:
        """Reason why no parameter set agrees with the measurements; "" where some may."""
        if self.state == "unreachable":
            return "No parameter set within the intervals agrees with the measurements."
        return ""

    @property
    def known(self) -> tuple[Evaluation, ...]:
        """The evaluations, then those of the warm start that were not asked for again."""
        return tuple(distinct_runs([*self.evaluations, *self.warm_start]))

    @property
    def intervals(self) -> Mapping[str, ParameterInterval]:
        """95 % intervals of the parameters: those of the result, else those of the analysis."""
        if self.why_nothing_agrees:
            return {}
        if self.result is not None and self.result.intervals:
            return self.result.intervals
        return self.analyse_parameters().intervals

    @cached_property
    def yield_loci(self) -> tuple[YieldLocusResult, ...]:
        """Yield loci of the shear tests, as far as these have runs."""
        # Imported here: SciPy takes a second, and exports do without it.
        from grainfit.calibration.yield_loci import tests_of_runs, yield_loci

        tests = tests_of_runs(self.evaluations, lambda _: self.records)
        return yield_loci(self.problem, tests, self.result.responses if self.result else {})

    def analyse(self) -> Analysis:
        """Return the analysis of the runs: posterior, sensitivity, and more.

        The same analysis as in the report and on the material card; it takes seconds and is made
        once for each object.
        """
        return self._analysis

    def analyse_parameters(self) -> Analysis:
        """Return the part of `analyse` that tells the parameters, in a fraction of its time.

        It has metamodels, their quality, posterior, intervals and notes.
        """
        whole: Analysis | None = vars(self).get("_analysis")
        return whole or self._parameters_analysed

    def summary(self) -> tuple[str | TextTable, ...]:
        """Return the sentences and tables that `print` and a notebook show."""
        failed = sum(len(evaluation.failed_runs) for evaluation in self.evaluations)
        runs = sum(len(evaluation.runs) for evaluation in self.evaluations)
        progress = (
            f"{counted(runs, 'run')} ended, {failed} of them failed; {self.running} under way. "
            f"Work folder: {self.folder}"
        )
        faults = (f"Stopped by: {self.failure}" if self.failure else "", self.result_fault)
        answer = self.result.summary()[1:] if self.result else ()
        headline = f"{self.name or self.folder.name}: {self.state}"
        return (headline, progress, *filter(None, faults), *answer)

    def __repr__(self) -> str:
        count = counted(len(self.evaluations), "evaluation")
        return f"<SavedCalibration {self.name!r}: {self.state}, {count}, in {str(self.folder)!r}>"

    def __str__(self) -> str:
        return as_text(self.summary())

    def _repr_html_(self) -> str:
        return as_html(self.summary())

    @cached_property
    def _analysis(self) -> Analysis:
        # Imported here: SciPy and emcee take a second, and status and exports need neither.
        from grainfit.analysis.analysis import analyse

        return analyse(self.problem, self.known, **self._asked_of_analysis)

    @cached_property
    def _parameters_analysed(self) -> Analysis:
        from grainfit.analysis.analysis import analyse_parameters

        return analyse_parameters(self.problem, self.known, **self._asked_of_analysis)

    @property
    def _asked_of_analysis(self) -> dict[str, Any]:
        from grainfit.analysis.soft_particles import known_biases, of_hertz

        answer = (self.result.parameters if self.result else None) or None
        tests = of_hertz(bulk_tests_of(self), self.contact_models)
        biases = known_biases(self.problem, tests, self.fixed, answer)
        return {"seed": self.seed, "answer": answer, "biases": biases}


def bulk_tests_of(saved: SavedCalibration) -> dict[str, BulkTest]:
    """Return the bulk tests of the laboratory, by name of the test, as far as they are known."""
    return _recreated(saved, saved.laboratory)


def twins_of(saved: SavedCalibration) -> dict[str, BulkTest]:
    """Return the tests in a smaller apparatus that were simulated instead, by name of the test."""
    return {n: test for n, test in _recreated(saved, {}).items() if n in saved.laboratory}


def _recreated(
    saved: SavedCalibration, instead: Mapping[str, Mapping[str, Any]]
) -> dict[str, BulkTest]:
    """Return the bulk tests of the runs, or of the definitions that stand instead of them."""
    tests = {}
    for record in saved.records.values():
        if record.test not in tests and not is_relative(record.test):
            known = record.definition
            if record.test in instead:
                known = replace(known, model={**known.model, "test": instead[record.test]})
            with suppress(InputError):
                tests[record.test] = recreate_test(known)
    return {name: test for name, test in tests.items() if test is not None}


def _contact_models(runs: Iterable[RunRecord], of_file: tuple[str, ...]) -> tuple[str, ...]:
    """Return the contact models of the bulk tests; without any, those of the calibration file."""
    models = [run.definition.model for run in runs if "test" in run.definition.model]
    if not models:
        return of_file
    return tuple(dict.fromkeys(name for m in models for name in m.get("contact_models", ())))


def _saved(
    opened: OpenFolder,
    calibration: CalibrationRecord,
    warm_start: Sequence[RequestRecord],
    records: Mapping[str, RunRecord],
) -> SavedCalibration:
    folder, state = opened.folder, opened.state
    definition, about = calibration.definition, calibration.about
    names = [parameter["name"] for parameter in definition["parameters"]]
    for request in (*opened.requests, *warm_start):
        tests_and_relatives = [*definition["tests"], *definition.get("relatives", {})]
        request.require_part_of(names, names_of_tests(tests_and_relatives))
    records = failed_if_incomplete(records, (*opened.requests, *warm_start), definition)
    ended = [request for request in opened.requests if _has_ended(request, records)]
    tests = len(names_of_tests(definition["tests"]))
    ratios = definition.get("ratios", {})
    evaluations = tuple(_evaluation(request, records, tests, ratios) for request in ended)
    used = {run for request in ended for run in request.runs.values()}
    problem = _problem(definition, about, evaluations)
    provenance = Provenance.from_json(about.get("provenance", {}))
    result, fault = opened.read_result()
    if result is not None and (why := _why_unusable(result, problem, state)):
        result, fault = None, damaged_result(folder / RESULT_NAME, why)
    free = {parameter.name: parameter.unit for parameter in problem.parameters}
    fixed = {**_material(records.values(), free), **provenance.fixed}
    declared = {name: material_parameter(name) for name in {**fixed, **free}}
    known = {name: found.unit for name, found in declared.items() if found is not None}
    return SavedCalibration(
        folder=folder,
        name=calibration.name,
        identity=calibration.identity,
        state=state,
        problem=problem,
        strategy=str(definition["strategy"]),
        seed=int(definition["seed"]),
        evaluations=evaluations,
        warm_start=tuple(
            _evaluation(run, records, tests, ratios)
            for run in warm_start
            if _has_ended(run, records)
        ),
        running=opened.running(record.status for record in records.values()),
        records={identity: record for identity, record in records.items() if identity in used},
        result=result,
        result_fault=fault,
        fixed=fixed,
        units={n: u for n, u in {**known, **provenance.units, **free}.items() if n in declared},
        source=provenance.file,
        source_text=provenance.text,
        version=str(about.get("version", "")),
        workers=opened.workers,
        started=calibration.started,
        max_runs=about.get("max_runs"),
        failure=opened.failure,
        strategy_options=dict(definition.get("options", {})),
        laboratory=provenance.laboratory,
        sizes=provenance.sizes,
        options=provenance.options,
        contact_models=_contact_models(records.values(), provenance.contact_models),
        in_holdouts=opened.holdouts is not None,
    )


def _why_unusable(result: Result, problem: Problem, state: str) -> str:
    """Return why a result is not that of this calibration; "" when it is."""
    if state in get_args(Status) and state not in ("interrupted", result.status):
        # The result of the last start could not be written.
        return f"it says {result.status!r} of a calibration that has ended as {state!r}"
    if not (result.parameters or result.responses or result.curves):
        return ""
    targets = {target.name: target.value for target in problem.targets}
    fits = (
        result.parameters.keys() == {parameter.name for parameter in problem.parameters}
        and {name: found.target for name, found in result.responses.items()} == targets
        and result.curves.keys() == {curve.name for curve in problem.curves}
        and all(p.scale != "log" or result.parameters[p.name] > 0 for p in problem.parameters)
        and all(map(partial(_holds_its_answer, result), result.intervals))
    )
    return "" if fits else "its parameters or targets are not those of the calibration"


def _holds_its_answer(result: Result, name: str) -> bool:
    found = result.intervals[name]
    return name in result.parameters and found.low <= result.parameters[name] <= found.high


def _problem(
    definition: Mapping[str, Any], about: Mapping[str, Any], evaluations: Sequence[Evaluation]
) -> Problem:
    targets = [Target(**data) for data in definition["targets"]]
    names = {target.name for target in targets}
    # Older versions kept it beside the definition.
    rayleigh = definition.get("rayleigh") or about.get("rayleigh")
    problem = Problem(
        [Parameter(**data) for data in definition["parameters"]],
        targets,
        RayleighTimeStep(**rayleigh) if rayleigh else None,
        float(definition.get("rayleigh_weight") or about.get("rayleigh_weight", 0.0)),
        correlations=definition.get("correlations", ()),
        tests=[TestScope(**data) for data in about.get("tests", [])],
        curves=[CurveTarget.from_json(data) for data in definition.get("curves", [])],
        # Older versions took scatters of anything.
        scatters={n: value for n, value in about.get("scatters", {}).items() if n in names},
        ratios=definition.get("ratios", {}),
    )
    # A strategy may move a bound that is in the way.
    return problem.widened_to([evaluation.proposal.parameters for evaluation in evaluations])


def _material(runs: Iterable[RunRecord], free: Iterable[str]) -> dict[str, float]:
    """Fixed material parameters, as the definition of a built-in test has them."""
    for record in runs:
        if "test" in record.definition.model:
            return {n: v for n, v in record.definition.parameters.items() if n not in free}
    return {}


def _has_ended(request: RequestRecord, records: Mapping[str, RunRecord]) -> bool:
    return all(run in records and records[run].status != "running" for run in request.runs.values())


def _evaluation(
    request: RequestRecord,
    records: Mapping[str, RunRecord],
    tests: int,
    ratios: Mapping[str, float],
) -> Evaluation:
    runs = {test: records[run] for test, run in request.runs.items()}
    return evaluation_of(request.proposal(tests), runs, tests).scaled(ratios)


def read_answer(reading: SavedCalibration) -> Result:
    """Return the result of a calibration that has an answer.

    Raises
    ------
    InputError
        There is none yet.
    StoreError
        The result is damaged.
    """
    if reading.result_fault:
        raise StoreError(reading.result_fault)
    if reading.result is None or not reading.result.parameters:
        raise InputError(_no_answer(reading))
    return reading.result


def _no_answer(reading: SavedCalibration) -> Fault:
    message = {
        "running": messages.NO_ANSWER_WHILE_RUNNING,
        "interrupted": messages.NO_ANSWER_INTERRUPTED,
        "failed": messages.NO_ANSWER_FAILED,
    }.get(reading.state, messages.NO_ANSWER_FILE)
    folder = str(reading.folder)
    return message.fault(
        "",
        folder=folder,
        quoted=shlex.quote(folder),
        file=shlex.quote(reading.source) if reading.source else "FILE",
        result=str(reading.folder / RESULT_NAME),
    )
