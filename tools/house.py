"""Read the imports of the package: which rooms there are, and which know which.

python tools/house.py            print what each room imports
python tools/house.py --draw     draw docs/images/house.svg as well
"""

from __future__ import annotations

import argparse
import ast
from collections import defaultdict
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).parents[1]
PACKAGE = "grainfit"
#: The rooms from the ground up: one may import only those below it. A room is a folder or a file
#: of the package; rooms of one floor do not know each other.
FLOORS: tuple[tuple[str, ...], ...] = (
    ("errors",),
    ("units", "formatting", "files"),
    ("materials", "tables"),
    ("evaluation", "problem"),
    ("result",),
    ("contact_models", "measurement"),
    ("bulk_tests", "metamodels"),
    ("solvers", "strategies"),
    ("campaign",),
    ("calibration", "analysis"),
    ("calibration_file",),
    ("work_folder",),
    ("cards", "plots"),
    ("report",),
    ("opened",),
    ("cli",),
)
#: Rooms that nothing imports, and that may import everything.
OUTSIDE = ("testing", "__main__", "__init__")


@dataclass(frozen=True)
class Import:
    """One module that imports another, and in which line."""

    importer: str
    imported: str
    line: int
    at_run_time: bool

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


def imports(source: Path = ROOT / "src") -> list[Import]:
    """Return all imports between modules of the package, those inside functions included."""
    known = modules(source)
    found = []
    for importer, path in known.items():
        tree = ast.parse(path.read_text(encoding="utf-8"))
        for_types = _type_checking_lines(tree)
        for node in ast.walk(tree):
            for imported in _imported(node, known):
                at_run_time = node.lineno not in for_types  # type: ignore[attr-defined]
                line: int = node.lineno  # type: ignore[attr-defined]
                found.append(Import(importer, imported, line, at_run_time))
    return found


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


def _type_checking_lines(tree: ast.Module) -> set[int]:
    lines: set[int] = set()
    for node in ast.walk(tree):
        if isinstance(node, ast.If) and ast.unparse(node.test).endswith("TYPE_CHECKING"):
            lines.update(range(node.lineno, (node.end_lineno or node.lineno) + 1))
    return lines


def main() -> None:
    """Print what each room imports, and what breaks the order."""
    argparse.ArgumentParser(description=__doc__).parse_args()
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
