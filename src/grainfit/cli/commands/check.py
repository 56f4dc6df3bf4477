"""The command that validates a calibration file."""

from __future__ import annotations

from typing import Annotated

import typer

from grainfit.cli import console as show
from grainfit.cli.consoles import out
from grainfit.cli.documents import AsJson, plan_document, print_document
from grainfit.cli.exit_codes import BAD_INPUT
from grainfit.cli.options import CalibrationPath


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
    from grainfit.calibration_file.build import load_calibration
    from grainfit.calibration_file.plan import describe_plan

    plan = describe_plan(load_calibration(file), call_scenes=not no_code)
    if as_json:
        print_document("check", plan_document(file, plan))
    else:
        show.print_plan(out, plan)
    if plan.problems:
        raise typer.Exit(BAD_INPUT)
