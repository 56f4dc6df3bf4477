"""Every run in a table."""

from __future__ import annotations

import shlex
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from grainfit.campaign.work_folder import run_folder
from grainfit.evaluation import Evaluation, name_of_test, names_of_tests
from grainfit.formatting import number, plain, plain_lines
from grainfit.plots.convergence_figures import deviation_in_tolerances
from grainfit.plots.parallel_figures import parallel_figure
from grainfit.report.rendering import fill_template
from grainfit.report.section import ReportContext, Section

#: Of a run's identity, as `grainfit runs show` takes it.
_SHORT = 7
_PARALLEL = "runs-parallel"


@dataclass(frozen=True)
class Cell:
    """A number in the table: as it is shown, and as it is sorted by."""

    shown: str
    value: float | None


@dataclass(frozen=True)
class Failure:
    """Why a run failed, and the last lines of its log."""

    reason: str
    log: Sequence[str]


@dataclass(frozen=True)
class RunRow:
    """A parameter set that was simulated."""

    number: int
    stage: str
    failures: Sequence[Failure]
    cells: Sequence[Cell]
    files: Sequence[tuple[str, str]]
    outlying: str


def runs(context: ReportContext) -> Section:
    """Table of all parameter sets, with their outcome."""
    evaluations = context.reading.evaluations
    html = fill_template(
        "runs/page",
        columns=[
            *(context.parameter_label(parameter.name) for parameter in context.parameters),
            *(context.response_label(target.name) for target in context.targets),
        ],
        rows=[_row(context, number, run) for number, run in enumerate(evaluations, 1)],
        stages=sorted({evaluation.proposal.stage for evaluation in evaluations}),
        failed=sum(1 for evaluation in evaluations if evaluation.failures),
        folder=plain(shlex.quote(context.reading.folder.absolute().name)),
        warm_start=len(context.reading.warm_start),
        figure=_PARALLEL,
    )
    figure = parallel_figure(context.reading)
    figures = {_PARALLEL: figure} if figure is not None else {}
    return Section("runs", "Every run", html, figures)


def _row(context: ReportContext, count: int, evaluation: Evaluation) -> RunRow:
    proposal = evaluation.proposal
    responses = evaluation.responses
    values: list[float | None] = [
        *(proposal.parameters[parameter.name] for parameter in context.parameters),
        *(
            responses[target.name].value if target.name in responses else None
            for target in context.targets
        ),
        deviation_in_tolerances(
            context.reduction.problem, context.reduction.evaluations([evaluation])[0]
        ),
        evaluation.seconds,
    ]
    cells = [Cell(number(value), value) for value in values[:-2]]
    cells += [Cell(number(value, 3), value) for value in values[-2:]]
    return RunRow(
        number=count,
        stage=proposal.stage,
        failures=[_failure(context, evaluation, test) for test in evaluation.failures],
        cells=[*cells, Cell(str(proposal.seed), proposal.seed)],
        files=[
            (identity[:_SHORT], _files(context, identity)) for identity in evaluation.runs.values()
        ],
        outlying=", ".join(_outlying(context, proposal.seed)),
    )


def _files(context: ReportContext, identity: str) -> str:
    """Return the address of a run's picture, or else of its folder, as seen from the page."""
    folder = context.reading.folder
    pictures = sorted(run_folder(folder, identity).glob("*.png"))
    place = pictures[0] if pictures else run_folder(folder, identity)
    return place.relative_to(folder).as_posix()


def _outlying(context: ReportContext, seed: int) -> Iterator[str]:
    """Yield the responses of a run that lie far from what the others lead to expect."""
    metamodels = context.analysis.metamodels
    if metamodels is None:
        return
    for target, found in zip(metamodels.problem.targets, metamodels.outliers, strict=True):
        if seed in found.seeds:
            yield context.response_label(target.name).words


def _failure(context: ReportContext, evaluation: Evaluation, test: str) -> Failure:
    tests = names_of_tests(evaluation.runs)
    failed = [run for run in evaluation.failed_runs if name_of_test(run) == test]
    record = context.reading.records.get(evaluation.runs[failed[-1] if failed else test])
    reason = evaluation.failures[test]
    if len(tests) > 1:
        reason = f"{test}: {reason}"
    return Failure(plain(reason), plain_lines(record.log_tail) if record else [])
