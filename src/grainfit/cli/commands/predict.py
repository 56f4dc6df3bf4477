"""The command that predicts tests that took no part in a calibration."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from grainfit.cli import console as show
from grainfit.cli.consoles import err_remarks, out
from grainfit.cli.documents import AsJson, print_document
from grainfit.cli.exit_codes import BAD_INPUT
from grainfit.cli.options import CalibrationPath, Workers, settings_option, workdir_option
from grainfit.cli.simulating import simulating

_AnswerOf = Annotated[
    Path | None,
    typer.Option(
        metavar="DIR|CARD|TOML",
        help="The material: work folder of a calibration, material card (JSON), or TOML file with "
        "values. By default the calibration of FILE.",
    ),
]
_Tests = Annotated[
    list[str] | None,
    typer.Option(
        "--test",
        metavar="NAME",
        help="Test of FILE to predict. Repeat as needed. By default every [[holdout]].",
        show_default=False,
    ),
]
_SET = "A parameter's value instead of that of the material. Repeat as needed."
_Workdir = Annotated[
    Path | None,
    workdir_option(
        "Where runs are kept.",
        "that of FILE's calibration, or FILE with .simulated for another material",
    ),
]


def predict(
    file: CalibrationPath,
    tests: _Tests = None,
    answer_of: _AnswerOf = None,
    settings: Annotated[list[str] | None, settings_option(_SET)] = None,
    workers: Workers = None,
    workdir: _Workdir = None,
    as_json: AsJson = False,
) -> None:
    """Predict tests that took no part in the fit, and compare them with what was measured.

    Each [[holdout]] of FILE is simulated at the answer and over the parameter sets that agree with
    the fitted tests. Finished runs are kept: stop it with Ctrl-C and start it again.

    Example:  grainfit predict beads.toml

    Example:  grainfit predict drum.toml --test drum --answer-of card.json
    """
    from grainfit.work_folder.predict import predict as predicted

    with simulating("reading the runs", "runs") as report:
        progress = report["on_progress"]
        found = predicted(
            file,
            answer_of=answer_of,
            tests=tests or (),
            settings=settings or (),
            workdir=workdir,
            workers=workers,
            on_progress=lambda _test, done, count: progress(done, count),
        )
    if as_json:
        print_document("prediction", found.to_dict())
    else:
        show.print_holdouts(out, found.holdouts)
        for remark in found.remarks:
            err_remarks.print(f"Note: {remark}", highlight=False, markup=False)
    if any(one.state == "failed" for one in found.holdouts):
        raise typer.Exit(BAD_INPUT)
