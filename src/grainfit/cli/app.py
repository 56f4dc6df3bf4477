"""The command line: parse, call, print.

A command imports what it needs when it is called, so that help and status are fast.
"""

from __future__ import annotations

import gc
import os
import shlex
import sys
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager, suppress
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer
from typer.core import TyperGroup
from typing_extensions import override

from grainfit.cli import console as show
from grainfit.cli.advice import Workers, advise, design
from grainfit.cli.asking import can_ask, choose
from grainfit.cli.compare import compare
from grainfit.cli.completion import complete_material, complete_setting
from grainfit.cli.consoles import err as _err
from grainfit.cli.consoles import err_remarks as _err_remarks
from grainfit.cli.consoles import out as _out
from grainfit.cli.consoles import out_remarks as _remarks
from grainfit.cli.documents import (
    AsJson,
    error_document,
    json_is_wanted,
    plan_document,
    print_document,
    result_document,
    status_document,
)
from grainfit.cli.export import export
from grainfit.cli.help_texts import WORK_FOLDER, shown_default
from grainfit.cli.interruption import Interruption
from grainfit.cli.notification import Notify, notifying
from grainfit.cli.runs import runs_app
from grainfit.cli.search_options import with_search_options
from grainfit.cli.simulating import INTERRUPTED, STOPPED, simulating
from grainfit.cli.verbosity import CommandLine, Quiet, Verbose, begin, is_quiet, is_verbose
from grainfit.cli.watch import OpenPage, Port, Watch, watch, watching
from grainfit.errors import Fault, GrainfitError, InputError, RunFailedError
from grainfit.materials.starting_materials import (
    read_starting_material,
    starting_material_names,
)
from grainfit.strategies.registry import strategies

if TYPE_CHECKING:
    from grainfit.calibration_file.build import CalibrationSetup
    from grainfit.evaluation import Evaluation
    from grainfit.result import Result

EXIT_CODES = {
    "calibrated": 0,
    "undecided": 3,
    "out_of_tolerance": 3,
    "unreachable": 3,
    "interrupted": 130,
}
_BAD_INPUT = 1
#: Frames of an animation.
_FRAMES = 60
#: Base of what Typer raises for an unknown command, option or value.
_WRONG_USAGE: Any = typer.BadParameter.__base__

_interruption = Interruption()


class _Commands(TyperGroup):
    """All commands: an interrupted one ends with one line."""

    @override
    def invoke(self, ctx: Any) -> Any:
        try:
            return super().invoke(ctx)
        except (typer.Exit, typer.Abort, GrainfitError):
            raise
        except (Exception, KeyboardInterrupt) as error:
            if not (isinstance(error, KeyboardInterrupt) or _interruption.count):
                raise
            _interruption.exit_at_once(INTERRUPTED)
            _err.print(STOPPED if ctx.invoked_subcommand == "run" else "Interrupted.")
            raise typer.Exit(INTERRUPTED) from None


app = CommandLine(
    name="grainfit",
    cls=_Commands,
    no_args_is_help=True,
    pretty_exceptions_enable=False,
    rich_markup_mode="rich",
    context_settings={"help_option_names": ["-h", "--help"]},
    help="""Calibrate the material parameters of DEM models of bulk solids.

    You give laboratory measurements and an interval for every unknown
    parameter; grainfit runs the simulated tests, finds the parameters that
    reproduce the measurements, and verifies them.

    [bold]First steps:[/bold]  grainfit new my_material.toml  →  edit it  →
    grainfit check my_material.toml  →  grainfit run my_material.toml
    """,
)
app.add_typer(runs_app, name="runs")


def _print_version(wanted: bool) -> None:
    if wanted:
        from importlib.metadata import version

        _out.print(f"grainfit {version('grainfit')}", highlight=False)
        raise typer.Exit


@app.callback()
def _before_every_command(
    version: Annotated[  # noqa: ARG001
        bool,
        typer.Option(
            "--version", callback=_print_version, is_eager=True, help="Show the version and exit."
        ),
    ] = False,
    quiet: Quiet = False,
    verbose: Verbose = False,
) -> None:
    begin(quiet=quiet, verbose=verbose)


CalibrationPath = Annotated[
    Path, typer.Argument(metavar="FILE", help="Calibration file (TOML).", show_default=False)
]
Workdir = Annotated[
    Path | None,
    typer.Option(
        "--workdir",
        metavar="DIR",
        help=f"Where runs and results are kept. {shown_default(WORK_FOLDER)}",
    ),
]


@app.command()
@with_search_options
def run(
    file: CalibrationPath,
    workdir: Workdir = None,
    strategy: Annotated[
        str | None,
        typer.Option(
            metavar="|".join(strategies()),
            help=f"Strategy that chooses the runs. {shown_default('from the file')}",
        ),
    ] = None,
    runs_from: Annotated[
        list[str] | None,
        typer.Option(
            metavar="DIR-or-URL",
            help="Work folder or store of earlier runs to reuse. Repeat as needed.",
        ),
    ] = None,
    store: Annotated[
        str | None,
        typer.Option(
            metavar="URL",
            envvar="GRAINFIT_STORE",
            help="Store that several machines share: no run is repeated.",
        ),
    ] = None,
    retry_failed: Annotated[
        bool,
        typer.Option(
            "--retry-failed",
            help="Repeat all failed runs of the work folder. Without it: only those that failed "
            "because of the machine or a time-out.",
        ),
    ] = False,
    local: Annotated[
        bool, typer.Option("--local", help="Run here, not on the file's cluster.")
    ] = False,
    no_report: Annotated[
        bool, typer.Option("--no-report", help="Do not write report.html at the end.")
    ] = False,
    watched: Watch = False,
    port: Port = 0,
    open_page: OpenPage = False,
    notify: Notify = None,
    search_options: dict[str, Any] | None = None,
) -> None:
    """Calibrate: simulate, fit, verify, and write result.json and report.html.

    Stop it at any time with Ctrl-C and start the same command again: no finished run is repeated.

    Exit code: 0 calibrated, 1 bad input or a missing solver, 2 a mistake on the command line, 3 not
    every target is met or in reach, 130 interrupted.
    """
    from grainfit.calibration_file.fault_lines import with_lines
    from grainfit.campaign.cluster.executor import missing_scheduler
    from grainfit.campaign.work_folder import default_workdir

    folder = workdir or default_workdir(file)
    given = search_options or {}
    named = {name for name, value in {"strategy": strategy, "store": store}.items() if value}
    with ExitStack() as stack:
        told = stack.enter_context(notifying(notify, folder))
        setup = replace(_build(file), local=local)
        if setup.file.cluster is not None and setup.cluster is None and not local:
            _err.print(f"Cluster: {missing_scheduler(setup.file.cluster)}")
        if watched or open_page or port:
            stack.enter_context(watching(folder, port, open_page))
        with with_lines(file, besides={*given, *named}):
            result = _calibrate(
                setup,
                folder,
                reports=not no_report,
                strategy=strategy,
                runs_from=runs_from or (),
                store=store,
                retry_failed=retry_failed,
                **given,
            )
        told.result = result
        if is_quiet():
            show.print_headline(_out, result)
        else:
            show.print_result(_out, result, folder)
        if not no_report:
            _report_if_possible(folder)
    raise typer.Exit(EXIT_CODES[result.status])


def _calibrate(setup: CalibrationSetup, folder: Path, *, reports: bool, **options: Any) -> Result:
    """Calibrate with a bar; where too many runs fail, write the report of that as well."""
    from grainfit.calibration.live_progress import LiveProgress

    with ExitStack() as stack:
        if reports:
            stack.enter_context(_report_of_failure(folder))
        progress = LiveProgress(_err_remarks, every_run=is_verbose())
        tell = stack.enter_context(progress).update
        return setup.calibrate(folder, on_progress=tell, **options)


@app.command()
def check(
    file: CalibrationPath,
    no_code: Annotated[
        bool,
        typer.Option("--no-code", help="Call no function of a scene; its cost stays unknown."),
    ] = False,
    as_json: AsJson = False,
) -> None:
    """Validate a calibration file and show the plan. Nothing is simulated.

    The function that describes a scene of your own is called once. Nothing else is executed.
    """
    from grainfit.calibration_file.plan import describe_plan

    setup = _build(file)
    plan = describe_plan(setup, call_scenes=not no_code)
    if as_json:
        print_document("check", plan_document(file, plan))
    else:
        show.print_plan(_out, plan)
    if plan.problems:
        raise typer.Exit(_BAD_INPUT)


@app.command()
def preview(
    file: CalibrationPath,
    settings: Annotated[
        list[str] | None,
        typer.Option(
            "--set",
            metavar="NAME=VALUE",
            autocompletion=complete_setting,
            help="A parameter's value, units allowed. Repeat as needed. "
            f"{shown_default('the middle of its interval')}",
            show_default=False,
        ),
    ] = None,
    seed: Annotated[
        int, typer.Option(metavar="N", min=1, max=900_000_000, help="Insertion seed.")
    ] = 1,
    output: Annotated[
        Path | None,
        typer.Option(
            "--output",
            "-o",
            metavar="FILE.html",
            help="The page, or FILE.png for the picture; the other one is beside it. "
            + shown_default("the file's name with .preview.html, here"),
        ),
    ] = None,
    open_it: Annotated[
        bool, typer.Option("--open", help="Show the page in the web browser afterwards.")
    ] = False,
) -> None:
    """Draw every test before it runs: geometry, first packing, stages, and the cost of a run.

    Writes a page in three dimensions, and a picture (PNG). No solver is needed or started; the
    function of a scene of your own is called. Measured values may be missing.
    """
    from grainfit.calibration_file.planned import load_tests
    from grainfit.calibration_file.settings import set_values
    from grainfit.preview.preview import preview_tests, write_preview

    planned = load_tests(file)
    values = set_values(planned.file, settings or [])
    tests = preview_tests(planned.solvers, values, seed, str(file))
    page, picture = write_preview(
        output or Path(f"{file.stem}.preview.html"), planned.file.name, tests, values
    )
    show.print_preview(_out, tests, page, picture)
    if open_it:
        import webbrowser

        webbrowser.open(page.absolute().as_uri())


@app.command()
def new(
    file: Annotated[Path, typer.Argument(metavar="FILE")] = Path("calibration.toml"),
    test: Annotated[
        list[str] | None,
        typer.Option(
            metavar="NAME",
            help="Laboratory test to calibrate with, such as heap or draw_down. Repeat as needed. "
            f"{shown_default('heap; on a terminal it asks')}",
            show_default=False,
        ),
    ] = None,
    material: Annotated[
        str | None,
        typer.Option(
            metavar="NAME",
            help="Material whose published values it begins with, sources in its comments: "
            f"{', '.join(starting_material_names())}. One word is enough, such as sand. "
            f"{shown_default('glass beads; on a terminal it asks')}",
            show_default=False,
            autocompletion=complete_material,
        ),
    ] = None,
    solver: Annotated[
        str,
        typer.Option(metavar="NAME", help="DEM program of the tests: lammps, liggghts or yade."),
    ] = "lammps",
) -> None:
    """Write a commented calibration file to start from.

    On a terminal it asks for material and tests, unless they are given.

    [bold]Example:[/bold]  grainfit new pellets.toml --material plastic --solver liggghts
    """
    from grainfit.calibration_file.starter import starter_file

    if not file.exists() and material is None and not test and can_ask():
        [material], test = _ask_for_material(), _ask_for_tests()
    begin = None if material is None else read_starting_material(material)
    text = starter_file(test or ["heap"], begin, solver)
    try:
        with file.open("x", encoding="utf-8") as target:
            target.write(text)
    except FileExistsError:
        raise InputError(
            Fault("", f"{str(file)!r} exists already.", "Choose another name.")
        ) from None
    except OSError as error:
        raise InputError(Fault("", f"{str(file)!r} cannot be written: {error.strerror}.")) from None
    if begin is not None:
        show.print_starting_intervals(_remarks, begin)
    _remarks.print(
        f"Wrote {file}. Edit it, then: grainfit check {file}", highlight=False, markup=False
    )


def _ask_for_material() -> list[str]:
    titles = {name: read_starting_material(name).title for name in starting_material_names()}
    return choose("Material", titles, "glass_beads")[:1]


def _ask_for_tests() -> list[str]:
    from grainfit.bulk_tests.registry import bulk_tests

    titles = {name: test.title for name, test in bulk_tests().items()}
    return choose("Tests, with commas", titles, "heap")


@app.command()
def status(
    workdir: Annotated[Path, typer.Argument(metavar="DIR", help="Work folder of a calibration.")],
    as_json: AsJson = False,
) -> None:
    """Show the progress of a calibration and the values that it found, also while it is running."""
    from grainfit.work_folder.status import read_status

    found = read_status(workdir)
    if as_json:
        print_document("status", status_document(workdir, found))
    else:
        show.print_status(_out, found)


@app.command()
def result(
    workdir: Annotated[Path, typer.Argument(metavar="DIR", help="Work folder of a calibration.")],
    as_json: AsJson = False,
) -> None:
    """Show the result of a calibration, as 'grainfit run' showed it at its end."""
    from grainfit.work_folder.open_folder import open_folder

    with open_folder(workdir) as opened:
        found = opened.require_result()
    if as_json:
        print_document("result", result_document(workdir, found))
    else:
        show.print_result(_out, found, workdir)


@app.command()
def report(
    workdir: Annotated[Path, typer.Argument(metavar="DIR", help="Work folder of a calibration.")],
    output: Annotated[
        Path | None,
        typer.Option(
            "--output",
            "-o",
            metavar="FILE",
            help="Where to write it, if not to report.html in DIR.",
        ),
    ] = None,
    open_it: Annotated[
        bool, typer.Option("--open", help="Show it in the web browser afterwards.")
    ] = False,
) -> None:
    """Write the report of a calibration, also while it is running.

    One HTML file that can be read without network and without grainfit: is it
    calibrated, what are the values, how sure are they, what do the responses
    depend on, what do the particles of the tests look like, and every run.

    'grainfit run' writes it at its end; this command writes it at any time.
    """
    path = _write_report(workdir, output)
    _remarks.print(f"Report: {path}", highlight=False, markup=False, soft_wrap=True)
    if open_it:
        import webbrowser

        webbrowser.open(path.absolute().as_uri())


@app.command()
def simulate(
    file: CalibrationPath,
    settings: Annotated[
        list[str] | None,
        typer.Option(
            "--set",
            metavar="NAME=VALUE",
            autocompletion=complete_setting,
            help="A parameter's value, units allowed: particle.density=2300. Repeat as needed.",
        ),
    ] = None,
    answer_of: Annotated[
        Path | None,
        typer.Option(
            metavar="DIR",
            help="Work folder of a calibration: its answer is simulated. FILE may have another "
            "test, another size or another solver.",
        ),
    ] = None,
    seed: Annotated[
        int,
        typer.Option(
            metavar="N", min=1, max=900_000_000, help="Insertion seed, the first with --repeat."
        ),
    ] = 1,
    repeat: Annotated[
        int,
        typer.Option(
            metavar="N", min=1, max=100_000, help="Runs of each test, with seeds N, N+1 ..."
        ),
    ] = 1,
    workers: Workers = None,
    workdir: Annotated[
        Path | None,
        typer.Option(
            "--workdir",
            metavar="DIR",
            help="Where runs are kept, for example the work folder of the calibration. "
            + shown_default("the file's name with .simulated, here"),
        ),
    ] = None,
    animated: Annotated[
        bool,
        typer.Option(
            "--animate",
            help="Write a page beside each run that plays it in three dimensions, with the walls "
            "where they are. Also of a run that fails: it shows why.",
        ),
    ] = False,
    frames: Annotated[
        int | None,
        typer.Option(
            metavar="N",
            min=2,
            max=1000,
            help="Largest number of frames of --animate. " + shown_default("60"),
            show_default=False,
        ),
    ] = None,
) -> None:
    """Simulate every test once and show its responses and its folder.

    With --repeat, simulate it with several seeds and show mean and scatter of the responses beside
    the tolerances. Finished runs are kept: stop it with Ctrl-C, start it again, also with more
    seeds, and only what is missing is simulated.

    With --animate, watch what a test does: animation.html in the folder of the run opens in any
    browser, without network. The run is the same, to the last digit of its responses; one that was
    simulated before without frames is simulated again, and stays as it is.

    Free parameters that are not set take the middle of their interval, or with --answer-of the
    values of the answer of a calibration.

    [bold]Example:[/bold]  grainfit simulate beads.toml --repeat 20

    [bold]Example:[/bold]  grainfit simulate beads.toml --set particle.density=2300 --animate

    [bold]Example:[/bold]  grainfit simulate full_size.toml --answer-of beads.grainfit
    """
    from grainfit.campaign.absent_responses import absences
    from grainfit.campaign.batch import run_folders
    from grainfit.campaign.work_folder import simulations_folder
    from grainfit.work_folder.repeat_runs import repeat_runs

    setup = _build(file)
    if frames is not None and not animated:
        raise InputError(Fault("", "--frames is for --animate.", "Give both, or none."))
    if animated and repeat > 1:
        remedy = "Choose the run with --seed instead."
        raise InputError(Fault("", "--animate shows one run, not --repeat of them.", remedy))
    frames = frames or _FRAMES
    for note in setup.outside(settings or ()):
        _err_remarks.print(f"Note: {note}", highlight=False, markup=False)
    if animated:
        from grainfit.animation.animation import filming

        setup = filming(setup, frames)
    with simulating() as report:
        runs = repeat_runs(
            setup,
            repeat=repeat,
            seed=seed,
            settings=settings or (),
            answer_of=answer_of,
            workdir=workdir,
            workers=workers,
            **report,
        )
    if repeat > 1:
        show.print_parts(_out, runs.summary())
    else:
        [evaluation] = runs.evaluations
        folder = workdir or simulations_folder(file)
        show.print_run(_out, runs, run_folders(setup.solvers, evaluation, folder))
        if animated:
            _animate(setup, evaluation, folder, frames)
    show.print_absences(_out, absences(setup.solvers, runs.evaluations))
    if runs.failures:
        raise typer.Exit(_BAD_INPUT)


def _animate(setup: CalibrationSetup, evaluation: Evaluation, folder: Path, frames: int) -> None:
    """Write the pages of the runs of a command, and say where they are."""
    from grainfit.animation.animation import animate

    def say(tests: list[str]) -> None:
        words = f"Simulating {', '.join(tests)} again: the stored run has too few frames or none."
        _remarks.print(words, highlight=False, markup=False)

    with simulating("animation"):
        for animation in animate(setup, evaluation, folder, frames, say):
            show.print_animation(_out, animation)


@app.command()
def analyse(
    file: CalibrationPath,
    runs: Annotated[
        list[str],
        typer.Option(
            "--runs",
            metavar="TABLE",
            help="Runs: a CSV file with a column for each free parameter and each target, with "
            "several tests as TEST=TABLE; or a work folder. Repeat as needed.",
            show_default=False,
        ),
    ],
) -> None:
    """Show what existing runs say, without any simulation.

    Which parameter sets agree with the measurements, how well each parameter
    is determined, and on which parameters the responses depend.

    [bold]Example:[/bold]  grainfit analyse beads.toml --runs runs.csv
    """
    with _err_remarks.status("analysis"):
        from grainfit.work_folder.analyse_runs import analyse_runs

        found = analyse_runs(_build(file), runs)
    show.print_parts(_out, found.summary())


@app.command()
def stiffness(
    path: Annotated[
        Path,
        typer.Argument(
            metavar="FILE-or-DIR",
            help="Work folder of a calibration, for its answer; or a calibration file.",
        ),
    ],
    factors: Annotated[
        str,
        typer.Option(
            metavar="F,F,...",
            help="Moduli to simulate, over that of the calibration. A time step is 1/sqrt(F).",
        ),
    ] = "1,4,16",
    seeds: Annotated[int, typer.Option(metavar="N", min=1, help="Runs of each modulus.")] = 3,
    settings: Annotated[
        list[str] | None,
        typer.Option(
            "--set",
            metavar="NAME=VALUE",
            autocompletion=complete_setting,
            help="For a file: a parameter's value, units allowed. Repeat as needed.",
        ),
    ] = None,
    workers: Workers = None,
    workdir: Workdir = None,
) -> None:
    """Show what the stiffness of the particles changes, and the smallest modulus that will do.

    DEM particles are chosen far softer than real ones, because the time step is proportional to
    1/sqrt(E). Soft particles overlap, which raises bulk densities; most angles do not change.
    This command simulates the tests again with stiffer particles and names the smallest modulus at
    which every response stays within its tolerance of that of the stiffest ones.

    For a work folder it simulates the answer; for a calibration file the values given by --set,
    other free parameters in the middle of their interval. Finished runs are kept: stop it with
    Ctrl-C, start it again with more seeds or factors, and only what is missing is simulated.

    [bold]Example:[/bold]  grainfit stiffness beads.grainfit --factors 1,10 --seeds 5
    """
    from grainfit.work_folder.stiffness_study import stiffness_study

    with simulating() as report:
        study = stiffness_study(
            path,
            factors=show.read_numbers("factors", factors),
            seeds=seeds,
            settings=settings or (),
            workdir=workdir,
            workers=workers,
            **report,
        )
    show.print_parts(_out, study.summary())


@app.command()
def measure(
    path: Annotated[
        Path, typer.Argument(metavar="DIR-or-DUMP", help="A run folder, or a dump of particles.")
    ],
) -> None:
    """Measure the responses again, on the particles of a finished run."""
    from grainfit.work_folder.remeasure import absent_from, measure_path

    found = measure_path(path)
    show.print_measurement(_out, found)
    show.print_absences(_out, absent_from(path, found))


app.command()(watch)
app.command()(export)
app.command()(compare)
app.command()(advise)
app.command()(design)


def _write_report(workdir: Path, output: Path | None = None) -> Path:
    """Write the report and show its progress, because it takes some seconds."""
    with _err_remarks.status("report") as status:
        from grainfit.report.page import write_report

        return write_report(
            workdir, output, on_progress=lambda words: status.update(f"report: {words}")
        )


@contextmanager
def _report_of_failure(workdir: Path) -> Iterator[None]:
    """Write a report also when a calibration stops because its runs fail."""
    try:
        yield
    except RunFailedError:
        _report_if_possible(workdir)
        raise


def _report_if_possible(workdir: Path) -> None:
    """Write the report of a calibration that has ended; a fault is only a warning."""
    before = _interruption.count
    try:
        path = _write_report(workdir)
    except KeyboardInterrupt:
        reason = "stopped"
    except Exception as error:
        # The result is written and printed: a fault here must not look like a failed calibration.
        reason = " ".join(str(error).split()) or type(error).__name__
        if _interruption.count > before:
            reason = "stopped"
    else:
        _remarks.print(f"Report: {path}", highlight=False, markup=False, soft_wrap=True)
        return
    folder = shlex.quote(str(workdir))
    words = f"No report was written ({reason}). 'grainfit report {folder}' tries again."
    show.print_warning(_err, words)


def _build(file: Path) -> CalibrationSetup:
    from grainfit.calibration_file.build import build_calibration
    from grainfit.calibration_file.load import load_calibration_file

    return build_calibration(load_calibration_file(file))


def main() -> None:
    """Run the command line; every error that grainfit knows ends in one clear message."""
    _interruption.listen()
    code = _exit_code()
    # A reader may be gone, such as a pager; the exit code is not.
    with suppress(OSError):
        sys.stdout.flush()
        sys.stderr.flush()
    _interruption.exit_at_once(code)
    if code == INTERRUPTED:
        # A user's function that still runs in a thread would delay the exit of Python.
        os._exit(code)
    # At its end, Python would look through all modules for cycles.
    gc.freeze()
    # ``python -m`` exits as if killed by SIGINT if the last code executed from a text, such as that
    # of a data class, was interrupted, even if the interrupt was handled.
    exec("")
    sys.exit(code)


def _exit_code() -> int:
    if json_is_wanted():
        return _exit_code_with_json()
    try:
        app()
    except SystemExit as stop:
        return stop.code if isinstance(stop.code, int) else 0
    except GrainfitError as error:
        show.print_error(_err, error)
        return _BAD_INPUT
    except MemoryError as error:
        show.print_error(_err, _out_of_memory(error))
        return _BAD_INPUT
    except KeyboardInterrupt:
        _err.print("Interrupted.")
        return INTERRUPTED
    return 0


def _out_of_memory(error: MemoryError) -> GrainfitError:
    words = " ".join(str(error).split()).rstrip(".")
    why = f": {words[:1].lower()}{words[1:]}" if words else ""
    return GrainfitError(
        f"The machine has no memory left{why}. Use fewer particles, or end other programs."
    )


def _exit_code_with_json() -> int:
    """Run the command line; print an error as a document."""
    try:
        return int(app(standalone_mode=False) or 0)
    except _WRONG_USAGE as error:
        code, message = int(error.exit_code), error.format_message()
        print_document("error", error_document(error, message, code))
        return code
    except GrainfitError as error:
        print_document("error", error_document(error, str(error), _BAD_INPUT))
        return _BAD_INPUT
    except MemoryError as error:
        reason = _out_of_memory(error)
        print_document("error", error_document(reason, str(reason), _BAD_INPUT))
        return _BAD_INPUT
    except (KeyboardInterrupt, typer.Abort) as error:
        print_document("error", error_document(error, "Interrupted.", INTERRUPTED))
        return INTERRUPTED
