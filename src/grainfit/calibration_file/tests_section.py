"""The ``[[test]]`` and ``[[holdout]]`` tables of the calibration file: one layout for each type."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any, Literal

from grainfit.bulk_tests import messages as test_messages
from grainfit.bulk_tests.base import BulkTest
from grainfit.bulk_tests.instrument import Instrument, instrument_names, read_instrument
from grainfit.bulk_tests.registry import BUILT_IN
from grainfit.bulk_tests.response_info import CurveInfo, ResponseInfo
from grainfit.calibration_file import messages
from grainfit.calibration_file.balances import BALANCE, WEIGHED, balance_table
from grainfit.calibration_file.content import TestSpecification
from grainfit.calibration_file.curves import (
    CURVE_EXAMPLE,
    CURVE_OF_TABLE,
    PLANNED_CURVE,
    CurveTable,
    OwnTarget,
    RefusedCurve,
)
from grainfit.calibration_file.draw_downs import DRAWN_DOWN, draw_down_table
from grainfit.calibration_file.drums import FILMED, drum_tables
from grainfit.calibration_file.photographed import PHOTOS
from grainfit.calibration_file.photos import PHOTOGRAPHED, photo_table
from grainfit.calibration_file.targets import OrMeasured, PlannedTargetTable, TargetTable
from grainfit.errors import InputError
from grainfit.formatting import in_a_row
from grainfit.options.kinds import (
    Choice,
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
from grainfit.options.tables import Key, Named, Table, Values
from grainfit.problem import CurveTarget, Target
from grainfit.problem.correlations import Correlation, correlation_faults
from grainfit.solvers.file_entry import TestType
from grainfit.solvers.other_names import instead_of_test
from grainfit.solvers.registry import types_of_test

#: What the tables are for: to be fitted, planned before the laboratory, or predicted.
Use = Literal["fit", "plan", "holdout"]
_OWN_EXAMPLE = '{ angle = { value = 36.0, uncertainty = 0.5, unit = "deg" } }'

_REPEATS = Key(
    "repeats",
    Whole(1),
    "Runs with different seeds whose mean is one evaluation.",
    default="1",
    example="3",
)
#: Its limits, which are no coefficients, are those of every interface: see `correlation_faults`.
_COEFFICIENT = Quantity("")


def layout_of_test(
    kind: TestType, use: Use = "fit", test: Mapping[str, Any] | None = None
) -> Table:
    """Return the layout of a test of one type; only those to be fitted need measured values.

    Targets that are measured need the keys of their test, as they are written.
    """
    targets, example = _targets(kind, use, test or {})
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
                required=use == "fit",
                example=example,
            ),
            *(() if use == "holdout" else (CORRELATIONS,)),
            _REPEATS,
        ),
        partial(_READERS[use], kind),
        _homes(lambda test: [key.name for key in test.option_keys()]),
    )


def _homes(names: Callable[[type[BulkTest]], Iterable[str]]) -> dict[str, str]:
    """Return the types of test that have each name, in words."""
    types: dict[str, list[str]] = {}
    for kind, test in BUILT_IN.items():
        for name in names(test):
            types.setdefault(name, []).append(f'"{kind}"')
    return {name: f"a test of type {in_a_row(found, 'or')}" for name, found in types.items()}


def _targets(kind: TestType, use: Use, written: Mapping[str, Any]) -> tuple[Kind, str]:
    """Return the layout of a test's targets, and an example."""
    test, table = kind.bulk_test, PlannedTargetTable if use == "plan" else TargetTable
    refused = PLANNED_CURVE if use == "plan" else CURVE_OF_TABLE
    if test is None or not test.responses:
        allowed = kind.has_curves and use != "plan"
        curve: CurveTable | RefusedCurve = CurveTable() if allowed else refused
        return Named(OwnTarget(table(), curve), shortest=1), _OWN_EXAMPLE

    def of_number(name: str, info: ResponseInfo) -> Kind:
        return _or_measured(kind, name, table(info.possible), written)

    def of_curve(name: str, info: CurveInfo) -> Kind:
        curve = CurveTable(info.unit, info.coordinate_unit, info.coordinate, info)
        return _or_measured(kind, name, curve, written)

    keys = tuple(
        Key(name, of_number(name, info), f"{info.words}.", example=info.example)
        for name, info in test.responses.items()
    )
    curves = tuple(
        Key(
            name,
            refused if use == "plan" else of_curve(name, info),
            f"{info.words}.",
            example=CURVE_EXAMPLE,
        )
        for name, info in test.curves.items()
    )
    homes = _homes(lambda other: [*other.responses, *other.curves])
    table_of_targets = Table(keys + curves, homes=homes, answers=test.enter_instead)
    return table_of_targets, f"{{ {keys[-1].name} = {keys[-1].example} }}"


def _or_measured(
    kind: TestType,
    response: str,
    otherwise: TargetTable | CurveTable,
    written: Mapping[str, Any],
) -> Kind:
    """Return the kind of a target that may also be measured on pictures, or by a balance."""
    planned = isinstance(otherwise, PlannedTargetTable)
    measured: dict[str, Table] = {}
    if response in PHOTOGRAPHED.get(kind.name, ()):
        measured[PHOTOS] = photo_table(otherwise)
    if response in DRAWN_DOWN.get(kind.name, ()) and isinstance(otherwise, TargetTable):
        measured[PHOTOS] = draw_down_table(otherwise, written)
    if response in FILMED.get(kind.name, ()) and isinstance(otherwise, TargetTable):
        measured |= drum_tables(otherwise, written)
    if response in WEIGHED and not planned:
        measured[BALANCE] = balance_table(response)
    return OrMeasured(otherwise, measured) if measured else otherwise


def _numbers_and_curves(
    kind: TestType, targets: Mapping[str, Any], values: Values, place: Place
) -> tuple[tuple[Target, ...], tuple[CurveTarget, ...]]:
    """Return both kinds of targets, and set the options that measured curves need.

    An option that has another value is noted.
    """
    curves = tuple(target for target in targets.values() if isinstance(target, CurveTarget))
    numbers = tuple(target for target in targets.values() if not isinstance(target, CurveTarget))
    needed = kind.bulk_test.curve_options if curves and kind.bulk_test is not None else {}
    for name, value in needed.items():
        if values.get(name) not in (None, value):
            place.at(name).fault(messages.CURVE_NEEDS, curve=curves[0].name, name=name, value=value)
        values[name] = value
    return numbers, curves


def _specification(kind: TestType, values: Values, place: Place) -> TestSpecification | None:
    if kind.check is not None:
        kind.check(values, place)
    targets = values.pop("targets", None)
    if targets is not None and not targets:
        place.at("targets").fault(messages.NO_TARGETS)
    if not targets or None in values.values() or None in targets.values():
        return None
    correlations = values.pop(CORRELATIONS.name, ())
    numbers, curves = _numbers_and_curves(kind, targets, values, place)
    names = [target.name for target in numbers]
    if note_bad_correlations(correlations, names, place.at(CORRELATIONS.name)):
        return None
    name, repeats = values.pop("name", values["type"]), values.pop(_REPEATS.name, 1)
    return TestSpecification(
        name,
        values.pop("type"),
        values,
        numbers,
        correlations=correlations,
        curves=curves,
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


def _holdout(kind: TestType, values: Values, place: Place) -> TestSpecification | None:
    if kind.check is not None:
        kind.check(values, place)
    targets = values.pop("targets", {})
    if targets is None or None in values.values() or None in targets.values():
        return None
    name, repeats = values.pop("name", values["type"]), values.pop(_REPEATS.name, 1)
    numbers, curves = _numbers_and_curves(kind, targets, values, place)
    type_ = values.pop("type")
    return TestSpecification(name, type_, values, numbers, curves=curves, repeats=repeats)


_READERS = {"fit": _specification, "plan": _planned, "holdout": _holdout}


@dataclass(frozen=True)
class Tests(Kind):
    """All tests of the file, or all its hold-outs.

    Parameters
    ----------
    use : {"fit", "plan", "holdout"}
        What they are for; targets may be missing unless they are to be fitted.
    """

    use: Use = "fit"

    @property
    def _table(self) -> str:
        return "[[holdout]]" if self.use == "holdout" else "[[test]]"

    def read(self, value: Any, place: Place) -> tuple[TestSpecification | None, ...] | None:
        """Read every test; those that are faulty are None."""
        if not isinstance(value, list):
            remedy = f"Write {self._table}, in two brackets."
            note_wrong_kind(value, place, "a list of tables", remedy)
            return None
        if not value:
            place.fault(messages.EMPTY_LIST, table=self._table)
        _note_equal_names(value, place)
        tests = [self._read_one(entry, place.at(i)) for i, entry in enumerate(value)]
        return tuple(test and replace(test, number=i) for i, test in enumerate(tests))

    def _read_one(self, value: Any, place: Place) -> TestSpecification | None:
        if not isinstance(value, dict):
            note_wrong_kind(value, place, "a table", f"Write {self._table} and its keys below.")
            return None
        kinds = types_of_test()
        if "type" not in value:
            place.at("type").fault(messages.NO_TYPE, known=", ".join(kinds))
            return None
        chosen = Choice(tuple(kinds), instead_of_test).read(value["type"], place.at("type"))
        if chosen is None:
            return None
        whole, instrument = with_instrument(value, place)
        layout = layout_of_test(kinds[chosen], self.use, whole)
        specification: TestSpecification | None = layout.read(whole, place)
        if specification is None or instrument is None:
            return specification
        given = tuple(name for name in specification.options if name in value)
        return replace(specification, instrument=instrument, given=given)

    def schema(self) -> Schema:
        """Return the JSON Schema of the list, tests of other packages left out."""
        if self.use == "holdout":
            # That of tests once more would double the file; targets alone may be missing.
            bare = {"type": "object", "required": ["type"], "not": {"required": ["targets"]}}
            items = {"anyOf": [{"$ref": "#/properties/test/items"}, bare]}
            return {"type": "array", "items": items, "minItems": 1}
        types = types_of_test(built_in=True).values()
        kinds = [layout_of_test(kind, self.use).schema() for kind in types]
        return {"type": "array", "items": {"oneOf": kinds}, "minItems": 1}


def _note_equal_names(tests: list[Any], place: Place) -> None:
    names = [
        test.get("name", test.get("type")) if isinstance(test, dict) else None for test in tests
    ]
    counts = Counter(name for name in names if isinstance(name, str))
    for index, name in enumerate(names):
        if isinstance(name, str) and counts[name] > 1 and name in names[:index]:
            place.at(index, "name").fault(messages.NAME_OF_ANOTHER_TEST, name=show(name))


@dataclass(frozen=True)
class CorrelatedPair(Kind):
    """Two responses and the correlation of the errors of their measured values."""

    def read(self, value: Any, place: Place) -> Correlation | None:
        """Read two names and a coefficient."""
        if not isinstance(value, list) or len(value) != 3:
            remedy = 'Write ["first", "second", 0.8].'
            note_wrong_kind(value, place, "two responses and a coefficient", remedy)
            return None
        first, second = (Text().read(name, place.at(i)) for i, name in enumerate(value[:2]))
        coefficient = _COEFFICIENT.read(value[2], place.at(2))
        if first is None or second is None or coefficient is None:
            return None
        return first, second, coefficient

    def schema(self) -> Schema:
        """Return the JSON Schema of a pair."""
        coefficient = {**_COEFFICIENT.schema(), "exclusiveMinimum": -1, "exclusiveMaximum": 1}
        entries = [Text().schema(), Text().schema(), coefficient]
        return {"type": "array", "prefixItems": entries, "minItems": 3, "maxItems": 3}


CORRELATIONS = Key(
    "correlations",
    ListOf(CorrelatedPair()),
    "Correlations of the errors of the measured values of this test: pairs of responses, each with "
    "its coefficient between -1 and 1.",
    example='[["bulk_density", "angle_of_repose", 0.5]]',
)


def note_bad_correlations(
    correlations: Sequence[Correlation], responses: Sequence[str], place: Place
) -> bool:
    """Return whether correlations are not those of the responses, and note why."""
    faults = correlation_faults(responses, correlations, "")
    for fault in faults:
        index = fault.key.strip("[]")
        (place.at(int(index)) if index else place).refuse(fault)
    return bool(faults)


@dataclass(frozen=True)
class InstrumentOf(Kind):
    """The name of an instrument that does a test.

    Parameters
    ----------
    test : str
        Type of the test.
    """

    test: str

    def read(self, value: Any, place: Place) -> Instrument | None:
        """Read the instrument of this name."""
        if not isinstance(value, str):
            note_wrong_kind(value, place, "a text", 'Write it in quotes: "...".')
            return None
        try:
            found = read_instrument(value)
        except InputError as error:
            for fault in error.faults:
                place.refuse(fault)
            return None
        if found.type == self.test:
            return found
        fault = test_messages.OTHER_TYPE.fault("", name=value, type=found.type)
        place.refuse(fault)
        return None

    def schema(self) -> Schema:
        """Return the JSON Schema: any text, with the names of the instruments as examples."""
        return {"type": "string", "examples": list(instrument_names(self.test))}


def apparatus_key(test: str) -> Key | None:
    """Return the key of the instruments of a type of test; None if there are none."""
    names = instrument_names(test)
    if not names:
        return None
    return Key(
        "apparatus",
        InstrumentOf(test),
        "Instrument of the laboratory, by its name: it gives the options of its dimensions; those "
        "that stand beside it override them.",
        default="none",
        example=f'"{names[0]}"',
    )


def with_instrument(
    test: Mapping[str, Any], place: Place
) -> tuple[Mapping[str, Any], Instrument | None]:
    """Return a test with the options of its instrument where the file gives none.

    Parameters
    ----------
    test : mapping of str to object
        The table of the file, with its type.
    place : Place
        Where it is.

    Returns
    -------
    tuple of mapping and Instrument
        The table without the key of the instrument, and what it decides; as it was, and None,
        without one, or with one that cannot be read, whose fault is noted.
    """
    key = apparatus_key(test["type"])
    if key is None or key.name not in test:
        return test, None
    instrument = key.kind.read(test[key.name], place.at(key.name))
    own = {name: value for name, value in test.items() if name != key.name}
    if not instrument:
        return own, None
    instrument = instrument.beside(own)
    return {**instrument.values, **own}, instrument
