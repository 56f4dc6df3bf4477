"""Types of test that a DEM program simulates: all bulk tests."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from functools import partial

from grainfit.bulk_tests.abilities import HasUserFunctions
from grainfit.bulk_tests.base import BulkTest
from grainfit.bulk_tests.time_steps import usual_time_step_fraction
from grainfit.contact_models.registry import is_material_parameter
from grainfit.materials.walls import wall_of, walls_among
from grainfit.options.kinds import Choice, Name, Whole
from grainfit.options.paths import Program
from grainfit.options.tables import Key, Named, Table
from grainfit.solvers.base import Solver
from grainfit.solvers.dem.parts import parts_on_walls, walls_of
from grainfit.solvers.dem.program import DeckSolver
from grainfit.solvers.file_entry import TIMEOUT_KEY, FileEntry, TestType
from grainfit.solvers.other_names import instead_of_program
from grainfit.solvers.parameters_for import of_material

Programs = Mapping[str, type[DeckSolver]]


def simulated(test: type[BulkTest], programs: Programs) -> TestType:
    """Return the type of test of a calibration file that simulates a bulk test."""
    return TestType(
        test.type,
        (*_program_keys(tuple(programs)), *test.option_keys(), *_wall_keys(test)),
        partial(_solver, test, programs),
        test,
    )


def _program_keys(possible: tuple[str, ...]) -> tuple[Key, ...]:
    return (
        Key(
            "solver",
            Choice(possible, partial(instead_of_program, known=possible)),
            "DEM program that simulates the test.",
            required=True,
            example=f'"{possible[0]}"',
        ),
        Key(
            "ranks",
            Whole(1, 4096),
            "MPI processes of one run. Several runs at a time use a machine better than several "
            "ranks.",
            default="1",
        ),
        Key(
            "executable",
            Program(),
            "The program: a name on the search path, or a path. Only the first run starts it, not "
            "grainfit check.",
            default="found by its usual name",
        ),
        replace(TIMEOUT_KEY, default="10 minutes plus 100 times the estimated time of a run"),
    )


def _wall_keys(test: type[BulkTest]) -> tuple[Key, ...]:
    """Return the key that says what the parts of a test are made of; none without parts."""
    if test.parts == {}:
        return ()
    names = "every wall of the scene" if test.parts is None else ", ".join(test.parts)
    kind = (
        Named(Name())
        if test.parts is None
        else Table(tuple(Key(part, Name(), f"Wall of the {part}.") for part in test.parts))
    )
    return (
        Key(
            "walls",
            kind,
            f"Walls with a name, [wall.NAME], that its parts are made of. Parts: {names}.",
            default="the plain [wall], or the only one",
            example=f'{{ {next(iter(test.parts or ("blade",)))} = "steel" }}',
        ),
    )


def _solver(test: type[BulkTest], programs: Programs, entry: FileEntry) -> Solver:
    names = [key.name for key in test.option_keys()]
    options = {name: entry.options[name] for name in names if name in entry.options}
    declared = walls_among((*entry.fixed, *entry.free))
    walls = parts_on_walls(test, entry.options.get("walls", {}), declared)
    used = (None, *walls_of(test, walls))
    fixed = {
        n: v for n, v in entry.fixed.items() if is_material_parameter(n) and wall_of(n) in used
    }
    assert entry.sizes is not None, "a file with a simulated test has been checked to have sizes"
    if "time_step_fraction" not in options:
        intervals = {name: (value, value) for name, value in fixed.items()} | {
            name: ends for name, ends in entry.free.items() if wall_of(name) in used
        }
        options["time_step_fraction"] = usual_time_step_fraction(
            test(entry.sizes, **options), intervals, entry.contact_models
        )
    simulated = test(entry.sizes, **options)
    if isinstance(simulated, HasUserFunctions):
        simulated = simulated.with_targets(entry.responses)
    solver = programs[entry.options["solver"]](
        simulated,
        fixed,
        entry.options.get("ranks", 1),
        entry.options.get("executable"),
        entry.contact_models,
        walls,
    )
    return of_material(solver, entry.free)
