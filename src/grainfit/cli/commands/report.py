"""The command that writes the report of a calibration, and the report at the end of a run."""

from __future__ import annotations

import shlex
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Annotated

import typer

from grainfit.cli import console as show
from grainfit.cli import messages
from grainfit.cli.consoles import err, err_remarks, out_remarks
from grainfit.cli.interruption import interruption
from grainfit.cli.options import (
    Force,
    OpenAfterwards,
    WorkFolder,
    open_in_browser,
    output_option,
    require_free,
    require_kind,
)
from grainfit.errors import RunFailedError

_OUTPUT = "Where to write it, if not to report.html in DIR, or sheet.pdf."
_SHEET = "Write two pages for a customer as PDF instead: values, tests, validity, forecast, hashes."


def report(
    workdir: WorkFolder,
    output: Annotated[Path | None, output_option("FILE", _OUTPUT)] = None,
    sheet: Annotated[bool, typer.Option("--sheet", help=_SHEET)] = False,
    open_it: OpenAfterwards = False,
    force: Force = False,
) -> None:
    """Write the report of a calibration, also while it is running.

    One HTML file that can be read without network and without grainfit: is it
    calibrated, what are the values, how sure are they, what do the responses
    depend on, what do the particles of the tests look like, and every run.

    'grainfit run' writes it at its end; this command writes it at any time.
    """
    require_kind(output, ".pdf" if sheet else ".html")
    require_free(output, force=force)
    warnings: list[str] = []
    path = _write_sheet(workdir, output) if sheet else _write(workdir, output, warnings.append)
    for warning in warnings:
        show.print_warning(err, warning)
    if open_it:
        open_in_browser(path)


def _write_sheet(workdir: Path, output: Path | None) -> Path:
    with err_remarks.status("sheet"):
        from grainfit.report.sheet.sheet import write_sheet

        path = write_sheet(workdir, output)
    out_remarks.print(f"Sheet: {path}", highlight=False, markup=False, soft_wrap=True)
    return path


@contextmanager
def report_at_end(workdir: Path) -> Iterator[None]:
    """Write a report at the end of a run, also where it stops because its simulations fail."""
    try:
        yield
    except RunFailedError:
        _write_if_possible(workdir)
        raise
    _write_if_possible(workdir)


def _write(
    workdir: Path, output: Path | None = None, on_warning: Callable[[str], None] | None = None
) -> Path:
    """Write the report and show its progress, because it takes some seconds."""
    with err_remarks.status("report") as status:
        from grainfit.report.page import write_report

        path = write_report(
            workdir,
            output,
            on_progress=lambda section: status.update(f"report: {section}"),
            on_warning=on_warning,
        )
    out_remarks.print(f"Report: {path}", highlight=False, markup=False, soft_wrap=True)
    return path


def _write_if_possible(workdir: Path) -> None:
    """Write the report of a calibration that has ended; a fault is only a warning."""
    before = interruption.count
    try:
        _write(workdir)
        return
    except KeyboardInterrupt:
        reason = "stopped"
    except Exception as error:
        # The result is written and printed: a fault here must not look like a failed calibration.
        reason = " ".join(str(error).split()) or type(error).__name__
        if interruption.count > before:
            reason = "stopped"
    folder = shlex.quote(str(workdir))
    show.print_warning(err, messages.NO_REPORT(reason=reason, folder=folder))
