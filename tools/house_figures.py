"""Count the house: lines and public names of each room, files of five tasks, stays of five walks.

python tools/house_figures.py                      print the table of this state
python tools/house_figures.py --before FOLDER      beside that of another checkout
python tools/house_figures.py --before FOLDER --write    and put it into its page
"""

from __future__ import annotations

import argparse
import ast
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path

try:
    from tools.house import ROOT, modules, room_of
    from tools.walks import House, walk
except ImportError:  # Run as a script, from this folder.
    from house import ROOT, modules, room_of  # type: ignore[no-redef]
    from walks import House, walk  # type: ignore[no-redef]

PAGE = ROOT / "docs" / "developers" / "house_figures.md"
BEGIN, END = "<!-- figures of the house -->", "<!-- end of the figures -->"
#: Ways of a parameter; a state has the first of the places that exists there.
WALKS: Mapping[str, tuple[str, ...]] = {
    "work folder into the report": (
        "grainfit.cli.commands.report:report:workdir",
        "grainfit.cli.app:report:workdir",
    ),
    "`grainfit run` FILE": (
        "grainfit.cli.commands.run:run:file",
        "grainfit.cli.app:run:file",
    ),
    "`grainfit status` DIR": (
        "grainfit.cli.commands.status:status:workdir",
        "grainfit.cli.app:status:workdir",
    ),
    "`gf.open` folder": ("grainfit.opened:open_calibration:folder",),
    "`gf.calibrate` problem": ("grainfit.calibration.calibrate:calibrate:problem",),
}
#: Tasks of a maintainer: files that a reader of version 0.2.0 opened, and those to open now, under
#: `src/grainfit` unless they are tests. None where nobody followed the task.
TASKS: Mapping[str, tuple[int | None, tuple[str, ...]]] = {
    "add a bulk test": (
        25,
        (
            "bulk_tests/base.py",
            "bulk_tests/setup.py",
            "bulk_tests/packing/bulk_test.py",
            "bulk_tests/shared/filling.py",
            "bulk_tests/shared/options.py",
            "scenes/scene.py",
            "bulk_tests/registry.py",
            "tests/bulk_tests/test_contract_packing.py",
        ),
    ),
    "add a contact parameter": (
        15,
        (
            "contact_models/base.py",
            "contact_models/lammps.py",
            "contact_models/jkr/contact_model.py",
            "contact_models/jkr/lammps.py",
            "contact_models/registry.py",
            "tests/contact_models/test_contact_model_contract.py",
        ),
    ),
    "add a command": (
        7,
        (
            "cli/commands/compare.py",
            "cli/app.py",
            "work_folder/comparison.py",
            "tests/work_folder/test_comparison.py",
        ),
    ),
    "mend a wrong verdict": (
        19,
        (
            "verdict/options.py",
            "verdict/rule.py",
            "verdict/evidence.py",
            "verdict/reasons.py",
            "verdict/messages.py",
            "calibration/judged_answer.py",
        ),
    ),
    "add a check": (
        None,
        (
            "checks.py",
            "calibration_file/checks/registry.py",
            "calibration_file/checks/few_particles.py",
            "tests/calibration_file/test_checks.py",
        ),
    ),
}


def table(now: Path, before: Path | None = None) -> str:
    """Return the figures of one checkout, or of two beside each other, as Markdown."""
    checkouts = [before, now] if before else [now]
    figures = [_figures(checkout) for checkout in checkouts]
    names = dict.fromkeys(name for figure in reversed(figures) for name in figure)
    heads = ["", "before", "now"] if before else ["", "now"]
    rows = [[name, *(figure.get(name, "-") for figure in figures)] for name in names]
    rule = ["---", *("---:" for _ in figures)]
    return "\n".join("| " + " | ".join(row) + " |" for row in [heads, rule, *rows])


def _figures(checkout: Path) -> dict[str, str]:
    source = checkout / "src"
    found = modules(source)
    lines = {name: len(path.read_text("utf-8").splitlines()) for name, path in found.items()}
    rooms = Counter[str]()
    for name, count in lines.items():
        room = found[name].relative_to(source / "grainfit").parts
        rooms[f"`{room_of(name)}`" if len(room) > 1 else "modules without a room"] += count
    tests = (checkout / "tests").rglob("*.py")
    return {
        "lines of `src`": f"{sum(lines.values()):,}",
        "lines of `tests`": f"{sum(len(path.read_text('utf-8').splitlines()) for path in tests):,}",
        "public functions and classes": f"{sum(_public_names(found.values())):,}",
        **{f"files to {task}": _files(checkout, task) for task in TASKS},
        **{f"stays: {name}": _stays(source, starts) for name, starts in WALKS.items()},
        **{f"lines of {room}": f"{count:,}" for room, count in rooms.most_common()},
    }


def _public_names(paths: Iterable[Path]) -> Iterator[int]:
    """Yield the number of functions and classes of each module that have no underscore."""
    for path in paths:
        if not path.stem.startswith("_") or path.stem == "__init__":
            body = ast.parse(path.read_text(encoding="utf-8")).body
            kinds = (ast.FunctionDef, ast.ClassDef)
            yield sum(isinstance(n, kinds) and not n.name.startswith("_") for n in body)


def _files(checkout: Path, task: str) -> str:
    """Return the number of files that a task opens; for another state, what a reader counted."""
    before, files = TASKS[task]
    if checkout != ROOT:
        return "-" if before is None else str(before)
    tops = (ROOT, ROOT / "src" / "grainfit")
    missing = [name for name in files if not any((top / name).is_file() for top in tops)]
    assert not missing, f"{task}: {missing} is not there"
    return str(len(files))


def _stays(source: Path, starts: tuple[str, ...]) -> str:
    house = House.read(source)
    known = [start for start in starts if tuple(start.split(":")[:2]) in house.functions]
    return str(len(walk(house, known[0]))) if known else "-"


def main() -> None:
    """Print the table, or write it into the page."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    parser.add_argument("--before", type=Path, metavar="FOLDER", help="another checkout")
    parser.add_argument("--write", action="store_true", help=f"into {PAGE.relative_to(ROOT)}")
    given = parser.parse_args()
    text = table(ROOT, given.before)
    print(text)
    if given.write:
        page = PAGE.read_text(encoding="utf-8")
        head, _, rest = page.partition(BEGIN)
        PAGE.write_text(f"{head}{BEGIN}\n\n{text}\n\n{END}{rest.partition(END)[2]}", "utf-8")


if __name__ == "__main__":
    main()
