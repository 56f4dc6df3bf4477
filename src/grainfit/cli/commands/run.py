"""The command that calibrates."""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import ExitStack, suppress
from dataclasses import replace
from itertools import chain
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from grainfit.cli import console as show
from grainfit.cli import messages
from grainfit.cli.commands.report import report_at_end
from grainfit.cli.commands.watch import Watch, watching
from grainfit.cli.consoles import err, err_remarks, out
from grainfit.cli.exit_codes import INTERRUPTED, OF_STATUS
from grainfit.cli.help_texts import shown_default
from grainfit.cli.local_page import OpenPage, Port
from grainfit.cli.notification import Notify, notifying
from grainfit.cli.options import CalibrationPath, Workdir
from grainfit.cli.search_options import with_search_options
from grainfit.cli.verbosity import is_quiet, is_verbose
from grainfit.errors import InputError, StoreError
from grainfit.formatting import assigned, counted
from grainfit.strategies.registry import strategies

if TYPE_CHECKING:
    from grainfit.calibration_file.build import CalibrationSetup
    from grainfit.result import Result

#: Runs that are named of those that were under way when a start died.
_MOST_CUT_OFF = 3

_Strategy = Annotated[
    str | None,
    typer.Option(
        metavar="|".join(strategies()),
        help=f"Strategy that chooses the runs. {shown_default('from the file')}",
    ),
]
_RunsFrom = Annotated[
    list[str] | None,
    typer.Option(
        metavar="DIR-or-URL",
        help="Work folder or store of earlier runs to reuse. Repeat as needed.",
    ),
]
_Store = Annotated[
    str | None,
    typer.Option(
        metavar="URL",
        envvar="GRAINFIT_STORE",
        help="Store that several machines share: no run is repeated.",
    ),
]
_RetryFailed = Annotated[
    bool,
    typer.Option(
        "--retry-failed",
        help="Repeat all failed runs of the work folder. Without it: only those that failed "
        "because of the machine or a time-out.",
    ),
]
_Local = Annotated[bool, typer.Option("--local", help="Run here, not on the file's cluster.")]
_NoReport = Annotated[
    bool, typer.Option("--no-report", help="Do not write report.html at the end.")
]


_FullSize = Annotated[
    bool,
    typer.Option(
        "--full-size",
        help="With strategy.twins: make one run of each real test at the answer, hours each, and "
        "judge the answer by them.",
    ),
]


@with_search_options
def run(
    file: CalibrationPath,
    workdir: Workdir = None,
    strategy: _Strategy = None,
    runs_from: _RunsFrom = None,
    store: _Store = None,
    retry_failed: _RetryFailed = False,
    full_size: _FullSize = False,
    local: _Local = False,
    no_report: _NoReport = False,
    watched: Watch = False,
    port: Port = 0,
    open_page: OpenPage = False,
    notify: Notify = None,
    *,
    search_options: dict[str, Any],
) -> None:
    """Calibrate: simulate, fit, verify, and write result.json and report.html.

    Stop it at any time with Ctrl-C and start the same command again: no finished run is repeated.

    Exit code: 0 calibrated, 1 bad input or a missing solver, 2 a mistake on the command line, 3 not
    every target is met or in reach, or predicted alone, 130 interrupted.
    """
    from grainfit.campaign.work_folder import default_workdir

    folder = workdir or default_workdir(file)
    given = {
        "strategy": strategy,
        "store": store,
        "runs_from": runs_from or (),
        "retry_failed": retry_failed,
        "full_size": full_size,
        **search_options,
    }
    with ExitStack() as stack:
        ending = stack.enter_context(notifying(notify, folder))
        setup = _setup(file, folder, local)
        if full_size and setup.strategy.twins is None:
            raise InputError(messages.FULL_SIZE_OF_NOTHING.fault("--full-size"))
        if watched or open_page or port:
            stack.enter_context(watching(folder, port, open_page))
        if not no_report:
            stack.enter_context(report_at_end(folder))
        ending.result = _calibrate(setup, folder, **given)
    if any(one.state == "interrupted" for one in ending.result.holdouts):
        raise typer.Exit(INTERRUPTED)
    raise typer.Exit(OF_STATUS[ending.result.status])


def calibrate_file(file: Path) -> None:
    """Calibrate as ``grainfit run FILE`` does."""
    run.__wrapped__(file, search_options={})  # type: ignore[attr-defined]


def _setup(file: Path, folder: Path, local: bool) -> CalibrationSetup:
    from grainfit.calibration_file.build import load_calibration
    from grainfit.campaign.cluster.executor import missing_scheduler

    setup = replace(load_calibration(file, folder), local=local)
    for target in setup.file.photographs:
        for line in (*target.lines(), *(f"{target.key}: {text}" for text in target.changes)):
            err_remarks.print(line, markup=False, highlight=False)
    if setup.file.cluster is not None and setup.cluster is None and not local:
        err.print(f"Cluster: {missing_scheduler(setup.file.cluster)}")
    return setup


def _show_opening(setup: CalibrationSetup, folder: Path, max_runs: int | None) -> None:
    """Print apparatus and forecast before the first run of a folder; later, what was cut off."""
    from grainfit.calibration_file.apparatus import opening_lines
    from grainfit.calibration_file.checks.context import context_of
    from grainfit.calibration_file.checks.fine_tolerances import scatter_forecasts
    from grainfit.campaign.store.store import STORE_NAME

    if (folder / STORE_NAME).exists():
        _show_cut_off(folder, setup.problem.units)
    else:
        context = context_of(setup.file, setup.problem, setup.solvers)
        forecasts = (text for _, text in scatter_forecasts(context, max_runs))
        for line in chain(opening_lines(setup), forecasts):
            err_remarks.print(line, markup=False, highlight=False)


def _show_cut_off(folder: Path, units: Mapping[str, str]) -> None:
    """Print the runs under way when the last start died: one of them may have crashed it."""
    from grainfit.work_folder.open_folder import open_folder

    # A store that cannot be read yet, such as one of an earlier version, is for the calibration.
    with suppress(StoreError), open_folder(folder) as opened:
        cut_off = opened.cut_off()
        if cut_off:
            shown = "; ".join(
                f"{name} at {', '.join(assigned(values, units))}"
                for name, values in cut_off[:_MOST_CUT_OFF]
            )
            more = len(cut_off) - _MOST_CUT_OFF
            others = f" and {counted(more, 'other')}" if more > 0 else ""
            text = messages.CUT_OFF(runs=shown, others=others)
            err_remarks.print(text, markup=False, highlight=False)


def _calibrate(setup: CalibrationSetup, folder: Path, **given: Any) -> Result:
    """Calibrate with a bar, and print the result."""
    from grainfit.calibration.live_progress import LiveProgress
    from grainfit.calibration_file.fault_lines import with_lines

    _show_opening(setup, folder, given.get("max_runs"))
    on_command_line = {name for name, value in given.items() if value not in (None, ())}
    with (
        with_lines(setup.file.path, besides=on_command_line),
        LiveProgress(err_remarks, every_run=is_verbose(), units=setup.problem.units) as progress,
    ):
        result = setup.calibrate(
            folder, on_progress=progress.update, on_phase=progress.say, **given
        )
    if is_quiet():
        show.print_headline(out, result)
    else:
        show.print_result(out, result, folder)
    return result
