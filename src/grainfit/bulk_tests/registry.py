"""Registry of bulk tests: one line for each, and those of other packages.

Another package adds tests with an entry point of the group ``grainfit.bulk_tests``, named like the
test, whose value is its class.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache
from importlib.metadata import entry_points
from typing import Any, cast

from grainfit.bulk_tests import messages, own_scene
from grainfit.bulk_tests.base import BulkTest
from grainfit.bulk_tests.compression import Compression as Compression
from grainfit.bulk_tests.discharge import Discharge as Discharge
from grainfit.bulk_tests.draw_down import DrawDown as DrawDown
from grainfit.bulk_tests.drum import Drum as Drum
from grainfit.bulk_tests.funnel import Funnel as Funnel
from grainfit.bulk_tests.heap import Heap as Heap
from grainfit.bulk_tests.hopper import Hopper as Hopper
from grainfit.bulk_tests.packing import Packing as Packing
from grainfit.bulk_tests.response_info import CurveInfo, ResponseInfo
from grainfit.bulk_tests.shear import Shear as Shear
from grainfit.bulk_tests.shear_cell import ShearCell as ShearCell
from grainfit.bulk_tests.tapped import Tapped as Tapped
from grainfit.bulk_tests.triaxial import Triaxial as Triaxial
from grainfit.errors import Fault, InputError, error_in_words
from grainfit.registration import incomplete, require_complete, require_unique
from grainfit.run_definition import RunDefinition

ENTRY_POINTS = "grainfit.bulk_tests"


def _classes(names: Mapping[str, Any]) -> tuple[type[BulkTest], ...]:
    return tuple(
        found
        for found in names.values()
        if isinstance(found, type) and issubclass(found, BulkTest) and found is not BulkTest
    )


#: Every test that is imported above.
_TESTS = _classes(globals())
for _test in _TESTS:
    require_complete("bulk test", _test.__name__, _test.missing())
require_unique("bulk test", (test.type for test in _TESTS))

#: The built-in tests, by name.
BUILT_IN: Mapping[str, type[BulkTest]] = {test.type: test for test in _TESTS}
#: The test whose scene and responses the user's own functions give: no laboratory test by itself.
OWN_SCENE: type[BulkTest] = own_scene.OwnScene


@cache
def bulk_tests() -> Mapping[str, type[BulkTest]]:
    """Return all tests by name, the built-in ones first.

    Raises
    ------
    InputError
        A test of another package cannot be loaded.
    """
    others = {point.name: point for point in entry_points(group=ENTRY_POINTS)}
    return {**{name: _load(point) for name, point in others.items()}, **BUILT_IN}


def _load(point: Any) -> type[BulkTest]:
    try:
        test: Any = point.load()
    except Exception as error:
        reason = error_in_words(error).removesuffix(".")
        raise _fault(point, f"{point.value} cannot be loaded: {reason}.") from error
    is_test = isinstance(test, type) and issubclass(test, BulkTest)
    if is_test and (sentence := incomplete("bulk test", point.value, test.missing())):
        raise _fault(point, sentence)
    if not is_test or test.type != point.name:
        raise _fault(point, f"{point.value} is not a BulkTest whose type is {point.name!r}.")
    return cast(type[BulkTest], test)


def _fault(point: Any, sentence: str) -> InputError:
    remedy = "Repair or remove the package that provides it."
    return InputError(Fault(f"bulk test {point.name!r}", sentence, remedy))


def class_of_test(definition: RunDefinition) -> type[BulkTest] | None:
    """Return the class of the test in the definition of a run; None for a model of the user."""
    known = definition.model.get("test")
    name = known.get("type") if isinstance(known, Mapping) else None
    if name == OWN_SCENE.type:
        return OWN_SCENE
    return bulk_tests().get(name) if isinstance(name, str) else None


def recreate_test(definition: RunDefinition) -> BulkTest | None:
    """Rebuild the test of a run from the run's definition; None for a model of the user.

    Raises
    ------
    InputError
        The definition is damaged, or of another version.
    """
    test = class_of_test(definition)
    if test is None:
        return None
    try:
        return test.from_definition(definition.model["test"])
    except KeyError as error:
        reason = f"{error} is missing"
    except (TypeError, ValueError, AttributeError) as error:
        reason = str(error)
    raise InputError(messages.DAMAGED_DEFINITION.fault("", type=test.type, reason=reason))


def curve_info(name: str) -> CurveInfo | None:
    """Return unit, coordinate and description of a curve; None when no installed test has it."""
    return next((test.curves[name] for test in bulk_tests().values() if name in test.curves), None)


def response_info(name: str) -> ResponseInfo | None:
    """Return unit, symbol and description of a response; None when no installed test has it."""
    return next(
        (test.responses[name] for test in bulk_tests().values() if name in test.responses), None
    )
