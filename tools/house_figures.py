"""Count the house: lines and public names of each room, files of five tasks, stays of five walks.

With another checkout, what came since is counted as well: lines of old abilities then and now, and
lines of abilities that are new.

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
SINCE, END_SINCE = "<!-- what came since -->", "<!-- end of what came since -->"
#: Rooms of 0.2.0 by purpose; the rooms that were made of their modules count with them.
PURPOSES: Mapping[str, tuple[str, ...]] = {
    "simulated tests": (
        *("bulk_tests", "scenes", "solvers", "contact_models", "materials", "measurement"),
    ),
    "mathematics of the calibration": (
        *("metamodels", "strategies", "analysis", "which_test", "calibration"),
        *("problem", "verdict", "result", "evaluation"),
    ),
    "keeping runs": ("campaign", "work_folder"),
    "calibration file and tables": ("calibration_file", "options", "table_files"),
    "what users see": ("cli", "report", "plots", "watch", "preview", "animation", "cards"),
    "contract suites": ("testing",),
}
#: Abilities that are new since: what each is for, and its modules.
ABILITIES: Mapping[str, tuple[str, tuple[str, ...]]] = {
    "photographs, videos, scans, balances": (
        "measure the laboratory with the code that measures simulations",
        (
            *("photographs/*", "photo_page/*", "report/sections/photographs/*"),
            *("cli/commands/photo.py", "work_folder/heap_scan.py"),
            *("calibration_file/photo*.py", "calibration_file/drums.py"),
            *("calibration_file/draw_downs.py", "calibration_file/originals.py"),
            *("calibration_file/balances.py", "calibration_file/checks/photographs.py"),
        ),
    ),
    "five laboratory tests, instruments": (
        "poured heap, hopper, tapped density, shear cell, triaxial: each with its procedure",
        (
            *(f"bulk_tests/{n}/*" for n in ("funnel", "hopper", "tapped")),
            *("bulk_tests/shear_cell/*", "bulk_tests/triaxial/*", "measurement/mohr_circles.py"),
            *("bulk_tests/shared/vessel.py", "bulk_tests/shared/round_container.py"),
            *("bulk_tests/instrument.py", "calibration_file/checks/instruments.py"),
            "cli/commands/apparatus.py",
        ),
    ),
    "smaller apparatus, relatives, near runs": (
        "let cheaper or earlier runs lead the search, and judge at full size",
        (
            *("analysis/size_*.py", "analysis/long_runs.py", "analysis/recorded_size.py"),
            *("bulk_tests/size.py", "calibration/twins.py", "calibration_file/twins.py"),
            *("calibration_file/relatives.py", "calibration_file/real_size.py"),
            *("campaign/near_runs.py", "metamodels/relative_prior.py"),
            *("work_folder/size_*.py", "cli/commands/size.py"),
        ),
    ),
    "atlas, estimate": (
        "answer from runs that ship with grainfit, before the first simulation",
        (
            *("atlas/*", "atlas_page/*", "cli/commands/atlas.py", "cli/commands/estimate.py"),
            *("work_folder/estimate*.py", "work_folder/given_material.py"),
            "which_test/told_by_atlas.py",
        ),
    ),
    "interview, start page": (
        "lead from a question to a running calibration, in terminal or browser",
        (
            *("interview/*", "start_page/*", "local_pages/*", "showing.py"),
            *("cli/commands/ask.py", "cli/commands/start.py", "cli/local_page.py"),
        ),
    ),
    "hold-outs": (
        "predict tests that took no part in the fit, and compare them with measurements",
        (
            *("calibration/holdout*.py", "calibration/registrations.py", "result/holdout.py"),
            *("verdict/holdout.py", "report/sections/holdout/*", "plots/holdout_figures.py"),
            *("work_folder/predict.py", "cli/commands/predict.py"),
        ),
    ),
    "cards of other programs, sheet of a material": (
        "bring the answer to six programs that are not run, and on paper",
        ("cards/other_programs/*", "report/sheet/*", "report/compared/*", "pdf/*"),
    ),
    "runs that go on after they were killed": (
        "continue a long simulation from its last restart file",
        ("solvers/dem/*restart*", "solvers/dem/*/restart*", "solvers/process/restart*"),
    ),
    "linear contacts, published values": (
        "a second contact law, and starting values with their sources",
        (
            *("contact_models/linear/*", "materials/*published*", "materials/material_*.py"),
            "materials/starting_values.py",
        ),
    ),
    "Windows and macOS, schedulers besides Slurm": (
        "run where the user is",
        ("platforms.py", "cli/encoding.py", "campaign/cluster/schedulers.py"),
    ),
}
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
    lines = {name: _length(path) for name, path in found.items()}
    rooms = Counter[str]()
    for name, count in lines.items():
        room = found[name].relative_to(source / "grainfit").parts
        rooms[f"`{room_of(name)}`" if len(room) > 1 else "modules without a room"] += count
    tests = (checkout / "tests").rglob("*.py")
    return {
        "lines of `src`": f"{sum(lines.values()):,}",
        "lines of `tests`": f"{sum(map(_length, tests)):,}",
        "public functions and classes": f"{sum(_public_names(found.values())):,}",
        **{f"files to {task}": _files(checkout, task) for task in TASKS},
        **{f"stays: {name}": _stays(source, starts) for name, starts in WALKS.items()},
        **{f"lines of {room}": f"{count:,}" for room, count in rooms.most_common()},
    }


def since(now: Path, before: Path) -> str:
    """Return the lines of old abilities then and now, and those of new ones, as Markdown."""
    old, new = old_lines(before), old_lines(now)
    added = {name: lines_of(now, globs) for name, (_, globs) in ABILITIES.items()}
    purposes = [*PURPOSES, "modules of the ground"]
    rows = [["of 0.2.0:", "", ""]]
    rows += [[name, f"{old[name]:,}", f"{new[name]:,}"] for name in purposes]
    rows += [["together", f"{sum(old.values()):,}", f"{sum(new.values()):,}"]]
    rows += [["of which catalogues of messages", *map(_catalogues, (before, now))]]
    rows += [["new since:", "", ""]]
    for name, (purpose, _) in sorted(ABILITIES.items(), key=lambda one: -added[one[0]]):
        rows.append([f"{name}: {purpose}", "-", f"{added[name]:,}"])
    rows += [["together", "-", f"{sum(added.values()):,}"]]
    heads = [["lines of `src`", "before", "now"], ["---", "---:", "---:"]]
    return "\n".join("| " + " | ".join(row) + " |" for row in [*heads, *rows])


def old_lines(checkout: Path) -> Counter[str]:
    """Count the lines of the old abilities by their purpose."""
    of_room = {room: name for name, rooms in PURPOSES.items() for room in rooms}
    package = checkout / "src" / "grainfit"
    counts = Counter[str]()
    for path in {*package.rglob("*.py")} - _new_modules(checkout):
        counts[of_room.get(path.relative_to(package).parts[0], "modules of the ground")] += _length(
            path
        )
    return counts


def _catalogues(checkout: Path) -> str:
    found = {*(checkout / "src").rglob("*messages.py")} - _new_modules(checkout)
    return f"{sum(map(_length, found)):,}" if found else "-"


def _new_modules(checkout: Path) -> set[Path]:
    return {path for _, globs in ABILITIES.values() for path in _files_of(checkout, globs)}


def lines_of(checkout: Path, globs: Iterable[str]) -> int:
    """Count the lines of the modules of a new ability."""
    return sum(map(_length, _files_of(checkout, globs)))


def _files_of(checkout: Path, globs: Iterable[str]) -> set[Path]:
    package = checkout / "src" / "grainfit"
    found = {name: {*package.glob(name)} for name in globs}
    assert checkout != ROOT or all(found.values()), [name for name, of in found.items() if not of]
    return {
        path
        for top in set().union(*found.values())
        for path in ([top] if top.is_file() else top.rglob("*.py"))
        if path.suffix == ".py"
    }


def _length(path: Path) -> int:
    return len(path.read_text("utf-8").splitlines())


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
    texts = {(BEGIN, END): table(ROOT, given.before)}
    if given.before:
        texts[SINCE, END_SINCE] = since(ROOT, given.before)
    for (begin, end), text in texts.items():
        print(text, end="\n\n")
        if given.write:
            head, _, rest = PAGE.read_text(encoding="utf-8").partition(begin)
            PAGE.write_text(f"{head}{begin}\n\n{text}\n\n{end}{rest.partition(end)[2]}", "utf-8")


if __name__ == "__main__":
    main()
