"""The command that writes a first calibration file."""

from __future__ import annotations

import shlex
from pathlib import Path
from typing import Annotated

import typer

from grainfit.cli import console as show
from grainfit.cli import messages
from grainfit.cli.asking import can_ask, choose
from grainfit.cli.completion import complete_material
from grainfit.cli.consoles import out_remarks
from grainfit.cli.help_texts import shown_default
from grainfit.cli.options import TestSolver
from grainfit.errors import InputError
from grainfit.files import writing
from grainfit.materials.starting_materials import read_starting_material, starting_material_names

_Tests = Annotated[
    list[str] | None,
    typer.Option(
        metavar="NAME",
        help="Laboratory test to calibrate with, such as heap or draw_down, or an instrument, such "
        "as granudrum (see 'grainfit apparatus'). Repeat as needed. "
        f"{shown_default('heap; on a terminal it asks')}",
        show_default=False,
    ),
]
_Material = Annotated[
    str | None,
    typer.Option(
        metavar="NAME",
        help="Material whose published values it begins with, sources in its comments, such as "
        "wheat, soybeans or dry_sand (see 'grainfit materials'). A synonym is enough. "
        f"{shown_default('glass beads; on a terminal it asks')}",
        show_default=False,
        autocompletion=complete_material,
    ),
]


def new(
    file: Annotated[Path, typer.Argument(metavar="FILE")] = Path("calibration.toml"),
    test: _Tests = None,
    material: _Material = None,
    solver: TestSolver = "lammps",
) -> None:
    """Write a commented calibration file to start from.

    On a terminal it asks for material and tests, unless they are given.

    Example:  grainfit new pellets.toml --material plastic --solver liggghts
    """
    from grainfit.calibration_file.starter import starter_file

    if not file.exists() and material is None and not test and can_ask():
        [material], test = _ask_for_material(), _ask_for_tests()
    begin = None if material is None else read_starting_material(material)
    _write_new(file, starter_file(test or ["heap"], begin, solver))
    if begin is not None:
        show.print_starting_intervals(out_remarks, begin)
    out_remarks.print(messages.WRITTEN(file=shlex.quote(str(file))), highlight=False, markup=False)


def _write_new(file: Path, text: str) -> None:
    with writing(file):
        try:
            with file.open("x", encoding="utf-8") as target:
                target.write(text)
        except FileExistsError:
            raise InputError(messages.EXISTS.fault("", file=str(file))) from None


def _ask_for_material() -> list[str]:
    titles = {name: read_starting_material(name).title for name in starting_material_names()}
    return choose("Material", titles, "glass_beads")[:1]


def _ask_for_tests() -> list[str]:
    from grainfit.bulk_tests.registry import bulk_tests

    titles = {name: test.title for name, test in bulk_tests().items()}
    return choose("Tests, with commas", titles, "heap")
