"""Arguments and options that several commands share."""

from __future__ import annotations

import errno
import os
from pathlib import Path
from typing import Annotated, Any

import typer

from grainfit.cli import messages
from grainfit.cli.completion import complete_setting
from grainfit.cli.help_texts import WORK_FOLDER, shown_default
from grainfit.errors import InputError
from grainfit.files import writing

CalibrationPath = Annotated[
    Path, typer.Argument(metavar="FILE", help="Calibration file (TOML).", show_default=False)
]
#: A calibration file that need not be there yet.
NewCalibrationPath = Annotated[
    Path,
    typer.Argument(metavar="FILE", help="Calibration file (TOML) to begin, or to go on with."),
]
TestSolver = Annotated[
    str, typer.Option(metavar="NAME", help="DEM program of the tests: lammps, liggghts or yade.")
]
WorkFolder = Annotated[
    Path,
    typer.Argument(metavar="DIR", help="Work folder of a calibration.", show_default=False),
]
Workers = Annotated[int | None, typer.Option(metavar="N", min=1, help="Runs at a time.")]
Seed = Annotated[int, typer.Option(metavar="N", min=1, max=900_000_000, help="Insertion seed.")]
OpenAfterwards = Annotated[
    bool, typer.Option("--open", help="Show it in the web browser afterwards.")
]


def workdir_option(
    text: str = "Where runs and results are kept.", default: str = WORK_FOLDER
) -> Any:
    """Return the option of the folder where a command keeps its runs."""
    return typer.Option("--workdir", metavar="DIR", help=f"{text} {shown_default(default)}")


Workdir = Annotated[Path | None, workdir_option("Where runs and results are kept.")]


def settings_option(text: str) -> Any:
    """Return the option of the values of parameters."""
    return typer.Option(
        "--set",
        metavar="NAME=VALUE",
        autocompletion=complete_setting,
        help=text,
        show_default=False,
    )


def output_option(metavar: str, text: str, *names: str) -> Any:
    """Return the option of the file that a command writes; its folder is there before it begins.

    A file name has the ending of the metavar, if that has one. The option is called ``--output``
    by default. A command that has it asks `require_free`, too, also of a default name.
    """
    names = names or ("--output", "-o")
    kind = Path(metavar).suffix

    def checked(path: Path | None) -> Path | None:
        found = require_place(path)
        return require_kind(found, kind, names[0]) if kind else found

    return typer.Option(*names, metavar=metavar, help=text, callback=checked)


Force = Annotated[bool, typer.Option("--force", help="Replace a file that exists.")]
#: What every page and every picture of grainfit has near its beginning, and within how many bytes.
_OF_GRAINFIT = b'<meta name="generator" content="grainfit', b"tEXtSoftware\0grainfit"
_HEAD = 1000


def require_free(path: Path | None, *, force: bool) -> None:
    """Raise `InputError` where a command would replace a file without being asked to.

    Pages and pictures of grainfit are made again and again; a pipe or a device is written to, not
    replaced.
    """
    if path is None or force or not path.is_file():
        return
    with writing(path), path.open("rb") as file:
        begins = file.read(_HEAD)
    if not any(mark in begins for mark in _OF_GRAINFIT):
        raise InputError(messages.NOT_REPLACED.fault("", file=str(path)))


def require_kind(path: Path | None, kind: str, option: str = "--output") -> Path | None:
    """Return the path of a file to write; raise `InputError` where its ending is of another kind.

    A name without an ending, such as that of a device, may be of any.
    """
    if path is not None and path.suffix.lower() not in ("", kind):
        raise InputError(messages.OTHER_KIND.fault(option, file=str(path), kind=kind))
    return path


def require_place(path: Path | None) -> Path | None:
    """Return the path of a file to write; raise `InputError` where there can be none."""
    if path is not None:
        with writing(path):
            if path.is_dir():
                raise IsADirectoryError(errno.EISDIR, os.strerror(errno.EISDIR))
            if not path.absolute().parent.is_dir():
                raise FileNotFoundError(errno.ENOENT, os.strerror(errno.ENOENT))
    return path


def open_in_browser(path: Path) -> None:
    """Show a page in the web browser."""
    import webbrowser

    webbrowser.open(path.absolute().as_uri())
