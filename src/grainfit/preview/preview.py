"""Preview of the tests of a calibration file, as a picture and as a page."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from pathlib import Path

from grainfit.bulk_tests.apparatus import ApparatusValue, apparatus_lines, apparatus_of
from grainfit.errors import Fault, InputError, RunFailedError
from grainfit.files import write_atomically, writing
from grainfit.measurement.sheet import OVERSAMPLING, save_picture, sheet
from grainfit.preview import messages
from grainfit.preview.geometry import geometry_of
from grainfit.preview.page import preview_page
from grainfit.preview.previewed_test import PreviewedTest
from grainfit.preview.scene_picture import draw_geometry
from grainfit.solvers.base import Solver

#: Widths of the picture of one test, and of each of several, pixels.
_WIDE, _NARROW = 900 * OVERSAMPLING, 560 * OVERSAMPLING


def preview_tests(
    solvers: Mapping[str, Solver],
    values: Mapping[str, float],
    seed: int,
    source: str = "",
    apparatus: Mapping[str, Collection[ApparatusValue]] | None = None,
) -> list[PreviewedTest]:
    """Return the scenes of all tests that a DEM program simulates. No program is started.

    Parameters
    ----------
    solvers : mapping of str to Solver
        By name of the test.
    values : mapping of str to float
        Values of the free parameters.
    seed : int
        Seed of the first packing.
    source : str
        Name of the file, for faults.
    apparatus : mapping of str to collection of ApparatusValue, optional
        Apparatus of each test, by its name. Without it what differs from a default is given.

    Raises
    ------
    InputError
        There is no such test, or the scene of one has faults.
    """
    found = [
        _previewed(name, solver, values, seed, (apparatus or {}).get(name))
        for name, solver in solvers.items()
        if solver.bulk_test is not None
    ]
    if not found:
        raise InputError(messages.NO_SCENE.fault("test"), source)
    return found


def _previewed(
    name: str,
    solver: Solver,
    values: Mapping[str, float],
    seed: int,
    apparatus: Collection[ApparatusValue] | None,
) -> PreviewedTest:
    try:
        scene = solver.experiment(values, seed)
        geometry = geometry_of(scene)
    except RunFailedError as error:
        raise InputError(Fault(f"test {name}", f"{error.reason.rstrip('.')}.")) from error
    cost, problem = None, ""
    try:
        cost = solver.estimate_cost(values)
    except InputError as error:
        problem = str(error)
    test = solver.bulk_test
    assert test is not None, "only bulk tests are previewed"
    if apparatus is None:
        apparatus = apparatus_of(test, None, values, solver.walls)
    lines = tuple(apparatus_lines(name, apparatus))
    return PreviewedTest(name, solver.name, scene, geometry, cost, problem, lines)


def write_picture(path: Path, name: str, tests: Sequence[PreviewedTest]) -> None:
    """Write a PNG of the scenes at their beginning."""
    width = _WIDE if len(tests) == 1 else _NARROW
    panels = [draw_geometry(test.geometry, width) for test in tests]
    listed = "; ".join(f"{test.name}: {test.cost_text}" for test in tests)
    states = "slate: walls and glued particles; vermilion: those that move; green: put later"
    words = f"{listed}. Colours of loose particles: height; {states}."
    save_picture(sheet(name, words, panels, width), path)


def write_preview(
    path: Path,
    name: str,
    tests: Sequence[PreviewedTest],
    values: Mapping[str, float],
    units: Mapping[str, str],
) -> tuple[Path, Path]:
    """Write the page and, beside it, the picture; return both paths.

    A path that ends in ``.png`` is that of the picture.

    Raises
    ------
    InputError
        A file cannot be written.
    """
    if path.suffix.lower() == ".png":
        path = path.with_suffix(".html")
    picture = path.with_suffix(".png")
    with writing(path, message=messages.CANNOT_BE_WRITTEN):
        write_atomically(path, preview_page(name, tests, values, units))
        write_picture(picture, name, tests)
    return path, picture
