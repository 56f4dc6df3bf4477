"""The ``[[test]]`` tables of the calibration file: one layout for each type of test."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass
from typing import Any

from grainfit.calibration_file.content import TestSpecification
from grainfit.calibration_file.files import Function, Located, Program, find_function_inside
from grainfit.calibration_file.targets import TargetTable
from grainfit.options.kinds import (
    Choice,
    Flag,
    Kind,
    ListOf,
    Name,
    Quantity,
    Schema,
    Text,
    Whole,
    note_wrong_kind,
)
from grainfit.options.places import Place, show
from grainfit.options.tables import Finish, Key, Named, Table, Values

_LENGTH = Quantity("m", above_zero=True, highest=1e3)
_LENGTH_OR_ZERO = Quantity("m", lowest=0.0, highest=1e3)
_FRICTION = Quantity("", lowest=0.0, highest=10.0)
_DURATION = Quantity("s", above_zero=True)

HEAP_TARGETS = Table(
    (
        Key(
            "bulk_density",
            TargetTable("kg/m^3"),
            "Bulk density in the filled cylinder.",
            example='{ value = "1500 kg/m^3", uncertainty = "1 %" }',
        ),
        Key(
            "angle_of_repose",
            TargetTable("deg"),
            "Angle of repose of the heap, in degrees.",
            example='{ value = "22 deg", uncertainty = "0.5 deg" }',
        ),
    )
)

#: Options of `grainfit.bulk_tests.heap.HeapTest`; d is the Sauter diameter of the particles.
HEAP_OPTIONS = (
    Key("particle_count", Whole(1), "Particles rained in; as many as fill the cylinder."),
    Key("cylinder_radius", _LENGTH, "Inner radius of the cylinder; 6 d.", example='"60 mm"'),
    Key("plate_radius", _LENGTH, "Radius of the plate; 16 d.", example='"160 mm"'),
    Key(
        "rim_height",
        _LENGTH_OR_ZERO,
        "Height of a rim around the plate; 0, a free edge.",
        example='"10 mm"',
    ),
    Key(
        "strike_off_height",
        _LENGTH,
        "Particles with their centre above are taken away before the lift; 10.5 d.",
        example='"105 mm"',
    ),
    Key(
        "bulk_density_bottom",
        _LENGTH,
        "The bulk density is measured from this height on; 1 d.",
        example='"10 mm"',
    ),
    Key(
        "bulk_density_top",
        _LENGTH,
        "The bulk density is measured up to this height; 9 d.",
        example='"90 mm"',
    ),
    Key(
        "lift_speed",
        Quantity("m/s", above_zero=True),
        "Speed of the cylinder; 0.05 m/s for d = 10 mm. It decides the angle of repose and must be "
        "that of the laboratory.",
        example='"0.05 m/s"',
    ),
    Key(
        "lift_height",
        _LENGTH,
        "Longest way of the cylinder; 10 d. The lift ends earlier once the cylinder is clear.",
        example='"100 mm"',
    ),
    Key(
        "plate_sliding_friction",
        _FRICTION,
        "Sliding friction between particles and plate; 0.5.",
        example="0.5",
    ),
    Key(
        "plate_rolling_friction",
        _FRICTION,
        "Rolling friction between particles and plate; as between two particles.",
        example="0.67",
    ),
    Key("gravity", Quantity("m/s^2", above_zero=True), "Gravity; 9.81 m/s^2.", example="9.81"),
    Key(
        "time_step_fraction",
        Quantity("", highest=1.0, above_zero=True),
        "Time step over the Rayleigh time step; 0.12. With larger ones, beds of high rolling "
        "friction may never come to rest.",
        example="0.12",
    ),
    Key(
        "settling_time_limit",
        _DURATION,
        "Longest simulated time in which the bed and the heap may come to rest; ten times the "
        "time of fall.",
        example='"2 s"',
    ),
    Key("views", Whole(1, 360), "Silhouettes the angle of repose is measured on; 12."),
)


def _specification(values: Values, place: Place) -> TestSpecification | None:
    targets = values.pop("targets", None)
    if targets is not None and not targets:
        place.at("targets").fault("are empty.", "Give at least one target.")
    if not targets or None in values.values() or None in targets.values():
        return None
    name = values.pop("name", values["type"])
    return TestSpecification(name, values.pop("type"), values, tuple(targets.values()))


def _test(
    test_type: str, targets: Kind, example: str, *keys: Key, finish: Finish = _specification
) -> Table:
    return Table(
        (
            Key("type", Choice((test_type,)), "Which test.", required=True),
            Key("name", Name(), "Its name, when there are several tests; unique."),
            *keys,
            Key(
                "targets",
                targets,
                "What was measured: one entry for each response.",
                required=True,
                example=example,
            ),
        ),
        finish,
    )


def _command(values: Values, place: Place) -> TestSpecification | None:
    if "responses" in values and "evaluate" in values:
        place.at("responses").fault(
            "is given beside evaluate.",
            "Keep the JSON file that your command writes, or the function that evaluates the run.",
        )
    folder, evaluate = values.get("folder"), values.get("evaluate")
    if folder and evaluate:
        values["evaluate"] = find_function_inside(evaluate, folder, place.at("evaluate"))
    return _specification(values, place)


_TIMEOUT = Key("timeout", _DURATION, "Longest wall time of a run.", example='"10 min"')
_OWN_TARGETS = Named(TargetTable(), shortest=1)
_OWN_EXAMPLE = '{ angle = { value = 36.0, uncertainty = 0.5, unit = "deg" } }'

#: The layout of a test by its type.
TEST_TYPES: dict[str, Table] = {
    "heap": _test(
        "heap",
        HEAP_TARGETS,
        '{ angle_of_repose = { value = "22 deg", uncertainty = "0.5 deg" } }',
        Key(
            "solver",
            Choice(("lammps", "liggghts")),
            "DEM program that simulates the test.",
            required=True,
            example='"lammps"',
        ),
        Key("ranks", Whole(1, 4096), "MPI processes of one run; 1 by default."),
        Key("executable", Program(), "The program, where it is not found by its usual name."),
        _TIMEOUT,
        *HEAP_OPTIONS,
    ),
    "command": _test(
        "command",
        _OWN_TARGETS,
        _OWN_EXAMPLE,
        Key(
            "folder",
            Located(is_folder=True),
            "Your model: its files are copied into the folder of every run.",
            required=True,
            example='"model"',
        ),
        Key(
            "command",
            ListOf(Text()),
            "Program and arguments, started in the copy; {{ ... }} is filled in.",
            required=True,
            example='["lmp", "-in", "in.deck"]',
        ),
        Key(
            "templates",
            ListOf(Text()),
            "Files of the folder, or patterns of them, that Jinja2 fills in; *.j2 by default.",
            example='["*.j2"]',
        ),
        Key(
            "responses",
            Text(),
            "JSON file that the command writes: responses by name; responses.json by default.",
            example='"responses.json"',
        ),
        Key(
            "evaluate",
            Text(),
            "Instead of responses: a function in a file of the folder that gets the folder of the "
            "run and returns the responses by name.",
            example='"evaluate.py:measure"',
        ),
        _TIMEOUT,
        finish=_command,
    ),
    "python": _test(
        "python",
        _OWN_TARGETS,
        _OWN_EXAMPLE,
        Key(
            "function",
            Function(),
            "Function that is called with the parameters by name and a seed, and returns the "
            "responses by name.",
            required=True,
            example='"model.py:simulate"',
        ),
    ),
    "table": _test(
        "table",
        _OWN_TARGETS,
        _OWN_EXAMPLE,
        Key(
            "file",
            Located(),
            "CSV file of recorded runs: one column for each free parameter and each response.",
            required=True,
            example='"runs.csv"',
        ),
        Key(
            "nearest",
            Flag(),
            "Whether the nearest recorded run stands for one that was not recorded; false.",
        ),
    ),
}


@dataclass(frozen=True)
class Tests(Kind):
    """All tests of the file."""

    def read(self, value: Any, place: Place) -> tuple[TestSpecification | None, ...] | None:
        """Read every test; those that are faulty are None."""
        if not isinstance(value, list):
            note_wrong_kind(value, place, "a list of tables", "Write [[test]], in two brackets.")
            return None
        if not value:
            place.fault("is empty.", "Give at least one [[test]].")
        _note_equal_names(value, place)
        return tuple(self._read_one(entry, place.at(i)) for i, entry in enumerate(value))

    def _read_one(self, value: Any, place: Place) -> TestSpecification | None:
        if not isinstance(value, dict):
            note_wrong_kind(value, place, "a table", "Write [[test]] and its keys below.")
            return None
        if "type" not in value:
            place.at("type").fault("is missing.", f"Choose one of: {', '.join(TEST_TYPES)}.")
            return None
        test_type = Choice(tuple(TEST_TYPES)).read(value["type"], place.at("type"))
        if test_type is None:
            return None
        specification: TestSpecification | None = TEST_TYPES[test_type].read(value, place)
        return specification

    def schema(self) -> Schema:
        """Return the JSON Schema of the list of tests."""
        kinds = [table.schema() for table in TEST_TYPES.values()]
        return {"type": "array", "items": {"oneOf": kinds}, "minItems": 1}


def _note_equal_names(tests: list[Any], place: Place) -> None:
    names = [
        test.get("name", test.get("type")) if isinstance(test, dict) else None for test in tests
    ]
    counts = Counter(name for name in names if isinstance(name, str))
    for index, name in enumerate(names):
        if isinstance(name, str) and counts[name] > 1 and name in names[:index]:
            place.at(index, "name").fault(
                f"{show(name)} is the name of another test too.",
                'Give each test a name of its own: name = "...".',
            )
