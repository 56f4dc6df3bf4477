"""What tests of several calibrations gave, lined up by type of the test and response."""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from typing import NamedTuple, TypeVar

from grainfit.bulk_tests.own_scene.bulk_test import OwnScene
from grainfit.evaluation import response_name
from grainfit.relative_names import is_relative
from grainfit.work_folder.saved_calibration import SavedCalibration

_Found = TypeVar("_Found")


class Place(NamedTuple):
    """Where something belongs: in a calibration, or in a row of several.

    Parameters
    ----------
    type : str
        Type of the bulk test; "" of a model of the user and of a scene of one's own, which only
        their names tell apart.
    test : str
        Name of the test; "" in a row of all tests of a type.
    response : str
        Name of the response or of the curve, without that of the test.
    """

    type: str
    test: str
    response: str

    @property
    def title(self) -> str:
        """Name of the test, or of all tests of its type."""
        return self.test or self.type


def types_of_tests(saved: SavedCalibration) -> dict[str, str]:
    """Return the type of each test of a calibration, by its name."""
    return {
        record.test: "" if (kind := record.definition.test_type) == OwnScene.type else kind
        for record in saved.records.values()
        if not is_relative(record.test)
    }


def place_of(types: Mapping[str, str], name: str) -> Place:
    """Return the place of a response or a curve, by its name in a calibration with these tests."""
    for test in sorted(types, key=len, reverse=True):
        prefix = response_name(test, "", len(types))
        if name.startswith(prefix):
            return Place(types[test], test, name.removeprefix(prefix))
    return Place("", "", name)


def told_by_name(every: Iterable[Iterable[str]]) -> set[str]:
    """Return the types of which a calibration has several tests; one's own have no type."""
    return {"", *(kind for types in every for kind, tests in Counter(types).items() if tests > 1)}


def lined_up(
    found: Sequence[Mapping[Place, _Found]], by_name: Collection[str]
) -> Iterator[tuple[Place, tuple[_Found | None, ...]]]:
    """Yield each row with what the calibrations have in it; None where one has nothing.

    Parameters
    ----------
    found : sequence of mapping
        What each calibration has, by place.
    by_name : collection of str
        Types whose tests are lined up by their names.
    """
    rows = [
        {p if p.type in by_name else p._replace(test=""): one for p, one in own.items()}
        for own in found
    ]
    for place in dict.fromkeys(place for own in rows for place in own):
        yield place, tuple(own.get(place) for own in rows)


def shown_names(places: Collection[Place]) -> dict[Place, str]:
    """Return the names of rows; without that of the test where all are of the same one."""
    tests = len({place[:2] for place in places})
    return {
        place: response_name(place.title, place.response, tests) if place.title else place.response
        for place in places
    }
