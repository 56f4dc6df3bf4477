"""The ``[[test]]`` tables of the calibration file: one layout for each type of test."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

from grainfit.bulk_tests.base import BulkTest
from grainfit.bulk_tests.registry import BUILT_IN
from grainfit.bulk_tests.response_info import CurveInfo
from grainfit.calibration_file.content import TestSpecification
from grainfit.calibration_file.correlations import CORRELATIONS, note_bad_correlations
from grainfit.calibration_file.curves import (
    CURVE_EXAMPLE,
    CURVE_OF_TABLE,
    PLANNED_CURVE,
    CurveTable,
    OwnTarget,
    RefusedCurve,
)
from grainfit.calibration_file.instruments import apparatus_key, with_instrument
from grainfit.calibration_file.targets import PlannedTargetTable, TargetTable
from grainfit.formatting import in_a_row
from grainfit.options.kinds import Choice, Kind, Name, Schema, Whole, note_wrong_kind
from grainfit.options.places import Place, show
from grainfit.options.tables import Key, Named, Table, Values
from grainfit.problem import CurveTarget
from grainfit.solvers.file_entry import TestType
from grainfit.solvers.other_names import instead_of_test
from grainfit.solvers.registry import types_of_test

_OWN_EXAMPLE = '{ angle = { value = 36.0, uncertainty = 0.5, unit = "deg" } }'

_REPEATS = Key(
    "repeats",
    Whole(1),
    "Runs with different seeds whose mean is one evaluation.",
    default="1",
    example="3",
)


def layout_of_test(kind: TestType, *, planned: bool = False) -> Table:
    """Return the layout of a ``[[test]]`` of one type; planned tests need no measured values."""
    targets, example = _targets(kind, planned=planned)
    apparatus = apparatus_key(kind.name)
    return Table(
        (
            Key("type", Choice((kind.name,)), "Type of the test.", required=True),
            Key("name", Name(), "Its name, when there are several tests; unique."),
            *filter(None, (apparatus,)),
            *kind.keys,
            Key(
                "targets",
                targets,
                "What was measured: one entry for each response.",
                required=not planned,
                example=example,
            ),
            CORRELATIONS,
            _REPEATS,
        ),
        partial(_planned if planned else _specification, kind),
        _homes(lambda test: [key.name for key in test.option_keys()]),
    )


def _homes(names: Callable[[type[BulkTest]], Iterable[str]]) -> dict[str, str]:
    """Return the types of test that have each name, in words."""
    types: dict[str, list[str]] = {}
    for kind, test in BUILT_IN.items():
        for name in names(test):
            types.setdefault(name, []).append(f'"{kind}"')
    return {name: f"a test of type {in_a_row(found, 'or')}" for name, found in types.items()}


def _targets(kind: TestType, *, planned: bool) -> tuple[Kind, str]:
    """Return the layout of a test's targets, and an example."""
    test, table = kind.bulk_test, PlannedTargetTable if planned else TargetTable
    if test is None or not test.responses:
        refused = PLANNED_CURVE if planned else CURVE_OF_TABLE
        allowed = kind.has_curves and not planned
        curve: CurveTable | RefusedCurve = CurveTable() if allowed else refused
        return Named(OwnTarget(table(), curve), shortest=1), _OWN_EXAMPLE
    keys = tuple(
        Key(name, table(info.possible), f"{info.words}.", example=info.example)
        for name, info in test.responses.items()
    )
    curves = tuple(
        Key(
            name,
            PLANNED_CURVE if planned else _curve_table(info),
            f"{info.words}.",
            example=CURVE_EXAMPLE,
        )
        for name, info in test.curves.items()
    )
    homes = _homes(lambda other: [*other.responses, *other.curves])
    table_of_targets = Table(keys + curves, homes=homes, answers=test.enter_instead)
    return table_of_targets, f"{{ {keys[-1].name} = {keys[-1].example} }}"


def _curve_table(info: CurveInfo) -> CurveTable:
    return CurveTable(info.unit, info.coordinate_unit, info.coordinate)


def _specification(kind: TestType, values: Values, place: Place) -> TestSpecification | None:
    if kind.check is not None:
        kind.check(values, place)
    targets = values.pop("targets", None)
    if targets is not None and not targets:
        place.at("targets").fault("are empty.", "Give at least one target.")
    if not targets or None in values.values() or None in targets.values():
        return None
    correlations = values.pop(CORRELATIONS.name, ())
    curves = [target for target in targets.values() if isinstance(target, CurveTarget)]
    numbers = [target for target in targets.values() if not isinstance(target, CurveTarget)]
    names = [target.name for target in numbers]
    if note_bad_correlations(correlations, names, place.at(CORRELATIONS.name)):
        return None
    name, repeats = values.pop("name", values["type"]), values.pop(_REPEATS.name, 1)
    return TestSpecification(
        name,
        values.pop("type"),
        values,
        tuple(numbers),
        correlations=correlations,
        curves=tuple(curves),
        repeats=repeats,
    )


def _planned(kind: TestType, values: Values, place: Place) -> TestSpecification | None:
    if kind.check is not None:
        kind.check(values, place)
    targets = values.pop("targets", {})
    if targets is None or None in values.values() or None in targets.values():
        return None
    # Checked alone: a plan compares tests by the errors of single responses.
    correlations = values.pop(CORRELATIONS.name, ())
    responses = targets or kind.bulk_test.responses if kind.bulk_test else targets
    if note_bad_correlations(correlations, list(responses), place.at(CORRELATIONS.name)):
        return None
    # Checked alone, too: the runs of a plan are single ones.
    values.pop(_REPEATS.name, 1)
    name = values.pop("name", values["type"])
    return TestSpecification(name, values.pop("type"), values, (), planned=targets)


@dataclass(frozen=True)
class Tests(Kind):
    """All tests of the file.

    Parameters
    ----------
    planned : bool
        Read a file from before the laboratory: targets and their values may be missing.
    """

    planned: bool = False

    def read(self, value: Any, place: Place) -> tuple[TestSpecification | None, ...] | None:
        """Read every test; those that are faulty are None."""
        if not isinstance(value, list):
            note_wrong_kind(value, place, "a list of tables", "Write [[test]], in two brackets.")
            return None
        if not value:
            place.fault("is empty.", "Give at least one [[test]].")
        _note_equal_names(value, place)
        tests = [self._read_one(entry, place.at(i)) for i, entry in enumerate(value)]
        return tuple(test and replace(test, number=i) for i, test in enumerate(tests))

    def _read_one(self, value: Any, place: Place) -> TestSpecification | None:
        if not isinstance(value, dict):
            note_wrong_kind(value, place, "a table", "Write [[test]] and its keys below.")
            return None
        kinds = types_of_test()
        if "type" not in value:
            place.at("type").fault("is missing.", f"Choose one of: {', '.join(kinds)}.")
            return None
        chosen = Choice(tuple(kinds), instead_of_test).read(value["type"], place.at("type"))
        if chosen is None:
            return None
        layout = layout_of_test(kinds[chosen], planned=self.planned)
        whole, instrument = with_instrument(value, place)
        specification: TestSpecification | None = layout.read(whole, place)
        if specification is None or instrument is None:
            return specification
        given = tuple(name for name in specification.options if name in value)
        return replace(specification, instrument=instrument, given=given)

    def schema(self) -> Schema:
        """Return the JSON Schema of the list of tests, those of other packages left out."""
        kinds = [layout_of_test(kind).schema() for kind in types_of_test(built_in=True).values()]
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
                'Give each test its own name: name = "...".',
            )
