"""Read the imports of the package: its rooms, and which room imports which.

python tools/house.py            print the imports of each room
python tools/house.py --draw     draw docs/images/house.svg as well
"""

from __future__ import annotations

import argparse
import ast
from collections import defaultdict
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from xml.sax.saxutils import escape

ROOT = Path(__file__).parents[1]
PACKAGE = "grainfit"
#: The rooms from the ground up: one may import only those below it. A room is a folder or a file
#: of the package; rooms of one floor do not know each other.
FLOORS: tuple[tuple[str, ...], ...] = (
    ("arrays", "lazy", "one_line", "one_thread", "platforms"),
    ("errors",),
    ("messages",),
    ("ground_messages",),
    (
        "checks",
        "validation",
        "extras",
        "units",
        "formatting",
        "files",
        "pdf",
        "plain_data",
        "registration",
        "relative_names",
        "student",
    ),
    ("options", "tables", "verdict"),
    ("table_files", "local_pages"),
    ("materials",),
    ("contact_models",),
    ("evaluation", "problem", "run_definition"),
    ("result",),
    ("measurement",),
    ("scenes", "photographs"),
    ("bulk_tests", "metamodels"),
    ("solvers", "strategies", "tests"),
    ("campaign", "atlas"),
    ("which_test",),
    ("analysis",),
    ("calibration",),
    ("calibration_file",),
    ("work_folder",),
    ("cards", "plots"),
    ("report",),
    ("opened", "preview", "watch", "atlas_page", "photo_page", "interview"),
    ("animation", "showing", "start_page"),
    ("cli",),
)
#: Rooms that nothing imports, and that may import everything.
OUTSIDE = ("testing", "__main__", "__init__")


@dataclass(frozen=True)
class Import:
    """An import of one module by another, with its line."""

    importer: str
    imported: str
    line: int

    def __str__(self) -> str:
        return f"{self.importer} (line {self.line}) imports {self.imported}"


def modules(source: Path = ROOT / "src") -> dict[str, Path]:
    """Return the files of the package by dotted name."""
    found = {}
    for path in sorted((source / PACKAGE).rglob("*.py")):
        parts = path.relative_to(source).with_suffix("").parts
        name = ".".join(parts[:-1] if parts[-1] == "__init__" else parts)
        found[name] = path
    return found


@cache
def imports(source: Path = ROOT / "src") -> tuple[Import, ...]:
    """Return all imports between modules of the package, those inside functions included."""
    known = modules(source)
    found = []
    for importer, path in known.items():
        tree = ast.parse(path.read_text(encoding="utf-8"))
        for node in ast.walk(tree):
            for imported in _imported(node, known):
                line: int = node.lineno  # type: ignore[attr-defined]
                found.append(Import(importer, imported, line))
    return tuple(found)


def room_of(module: str) -> str:
    """Return the room of a module: its first name below the package."""
    return [*module.split("."), "__init__"][1]


def upward_imports(found: Iterable[Import]) -> list[Import]:
    """Return imports of a room that is not below the importer's own, and those of no room."""
    floor = {room: number for number, rooms in enumerate(FLOORS) for room in rooms}
    floor |= dict.fromkeys(OUTSIDE, len(FLOORS))
    return [
        one
        for one in found
        if room_of(one.importer) != room_of(one.imported)
        and floor.get(room_of(one.imported), len(FLOORS)) >= floor.get(room_of(one.importer), -1)
        and not (room_of(one.importer) in OUTSIDE and room_of(one.imported) not in OUTSIDE)
    ]


def circles(found: Iterable[Import]) -> list[list[str]]:
    """Return the groups of modules that import each other, those for types included."""
    reached: dict[str, set[str]] = defaultdict(set)
    for one in found:
        reached[one.importer].add(one.imported)
    everything = set(reached) | {name for names in reached.values() for name in names}
    closure = {name: _reachable(name, reached) for name in everything}
    groups = {
        frozenset(other for other in closure[name] if name in closure[other])
        for name in everything
        if name in closure[name]
    }
    return sorted(sorted(group) for group in groups)


def _reachable(start: str, reached: Mapping[str, set[str]]) -> set[str]:
    seen: set[str] = set()
    waiting = list(reached.get(start, ()))
    while waiting:
        name = waiting.pop()
        if name not in seen:
            seen.add(name)
            waiting += reached.get(name, ())
    return seen


def _imported(node: ast.AST, known: Mapping[str, Path]) -> Iterator[str]:
    if isinstance(node, ast.ImportFrom) and (node.module or "").split(".")[0] == PACKAGE:
        for alias in node.names:
            module = f"{node.module}.{alias.name}"
            yield module if module in known else str(node.module)
    elif isinstance(node, ast.Import):
        yield from (alias.name for alias in node.names if alias.name in known)


# The picture ---------------------------------------------------------------------------------

PICTURE = ROOT / "docs" / "images" / "house.svg"
_WIDTH, _ROOM_HEIGHT, _GAP, _MARGIN = 900, 46, 26, 14
_STYLE = (
    "text{font-family:sans-serif;fill:#222}.name{font-size:14px;font-weight:600}"
    ".says{font-size:11px;fill:#555}rect{fill:#f4f7fa;stroke:#5b7a99}"
    "path{fill:none;stroke:#8aa0b5;stroke-opacity:.55}"
)


def drawing(source: Path = ROOT / "src") -> str:
    """Return the house as SVG: floors from the ground up, and arrows.

    The arrows show imports; those that others imply are left out.
    """
    places = dict(_places())
    height = len(FLOORS) * (_ROOM_HEIGHT + _GAP) + _GAP
    arrows = [
        _arrow(places[upper], places[lower])
        for upper, lower in _direct(imports(source))
        if upper in places and lower in places
    ]
    rooms = [_room(room, place, _says(room, source)) for room, place in places.items()]
    return "\n".join(
        [
            f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {_WIDTH} {height}">',
            f"<title>Rooms of the package and what they import</title><style>{_STYLE}</style>",
            '<rect x="0" y="0" width="100%" height="100%" style="fill:#fff;stroke:none"/>',
            *arrows,
            *rooms,
            "</svg>\n",
        ]
    )


def _direct(found: Iterable[Import]) -> list[tuple[str, str]]:
    """Return pairs of rooms of which one imports the other, without those that others imply."""
    reached: dict[str, set[str]] = defaultdict(set)
    for one in found:
        if room_of(one.importer) != room_of(one.imported):
            reached[room_of(one.importer)].add(room_of(one.imported))
    return sorted(
        (upper, lower)
        for upper, below in reached.items()
        for lower in below
        if not any(lower in _reachable(other, reached) for other in below - {lower})
    )


def _places() -> Iterator[tuple[str, tuple[float, float, float]]]:
    """Yield left edge, top and width of every room; the ground is at the bottom."""
    for number, rooms in enumerate(reversed(FLOORS)):
        width = (_WIDTH - _MARGIN * (len(rooms) + 1)) / len(rooms)
        for position, room in enumerate(rooms):
            left = _MARGIN + position * (width + _MARGIN)
            yield room, (left, _GAP + number * (_ROOM_HEIGHT + _GAP), width)


def _arrow(upper: tuple[float, float, float], lower: tuple[float, float, float]) -> str:
    start, end = upper[0] + upper[2] / 2, lower[0] + lower[2] / 2
    bottom, top = upper[1] + _ROOM_HEIGHT, lower[1]
    middle = (bottom + top) / 2
    return (
        f'<path d="M{start:.0f} {bottom:.0f}C{start:.0f} {middle:.0f} {end:.0f} {middle:.0f} '
        f'{end:.0f} {top:.0f}"/>'
    )


def _room(room: str, place: tuple[float, float, float], says: str) -> str:
    left, top, width = place
    letters = int((width - 16) / 5.4)
    short = says if len(says) <= letters else f"{says[: letters - 1].rstrip()}…"
    return (
        f'<rect x="{left:.0f}" y="{top:.0f}" width="{width:.0f}" height="{_ROOM_HEIGHT}" rx="4"/>'
        f'<text class="name" x="{left + 8:.0f}" y="{top + 19:.0f}">{escape(room)}</text>'
        f'<text class="says" x="{left + 8:.0f}" y="{top + 36:.0f}">{escape(short)}</text>'
    )


def _says(room: str, source: Path) -> str:
    path = modules(source)[f"{PACKAGE}.{room}"]
    docstring = ast.get_docstring(ast.parse(path.read_text(encoding="utf-8"))) or ""
    return docstring.partition("\n")[0].rstrip(".")


def main() -> None:
    """Print the imports of each room and all violations of the order; draw the house on request."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--draw", action="store_true", help=f"write {PICTURE.relative_to(ROOT)}")
    if parser.parse_args().draw:
        PICTURE.write_text(drawing(), encoding="utf-8")
    found = imports()
    for rooms in FLOORS:
        for room in rooms:
            below = sorted({room_of(i.imported) for i in found if room_of(i.importer) == room})
            print(f"{room}: {', '.join(name for name in below if name != room) or '-'}")
    for one in upward_imports(found):
        print(f"UPWARD: {one}")
    for group in circles(found):
        print(f"CIRCLE: {', '.join(group)}")


if __name__ == "__main__":
    main()
