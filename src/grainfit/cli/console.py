"""Output of the command line: progress while it runs, tables at the end, errors in one line."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from math import isfinite
from pathlib import Path
from typing import TYPE_CHECKING

from rich import box
from rich.console import Console
from rich.table import Table
from rich.text import Text

from grainfit.cli import messages
from grainfit.errors import GrainfitError, InputError, RunFailedError
from grainfit.evaluation import Curve, Measured, curves, scalars
from grainfit.formatting import (
    alike,
    assigned,
    counted,
    duration,
    in_unit,
    plain,
    unit_for_people,
    with_unit,
)
from grainfit.verdict.messages import state_name

if TYPE_CHECKING:
    from grainfit.analysis.scatter import RepeatedRuns
    from grainfit.animation.animation import Animation
    from grainfit.calibration_file.plan import Plan
    from grainfit.materials.starting_materials import StartingMaterial
    from grainfit.preview.previewed_test import PreviewedTest
    from grainfit.problem import CurveTarget
    from grainfit.result import HoldoutResult, Result
    from grainfit.tables import TextTable
    from grainfit.work_folder.status import WorkdirStatus

_STATUS_COLOURS = {
    "calibrated": "green",
    "predicted": "yellow",
    "undecided": "yellow",
    "out_of_tolerance": "yellow",
    "unreachable": "red",
    "interrupted": "yellow",
}
_HOLDOUT_COLOURS = {"predicts": "green", "does not predict": "red"}
_VERDICT_COLOURS = {
    "met": "green",
    "in doubt": "yellow",
    "missed": "red",
    "determined": "green",
    "determined, but biased": "yellow",
    "narrowed": "yellow",
    "not determined": "red",
}


def _table(*columns: str) -> Table:
    """A table without boxes: it fits into 80 columns, and its text can be copied."""
    return Table(*columns, box=box.SIMPLE, show_edge=False, pad_edge=False, padding=(0, 1, 0, 0))


def _text(text: str, style: str = "") -> Text:
    """Return text as it is: no markup, and no control characters for a terminal.

    It may come from somebody else's file, from a program's output, or from the name of a file.
    """
    return Text("\n".join(plain(line) for line in text.split("\n")), style=style)


def _number(value: float | None, unit: str = "") -> str:
    if value is None or not isfinite(value):
        return "-"
    return f"{value:.4g} {unit}".rstrip()


def print_headline(console: Console, result: Result) -> None:
    """Print how a calibration ended."""
    console.print(_text(result.headline, f"bold {_STATUS_COLOURS[result.status]}"))


def print_result(console: Console, result: Result, folder: Path) -> None:
    """Print the outcome: parameters, responses against targets, time step, cost."""
    print_headline(console, result)
    for notice in result.notices:
        console.print(_text(f"  {notice}", "yellow"))
    for name, quality in result.metamodels.items():
        for warning in quality.warnings:
            console.print(_text(f"  metamodel of {quality.part or name}: {warning}", "yellow"))
    if result.parameters:
        for shown in result.tables():
            console.print(_rich_table(shown, console.width))
            if shown.caption:
                # As the caption of a table it would be centred and cut to its width.
                console.print(_text(shown.caption, "dim"))
        for locus in result.yield_loci:
            console.print(_text(str(locus)))
        if check := result.fresh_seeds():
            console.print(_text(check))
        if result.sureness:
            console.print(result.sureness, highlight=False)
        print_holdouts(console, result.holdouts)
        console.print(_time_step_line(result), highlight=False)
    console.print(
        f"{result.runs_in_words} Wall time {duration(result.wall_seconds)}, workers busy "
        f"{result.utilisation:.0%}.",
        highlight=False,
    )
    console.print(
        f"Result: {folder / 'result.json'}", highlight=False, markup=False, soft_wrap=True
    )


def print_holdouts(console: Console, holdouts: Iterable[HoldoutResult]) -> None:
    """Print the predictions of tests that took no part in the fit."""
    for one in holdouts:
        verdicts = [found.verdict or "" for found in one.predictions.values()]
        # Those of the predictions come first.
        for number, sentence in enumerate(one.sentences()):
            style = "yellow"
            if number < len(verdicts):
                style = _HOLDOUT_COLOURS.get(verdicts[number], "")
            console.print(_text(sentence, style))


def _rich_table(shown: TextTable, width: int) -> Table:
    """Return a table that, in a narrow terminal, breaks its headings first.

    Then lines break between several names, or else in the numbers: a name is copied, and words must
    be seen.
    """
    table = _table(*shown.header)
    table.columns[0].no_wrap = not any(" " in first for first, *_ in shown.rows)
    table.columns[-1].no_wrap = True
    lines = replace(shown, caption="").text().splitlines()
    is_narrow = max(map(len, lines)) > width
    texts = zip(shown.header, *shown.rows, strict=True)
    for column, (heading, *cells) in list(zip(table.columns, texts, strict=True))[1:-1]:
        column.justify = "right"
        if is_narrow:
            column.max_width = max(map(len, [*cells, *heading.split()]))
    for *cells, last in shown.rows:
        table.add_row(*map(_text, cells), _text(last, _VERDICT_COLOURS.get(last, "")))
    return table


def _time_step_line(result: Result) -> str:
    if result.rayleigh_time_step is None or result.rayleigh_time_step_before is None:
        return "No Rayleigh time step: the material's density, stiffness or size is not known."
    change = result.rayleigh_time_step / result.rayleigh_time_step_before
    return (
        f"Rayleigh time step: {result.rayleigh_time_step:.4g} s, {change:.2f} times that of the "
        f"middle of the intervals ({result.rayleigh_time_step_before:.4g} s)."
    )


def print_plan(console: Console, plan: Plan) -> None:
    """Print the plan of a calibration file."""
    console.print(_text(plan.name, "bold"))
    free = _table("free parameter", "from", "to", "scale")
    for parameter in plan.parameters:
        free.add_row(
            _text(parameter.name),
            _text(_number(parameter.minimum, parameter.unit)),
            _text(_number(parameter.maximum, parameter.unit)),
            parameter.scale,
        )
    console.print(free)
    targets = _table("response", "target", "tolerance")
    for target in plan.targets:
        targets.add_row(
            _text(target.name),
            _text(_number(target.value, target.unit)),
            _text(f"± {_number(target.tolerance, target.unit)}"),
        )
    for curve in plan.curves:
        targets.add_row(_text(curve.name), *map(_text, _words_on_curve(curve)))
    console.print(targets)
    for line in plan.lines:
        console.print(_text(line))
    for finding in plan.findings:
        style = "yellow" if finding.severity == "warning" else ""
        console.print(_text(f"{finding.severity.capitalize()}: {finding.text}", style))
    console.print(_execution_heading(plan))
    for line in plan.executes:
        console.print(_text(f"  {line}"), soft_wrap=True)
    for problem in plan.problems:
        console.print(_text(problem, "red"))


def _words_on_curve(curve: CurveTarget) -> tuple[str, str]:
    """Return the extent of a measured curve, and its largest uncertainty and tolerance."""
    first, last = (_number(curve.coordinates[end]) for end in (0, -1))
    unit = f" {curve.coordinate_unit}".rstrip()
    largest = float(curve.standard_uncertainties.max())
    tolerance = ""
    if curve.tolerance is not None:
        tolerance = f", tolerance up to {_number(float(curve.tolerances.max()), curve.unit)}"
    return (
        f"{len(curve.values)} points over {curve.coordinate}, {first} to {last}{unit}",
        f"uncertainty up to {_number(largest, curve.unit)}{tolerance}",
    )


def _execution_heading(plan: Plan) -> str:
    if not plan.executes:
        return "A run will execute: nothing."
    return "A run will execute, with your rights and without a shell:"


def print_status(console: Console, status: WorkdirStatus) -> None:
    """Print the progress of the calibration in a work folder."""
    console.print(_text(f"{status.name or 'no calibration'}: {state_name(status.state)}", "bold"))
    if status.failure:
        console.print(_text(f"stopped by: {status.failure}", "red"), soft_wrap=True)
    for stage, asked in status.asked.items():
        ended = status.finished.get(stage, 0)
        console.print(_text(f"{stage}: {ended} of {asked} runs asked for have ended"))
    waiting = f"{status.waiting} waiting, " if status.waiting else ""
    console.print(
        f"{status.running} running, {waiting}"
        f"{len(status.failed) + status.failed_in_holdouts} failed, "
        f"{status.kept} finished runs kept",
        highlight=False,
    )
    folders = {failure.reason: failure.folder for failure in reversed(status.failed)}
    for first, *others in alike(failure.reason for failure in status.failed):
        more = f", and {counted(len(others), 'run')} alike" if others else ""
        console.print(_text(f"failed: {first} ({folders[first]}{more})", "red"))
    if status.result:
        values, units = status.result.parameters, status.result.units
        for line, (name, value) in zip(assigned(values, units, 5), values.items(), strict=True):
            found = status.result.intervals.get(name)
            words = f" ({found.in_words(value, units.get(name, ''))})" if found else ""
            console.print(_text(f"{line}{words}"))
        print_holdouts(console, status.result.holdouts)
    if status.result_fault:
        print_warning(console, status.result_fault)


def print_starting_intervals(console: Console, material: StartingMaterial) -> None:
    """Print the intervals of a starting material, and where they come from."""
    for section, values in material.sections.items():
        for key, entry in values.items():
            if entry.is_free:
                ends = f"{entry.value['min']} to {entry.value['max']}"
                console.print(_text(f"{section}.{key} is free, {ends}. {entry.source}"))


def print_run(console: Console, runs: RepeatedRuns, folders: Mapping[str, Path]) -> None:
    """Print the responses of a single run."""
    [evaluation] = runs.evaluations
    found: dict[str, Measured] = {**evaluation.responses, **evaluation.curves}
    if found:
        units = {response.name: response.unit for response in runs.responses}
        console.print(_measured_table(found, "standard error of this run", units))
    for remark in runs.remarks:
        console.print(_text(remark, "yellow"))
    for test, reason in evaluation.failures.items():
        console.print(_text(f"{test} failed: {reason}", "red"))
    words = "known already" if evaluation.reused else f"{duration(evaluation.seconds)}"
    console.print(f"Wall time: {words}", highlight=False)
    for folder in folders.values():
        console.print(f"Run folder: {folder}", highlight=False, markup=False, soft_wrap=True)


def print_absences(console: Console, lines: Iterable[str]) -> None:
    """Print which responses valid runs are without, and why."""
    for line in lines:
        console.print(_text(line, "yellow"))


def print_animation(console: Console, animation: Animation) -> None:
    """Print where the animation of a run is, or why there is none."""
    if animation.path is None:
        console.print(_text(f"No animation of {animation.test}: {animation.problem}."))
        return
    about = f"{animation.frames} frames, {animation.size / 1e6:.1f} MB"
    words = f"Animation: {animation.path} ({about})"
    console.print(words, highlight=False, markup=False, soft_wrap=True)


def print_parts(console: Console, parts: Sequence[str | TextTable]) -> None:
    """Print sentences and tables."""
    for part in parts:
        if isinstance(part, str):
            console.print(_text(part))
            continue
        console.print(_rich_table(part, console.width))
        if part.caption:
            console.print(_text(part.caption, "dim"))


def read_numbers(key: str, text: str) -> list[float]:
    """Read numbers with commas between them.

    Raises
    ------
    InputError
        A number cannot be read.
    """
    found = []
    for part in text.split(","):
        try:
            found.append(float(part))
        except ValueError:
            fault = messages.NO_NUMBER.fault(key, given=part.strip())
            raise InputError(fault) from None
    return found


def print_preview(
    console: Console, tests: Sequence[PreviewedTest], page: Path, picture: Path
) -> None:
    """Print the cost of every test, and where its drawings are."""
    for test in tests:
        words = f"Test {test.name}, {test.solver}: {test.cost_text}."
        console.print(plain(words), highlight=False, markup=False)
        if test.problem:
            print_warning(console, plain(test.problem))
    for name, path in (("Page", page), ("Picture", picture)):
        console.print(f"{name}: {path}", highlight=False, markup=False, soft_wrap=True)


def print_measurement(console: Console, responses: Mapping[str, Measured]) -> None:
    """Print measured responses."""
    console.print(_measured_table(responses, "standard error", {}))


def _measured_table(
    responses: Mapping[str, Measured], error: str, units: Mapping[str, str]
) -> Table:
    """Return measured responses; units not given are those of the installed bulk tests."""
    from grainfit.bulk_tests.registry import curve_info, response_info

    table = _table("response", "value", error)
    for name, response in scalars(responses).items():
        known = response_info(name.rpartition(".")[2])
        head = in_unit(name, units.get(name) or (known.unit if known else ""))
        table.add_row(_text(head), _number(response.value), _number(response.standard_error))
    for name, curve in curves(responses).items():
        info = curve_info(name.rpartition(".")[2])
        head = in_unit(name, info.unit if info else "")
        table.add_row(_text(head), *_ends(curve, info.coordinate_unit if info else ""))
    return table


def _ends(curve: Curve, coordinate_unit: str) -> tuple[str, str]:
    low, high = (_number(curve.values[end]) for end in (0, -1))
    first, last = (_number(curve.coordinates[end]) for end in (0, -1))
    over = with_unit(f"{first} to {last}", unit_for_people(coordinate_unit))
    return f"{low} to {high}", f"(over {over})"


def print_warning(console: Console, text: str) -> None:
    """Print a warning in one line."""
    console.print(_text(text, "yellow"), soft_wrap=True)


def print_error(console: Console, error: GrainfitError) -> None:
    """Print an error, every fault on its own line."""
    if isinstance(error, InputError):
        for fault in error.faults:
            where = f"{error.source}: " if error.source else ""
            console.print(_text(f"{where}{fault}", "red"), soft_wrap=True)
        return
    console.print(_text(str(error), "red"), soft_wrap=True)
    if isinstance(error, RunFailedError) and error.log_tail:
        console.print("Last lines of its log:")
        for line in error.log_tail.splitlines():
            console.print(_text(f"  | {line}"), soft_wrap=True)
