"""The command that draws the tests before they run."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from grainfit.cli import console as show
from grainfit.cli.consoles import out
from grainfit.cli.help_texts import shown_default
from grainfit.cli.options import (
    CalibrationPath,
    Force,
    OpenAfterwards,
    Seed,
    open_in_browser,
    output_option,
    require_free,
    settings_option,
)

_SET_DEFAULT = shown_default("the middle of its interval")
_SET = f"A parameter's value, units allowed. Repeat as needed. {_SET_DEFAULT}"
_OUTPUT_DEFAULT = shown_default("the file's name with .preview.html, here")
_OUTPUT = f"The page, or FILE.png for the picture; the other one is beside it. {_OUTPUT_DEFAULT}"


def preview(
    file: CalibrationPath,
    settings: Annotated[list[str] | None, settings_option(_SET)] = None,
    seed: Seed = 1,
    output: Annotated[Path | None, output_option("FILE", _OUTPUT)] = None,
    open_it: OpenAfterwards = False,
    force: Force = False,
) -> None:
    """Draw every test before it runs: geometry, first packing, stages, and the cost of a run.

    Writes a page in three dimensions, and a picture (PNG). No solver is needed or started; the
    function of a scene of your own is called. Measured values may be missing.
    """
    path = output or Path(f"{file.stem}.preview.html")
    require_free(path.with_suffix(".html"), force=force)
    require_free(path.with_suffix(".png"), force=force)
    from grainfit.calibration_file.apparatus import apparatus_of_tests
    from grainfit.calibration_file.planned import load_tests
    from grainfit.calibration_file.settings import set_values
    from grainfit.contact_models.registry import material_units
    from grainfit.preview.preview import preview_tests, write_preview

    planned = load_tests(file)
    values = set_values(planned.file, settings or [])
    material = {**planned.file.fixed, **values}
    apparatus = apparatus_of_tests(planned.file, planned.solvers, material)
    tests = preview_tests(planned.solvers, values, seed, str(file), apparatus)
    units = material_units(values) | {p.name: p.unit for p in planned.file.parameters}
    page, picture = write_preview(path, planned.file.name, tests, values, units)
    show.print_preview(out, tests, page, picture)
    if open_it:
        open_in_browser(page)
