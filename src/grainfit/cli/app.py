"""The commands of the command line, in the order of their help.

A command imports what it needs when it is called, so that help and status are fast.
"""

from __future__ import annotations

from typing import Annotated

import typer

from grainfit.cli.commands.advise import advise
from grainfit.cli.commands.analyse import analyse
from grainfit.cli.commands.apparatus import apparatus
from grainfit.cli.commands.ask import ask
from grainfit.cli.commands.atlas import atlas
from grainfit.cli.commands.check import check
from grainfit.cli.commands.compare import compare
from grainfit.cli.commands.design import design
from grainfit.cli.commands.estimate import estimate
from grainfit.cli.commands.export import export
from grainfit.cli.commands.materials import materials
from grainfit.cli.commands.measure import measure
from grainfit.cli.commands.new import new
from grainfit.cli.commands.photo import photo
from grainfit.cli.commands.predict import predict
from grainfit.cli.commands.preview import preview
from grainfit.cli.commands.report import report
from grainfit.cli.commands.result import result
from grainfit.cli.commands.run import run
from grainfit.cli.commands.runs import runs_app
from grainfit.cli.commands.simulate import simulate
from grainfit.cli.commands.size import size
from grainfit.cli.commands.start import start
from grainfit.cli.commands.status import status
from grainfit.cli.commands.stiffness import stiffness
from grainfit.cli.commands.watch import watch
from grainfit.cli.consoles import out
from grainfit.cli.interruption import InterruptibleCommands
from grainfit.cli.verbosity import CommandLine, Quiet, Verbose, begin

app = CommandLine(
    name="grainfit",
    cls=InterruptibleCommands,
    pretty_exceptions_enable=False,
    help="""Calibrate the material parameters of DEM models of bulk solids.

    You give laboratory measurements and an interval for every unknown
    parameter; grainfit runs the simulated tests, finds the parameters that
    reproduce the measurements, and verifies them.

    First steps:  grainfit start  (in the browser; grainfit ask in the terminal), or
    grainfit new my_material.toml  →  edit it  →
    grainfit check my_material.toml  →  grainfit run my_material.toml
    """,
)
for _command in (
    run,
    check,
    estimate,
    atlas,
    preview,
    ask,
    start,
    new,
    apparatus,
    materials,
    status,
    result,
    report,
    simulate,
    predict,
    analyse,
    stiffness,
    size,
    measure,
    photo,
    watch,
    export,
    compare,
    advise,
    design,
):
    app.command()(_command)
app.add_typer(runs_app, name="runs")


def _print_version(wanted: bool) -> None:
    if wanted:
        from importlib.metadata import version

        out.print(f"grainfit {version('grainfit')}", highlight=False)
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
