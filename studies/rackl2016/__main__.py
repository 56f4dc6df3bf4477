"""``python -m studies.rackl2016``: make the study, or a step of it, and write its page."""

from __future__ import annotations

import signal
import time
from pathlib import Path
from typing import Annotated, Any, NoReturn

import typer
from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn
from threadpoolctl import threadpool_limits

from grainfit.cli.console import print_error
from grainfit.errors import GrainfitError
from grainfit.testing.materials import GLASS_BEADS
from studies.names import one_of
from studies.rackl2016.plan import STEPS, all_tasks
from studies.rackl2016.setting import make_solver
from studies.rackl2016.tasks import Report, Results, Study, Task

_console = Console(stderr=True)
#: Its records of finished parts are in the repository.
KEPT = Path(__file__).parent / "kept"
#: Without a terminal, a line of progress after this many seconds.
_LINE_SECONDS = 60.0

app = typer.Typer(
    add_completion=False,
    pretty_exceptions_enable=False,
    help="The study of Rackl et al. (2016), made again: killed and started again, it goes on.",
)


@app.command()
def main(
    steps: Annotated[
        list[str] | None,
        typer.Argument(
            metavar="[STEP]...",
            help=f"Of {', '.join(STEPS)}, estimate, report. All, and the report, by default.",
            parser=one_of("step", (*STEPS, "estimate", "report")),
        ),
    ] = None,
    workdir: Annotated[
        Path, typer.Option(metavar="DIR", help="Where runs and results are kept.")
    ] = KEPT,
    workers: Annotated[int, typer.Option(metavar="N", min=1, help="Runs at a time.")] = 2,
    only: Annotated[
        str, typer.Option(metavar="NAME", help="Only parts whose name begins so.")
    ] = "",
) -> None:
    """Make the study, or some steps of it."""
    wanted = steps or [*STEPS, "report"]
    try:
        _make(wanted, workdir, workers, only)
    except KeyboardInterrupt:
        _console.print("Interrupted. What was made is kept; start again to go on.")
        raise typer.Exit(130) from None
    except GrainfitError as error:
        print_error(_console, error)
        raise typer.Exit(1) from None


def _make(wanted: list[str], workdir: Path, workers: int, only: str) -> None:
    study = _study(workdir, workers)
    tasks = study.of_steps([step for step in wanted if step in STEPS], only)
    _print_estimate(study, tasks if tasks else list(study.tasks), workers)
    if "estimate" in wanted:
        _print_steps(study)
        return
    with threadpool_limits(limits=1, user_api="blas"):
        _do(study, tasks)
    if "report" in wanted:
        # Its figure takes a library that nothing else needs.
        from studies.rackl2016.report import write_report

        for path in write_report(study.results, workers):
            print(path)


def _study(workdir: Path, workers: int) -> Study:
    solver = make_solver()
    solver.check()
    heap = solver.definition(GLASS_BEADS, 1).identity
    return Study(all_tasks(), Results(workdir.absolute(), heap), solver, workers)


def _print_estimate(study: Study, tasks: list[Task], workers: int) -> None:
    left = study.open_tasks(tasks)
    runs = sum(task.runs + task.serial_runs for task in left)
    _console.print(
        f"{len(tasks) - len(left)} of {len(tasks)} parts are there. The others take about {runs:,} "
        f"runs of {study.run_seconds:.1f} s: about {study.seconds_left(tasks) / 60:.0f} min with "
        f"{workers} workers on an otherwise idle machine.",
        highlight=False,
        soft_wrap=True,
    )


def _print_steps(study: Study) -> None:
    for step in STEPS:
        tasks = [task for task in study.tasks if task.step == step]
        left = len(study.open_tasks(tasks))
        minutes = study.seconds_left(tasks) / 60
        print(f"{step:13} {len(tasks) - left:3} of {len(tasks):3} there, {minutes:4.0f} min left")


def _do(study: Study, tasks: list[Task]) -> None:
    left = study.open_tasks(tasks)
    columns = (TextColumn("{task.description}"), BarColumn(), TimeElapsedColumn())
    with Progress(*columns, console=_console, disable=not _console.is_terminal) as progress:
        overall = progress.add_task("study", total=sum(_weight(task) for task in left))
        for task in left:
            line = progress.add_task(task.name, total=None)
            started = time.monotonic()
            study.do(task, _reporter(progress, line, task.name))
            progress.remove_task(line)
            progress.advance(overall, _weight(task))
            seconds = time.monotonic() - started
            minutes_left = study.seconds_left(tasks) / 60
            _console.print(
                f"{task.name}: {seconds:.0f} s; about {minutes_left:.0f} min left", highlight=False
            )


def _weight(task: Task) -> int:
    return task.runs + task.serial_runs


def _reporter(progress: Progress, line: Any, name: str) -> Report:
    shown = time.monotonic()

    def report(done: int, of: int, words: str) -> None:
        nonlocal shown
        text = f"{name}: {words}, {done} of about {of}"
        progress.update(line, completed=done, total=of, description=text)
        if not _console.is_terminal and time.monotonic() - shown > _LINE_SECONDS:
            shown = time.monotonic()
            _console.print(text, highlight=False)

    return report


def _stop(_signal: int, _frame: Any) -> NoReturn:
    raise KeyboardInterrupt


if __name__ == "__main__":
    signal.signal(signal.SIGTERM, _stop)
    app()
