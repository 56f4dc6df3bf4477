"""Commands that list, show, export, import and prune runs."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from grainfit.cli import messages
from grainfit.cli.completion import complete_run
from grainfit.cli.consoles import out, out_remarks
from grainfit.cli.documents import AsJson, print_document, run_document, runs_document
from grainfit.cli.help_texts import shown_default
from grainfit.cli.options import CalibrationPath, Force, WorkFolder, require_free, workdir_option
from grainfit.cli.verbosity import CommandLine
from grainfit.errors import InputError, StoreError

if TYPE_CHECKING:
    from grainfit.work_folder.run_columns import RunColumns

_DISK_SECONDS = 0.2
#: Runs that a list shows.
_SHOWN = 30
#: Of the name of a run in lists.
_NAME = 7
#: More digits are the beginning of an identity.
_DIGITS_OF_NUMBERS = 4

runs_app = CommandLine(help="List, show, export, import and prune runs.")

Source = Annotated[
    str,
    typer.Argument(
        metavar="DIR-or-URL", help="Work folder, or address of a shared store.", show_default=False
    ),
]
Status = Annotated[
    str | None,
    typer.Option(metavar="STATUS", help="Only those finished, failed, running or interrupted."),
]
Test = Annotated[str | None, typer.Option(metavar="NAME", help="Only those of a test.")]
Where = Annotated[
    list[str] | None,
    typer.Option(
        metavar="CONDITION",
        help="Only those that meet a condition on a parameter, response, seed or duration: "
        "'particle.density > 2 g/cm^3', 'seconds < 60'. Repeat as needed; all must hold.",
    ),
]
Sort = Annotated[
    str,
    typer.Option(metavar="COLUMN", help="Order by a column; -COLUMN has the largest first."),
]


@runs_app.command("list")
def list_runs(
    source: Source,
    status: Status = None,
    test: Test = None,
    where: Where = None,
    limit: Annotated[
        int | None,
        typer.Option(
            metavar="N",
            min=1,
            help=f"Most runs to show. {shown_default(f'{_SHOWN}, with --json all')}",
            show_default=False,
        ),
    ] = None,
    sort: Sort = "-ended",
    as_json: AsJson = False,
) -> None:
    """Show a line for each run: the latest first, unless another order is given."""
    from grainfit.cli import runs_console as show
    from grainfit.work_folder.disk_use import disk_use

    runs, selected = _selected(source, status, test, where, sort)
    if as_json:
        shown = selected.rows(range(len(selected))[:limit])
        print_document("runs", runs_document(source, len(runs), shown))
        return
    used = None if "://" in source else disk_use(Path(source), _DISK_SECONDS)
    disk = f"Run folders take {show.size(used)}." if used else ""
    show.print_runs(out, runs, selected, limit or _SHOWN, disk)


@runs_app.command("show")
def show_run(
    source: Source,
    identity: Annotated[
        str,
        typer.Argument(
            metavar="IDENTITY",
            help="As the list shows it, or in full; or a number of the report's table.",
            autocompletion=complete_run,
        ),
    ],
    as_json: AsJson = False,
) -> None:
    """Show all about a run: its definition, its outcome, its log and its folder."""
    from grainfit.campaign.work_folder import run_folder
    from grainfit.cli import runs_console as show

    found = _find(source, identity)
    [record] = found.records
    folder = None if "://" in source else run_folder(Path(source), record.identity)
    there = folder if folder is not None and folder.is_dir() else None
    if as_json:
        print_document("run", run_document(found, there))
    else:
        show.print_record(out, found, there)


@runs_app.command("export")
def export(
    source: Source,
    file: Annotated[
        Path, typer.Argument(metavar="FILE", help="FILE.csv or FILE.parquet.", show_default=False)
    ],
    status: Status = None,
    test: Test = None,
    where: Where = None,
    sort: Sort = "ended",
    force: Force = False,
) -> None:
    """Write a line for each run to a CSV or Parquet file, in SI units, angles in degrees."""
    from grainfit.formatting import counted
    from grainfit.work_folder.run_export import export_runs, writer_for

    writer_for(file)
    require_free(file, force=force)
    _, selected = _selected(source, status, test, where, sort)
    export_runs(file, selected)
    words = counted(len(selected), "run")
    out_remarks.print(f"Wrote {words} to {file}", highlight=False, markup=False)


@runs_app.command("import")
def import_table(
    file: CalibrationPath,
    table: Annotated[
        Path,
        typer.Argument(
            metavar="TABLE.csv",
            help="A column for each free parameter and each target, perhaps with its unit in "
            "square brackets; perhaps seed and RESPONSE.standard_error.",
            show_default=False,
        ),
    ],
    test: Annotated[
        str | None, typer.Option(metavar="NAME", help="The test, when the file has several.")
    ] = None,
    workdir: Annotated[Path | None, workdir_option("Where they go.")] = None,
) -> None:
    """Import runs from elsewhere: the next calibration of the file has a warm start from them."""
    from grainfit.calibration_file.build import load_calibration
    from grainfit.campaign.work_folder import default_workdir
    from grainfit.cli import runs_console as show
    from grainfit.work_folder.run_import import import_runs

    folder = workdir or default_workdir(file)
    imported = import_runs(load_calibration(file), table, folder, test)
    show.print_imported(out, imported, folder)


@runs_app.command("prune")
def prune(
    folder: WorkFolder,
    failed: Annotated[bool, typer.Option("--failed", help="Also in failed runs.")] = False,
) -> None:
    """Free disk space: of every finished run, only record, logs and pictures stay.

    No result is lost, and no run is repeated.
    """
    from grainfit.cli import runs_console as show
    from grainfit.work_folder.prune import prune_runs

    pruned = prune_runs(folder, failed)
    show.print_pruned(out, pruned)
    if pruned.faults:
        raise typer.Exit(1)


def _selected(
    source: str, status: str | None, test: str | None, where: list[str] | None, sort: str
) -> tuple[RunColumns, RunColumns]:
    """Return all runs, and those selected, in order."""
    from grainfit.campaign.store.source import open_source
    from grainfit.work_folder.run_columns import laboratory_of, none_running, run_columns
    from grainfit.work_folder.run_selection import select_runs, sort_runs

    with open_source(source, "") as store:
        runs = run_columns(store.runs(), none_running(source), laboratory_of(store))
    return runs, sort_runs(select_runs(runs, status, test, where or ()), sort)


def _find(source: str, identity: str) -> RunColumns:
    """Return the only run with an identity."""
    from grainfit.campaign.store.source import open_source
    from grainfit.work_folder.run_columns import find_run, laboratory_of, none_running, run_columns

    wanted = identity.strip()
    if wanted.isdecimal() and len(wanted) <= _DIGITS_OF_NUMBERS and "://" not in source:
        wanted = _numbered(Path(source), int(wanted)) or wanted
    with open_source(source, "") as store:
        found = [find_run(store, wanted)]
        return run_columns(found, none_running(source), laboratory_of(store))


def _numbered(folder: Path, number: int) -> str:
    """Return the run of a number, as the report counts them; "" if there is none."""
    from grainfit.work_folder.saved_calibration import SavedCalibration

    try:
        evaluations = SavedCalibration.open(folder).evaluations
    except StoreError:
        return ""
    runs = list(evaluations[number - 1].runs.values()) if 0 < number <= len(evaluations) else []
    if len(runs) > 1:
        names = ", ".join(run[:_NAME] for run in runs)
        raise InputError(
            messages.SEVERAL_SIMULATIONS.fault("", number=number, count=len(runs), names=names)
        )
    return runs[0] if runs else ""
