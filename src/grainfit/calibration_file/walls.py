"""Walls with names in the calibration file: their sections, and the parts that are made of them."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from grainfit.bulk_tests.abilities import friction_options
from grainfit.bulk_tests.base import BulkTest
from grainfit.calibration_file import messages
from grainfit.calibration_file.parameters import is_value
from grainfit.materials.walls import PLAIN, WALL_SECTIONS
from grainfit.options.kinds import NAME_PATTERN, Kind, Schema, note_bad_name, suggest
from grainfit.options.places import Place, show
from grainfit.options.tables import Table, Values
from grainfit.solvers.dem.parts import friction_fault, parts_on_walls, walls_of

#: Tables of a ``[[test]]`` whose header is missing.
_TABLES_OF_TESTS = ("targets", "walls")


@dataclass(frozen=True)
class WallTable(Kind):
    """A section of the plain wall, and within it sections of walls with a name.

    Parameters
    ----------
    plain : Table
        Layout of the plain wall.
    of_wall : callable
        Returns the layout of a wall, given its name.
    reserved : tuple of str
        Names that no wall can have.
    """

    plain: Table
    of_wall: Callable[[str], Table]
    reserved: tuple[str, ...]

    def read(self, value: Any, place: Place) -> Any:
        """Read the values of the plain wall, and those of each wall with a name."""
        if not isinstance(value, dict):
            return self.plain.read(value, place)
        named = {name: entry for name, entry in value.items() if _is_section(name, entry)}
        plain = {name: entry for name, entry in value.items() if name not in named}
        read = {n: self._read_wall(n, entry, place.at(n)) for n, entry in named.items()}
        return {**self.plain.read(plain, place), **read}

    def _read_wall(self, name: str, entry: dict[str, Any], place: Place) -> Values:
        table = self.of_wall(name)
        if not self._is_possible(name, place):
            # It is a wall all the same, of which nothing is missing.
            return dict.fromkeys(key.name for key in table.keys)
        values: Values = table.read(entry, place)
        return values

    def _is_possible(self, name: str, place: Place) -> bool:
        """Return whether a wall can have a name, and note it when it cannot."""
        if name in self.reserved:
            place.fault(messages.NO_NAME_OF_A_WALL, name=name, section=place.path[0])
            return False
        return note_bad_name(name, place)

    def schema(self) -> Schema:
        """Return the JSON Schema of the section."""
        schema = self.plain.schema()
        known = "|".join(key.name for key in self.plain.keys)
        taken = "|".join(dict.fromkeys(self.reserved))
        return {
            **schema,
            "patternProperties": {f"^(?!(?:{known}|{taken})$){NAME_PATTERN}$": self.plain.schema()},
        }


def _is_section(name: str, entry: Any) -> bool:
    """Return whether a table is the section of a wall, no interval, and no table of a test."""
    return isinstance(entry, dict) and not is_value(entry) and name not in _TABLES_OF_TESTS


@dataclass(frozen=True)
class TestWalls:
    """A test of the file and its walls.

    Parameters
    ----------
    index : int
        Place in the list of tests.
    test : type
        Class of the test.
    table : dict
        Its table in the file.
    section : str
        The list: ``test`` or ``holdout``.
    """

    # Keeps pytest from taking it for a class of tests.
    __test__ = False

    index: int
    test: type[BulkTest]
    table: dict[str, Any]
    section: str = "test"

    @property
    def given(self) -> dict[str, str]:
        """Names of walls by part, as the file has them."""
        table = self.table.get("walls")
        found = table.items() if isinstance(table, dict) else ()
        return {part: wall for part, wall in found if isinstance(wall, str)}

    def parts(self, declared: Sequence[str]) -> dict[str, str]:
        """Return the walls with a name of its parts."""
        given = {part: wall for part, wall in self.given.items() if wall in declared}
        return parts_on_walls(self.test, given, declared)

    def used(self, declared: Sequence[str]) -> list[str]:
        """Return the walls that it needs: the plain one where the file has no walls at all."""
        possible = walls_of(self.test, self.parts(declared))
        return [wall for wall in possible if wall in declared or not declared]

    def note_faults(self, declared: Sequence[str], place: Place) -> None:
        """Note walls that there are not, parts without a wall, and friction given twice."""
        place = place.at(self.section, self.index)
        named = [wall for wall in declared if wall != PLAIN]
        for part, wall in self.given.items():
            # Of a text that can be no name, this is noted already.
            if wall not in declared and re.fullmatch(NAME_PATTERN, wall):
                remedy = suggest(wall, named, "Walls are") if named else "Add the section."
                place.at("walls", part).fault(
                    messages.NO_SUCH_WALL, given=show(wall), wall=wall, remedy=remedy
                )
        parts = self.parts(declared)
        for part, options in friction_options(self.test).items():
            for option in options:
                if part in parts and option in self.table:
                    fault = friction_fault(option, part, parts[part])
                    place.at(option).refuse(fault)
        if named and PLAIN not in declared and (without := self._bare_parts(parts)):
            walls = " or ".join(f'"{wall}"' for wall in named)
            place.at("walls").fault(
                messages.PART_WITHOUT_WALL,
                part=without[0],
                parts=" = ..., ".join(self.test.parts or ("NAME_OF_A_WALL",)),
                walls=walls,
            )

    def _bare_parts(self, parts: Mapping[str, str]) -> list[str]:
        """Parts of which it is not known what they are made of, in words."""
        if self.test.parts is None:
            return [] if self.given else ["each wall of the scene"]
        return [f"the {p}" for p in self.test.parts if p not in parts and p not in self.given]


def declared_walls(values: Values) -> tuple[str, ...]:
    """Return the walls that a file has sections of, the plain one included."""
    return tuple(dict.fromkeys(wall for wall, _ in _sections(values)))


def _sections(values: Values) -> Iterator[tuple[str, str]]:
    """Iterate over walls and sections of them."""
    for section in WALL_SECTIONS:
        table = values.get(section, {})
        named = [key for key, value in (table or {}).items() if isinstance(value, dict)]
        if section in values and (not table or len(named) < len(table)):
            yield PLAIN, section
        yield from ((wall, section) for wall in named)


def _is_unread(values: Values) -> bool:
    """Return whether a wall has nothing but faults, as one that cannot have its name."""
    return bool(values) and all(value is None for value in values.values())


def note_unused_walls(used: Sequence[str], values: Values, place: Place) -> None:
    """Note walls of which no test is made."""
    for wall, section in dict(reversed([*_sections(values)])).items():
        if wall == PLAIN and wall not in used:
            place.at(section).fault(messages.PLAIN_WALL_OF_NO_TEST)
        elif wall not in used and not _is_unread(values[section][wall]):
            place.at(section, wall).fault(messages.WALL_OF_NO_TEST, wall=wall)
