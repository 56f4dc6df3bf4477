"""The documentation site: built without a warning, complete, and up to date."""

from __future__ import annotations

import json
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from pages_of_tutorials import ROOT
from typer.testing import CliRunner

import grainfit as gf
from grainfit.cli.app import app
from tools import contact_law_page
from tools.recorded_trials_table import PAGE, updated

DOCS = ROOT / "docs"
#: Every key of this file is wrong; docs/questions.md explains the messages.
FAULTY = """\
name = "x"
[particle]
density = { min = "2793 kg/m^3", max = "1407 kg/m^3" }
youngs_modulus = "5 km"
[particle_particle]
sliding_fricton = 0.4
[[test]]
type = "heap"
"""
#: The page that comes first for what users type.
FIRST_HITS = {
    "funnel": "funnel_test",
    "poured angle of repose": "funnel_test",
    "angle of repose": "heap_test",
    "angle of repose with a funnel": "funnel_test",
    "hopper": "hopper_test",
    "silo and a stop watch": "hopper_test",
    "ring shear tester": "shear_cell_test",
    "Schulze": "shear_cell_test",
    "phi_lin": "shear_cell_test",
    "internal_friction_angle": "shear_test",
    "moisture": "cohesion",
    "damp sand": "cohesion",
    "EDEM": "export",
    "Rocky": "export",
    "PFC": "export",
    "MercuryDPM": "export",
    "how long does it take": "questions",
    "How long does a calibration take?": "questions",
    "undecided": "questions",
    "how to begin with my own material": "interview",
    "rape seed": "starting_materials",
    "200 mm bucket": "size",
    "too many particles": "size",
    "protractor": "reference/calibration_file/targets",
    "wall friction": "reference/calibration_file/walls",
    "decimal comma": "tables",
    "phone": "photos",
    "slurm": "clusters",
    "jupyter notebook": "generated/notebooks/plot_bouncing_bead",
    "STL file of a hopper": "own_scenes",
}
#: Words of many pages.
FULL_TEXT = ("LAMMPS", "time step", "cylinder_radius")
#: Pages that come last, unless a query asks for them.
DEVELOPERS = ("developers/", "studies/", "architecture", "generated/c")
#: Searches as a page of the site does; its argument is JSON: scripts to load, then queries.
SEARCH = """
const [scripts, queries] = JSON.parse(process.argv[1]);
const loaded = [];
globalThis.window = globalThis;
globalThis.document = { addEventListener: (_, f) => loaded.push(f), getElementById: () => null };
globalThis._ready = () => {};
globalThis._ = (text) => text;
globalThis.SPHINX_HIGHLIGHT_ENABLED = false;
const { readFileSync } = require("node:fs");
const { runInThisContext } = require("node:vm");
scripts.forEach((script) => runInThisContext(readFileSync(script, "utf8"), script));
loaded.forEach((f) => f());
const search = runInThisContext(`typeof Search === "undefined"
  ? pagesForUse
  : (query) => Search._performSearch(...Search._parseQuery(query)).reverse()`);
const pages = (query) => search(query).map(([page]) => page);
const found = Object.fromEntries(queries.map((query) => [query, pages(query)]));
console.log(JSON.stringify([found, Object.keys(runInThisContext(`USES`))]));
"""
needs_node = pytest.mark.skipif(shutil.which("node") is None, reason="Node.js is not installed")


def searched(*scripts: Path) -> tuple[dict[str, list[str]], list[str]]:
    """Return the pages that the queries find, and the pages that have uses."""
    given = json.dumps([list(map(str, scripts)), [*FIRST_HITS, *FULL_TEXT]])
    done = subprocess.run(
        ["node", "-e", SEARCH, given], capture_output=True, text=True, timeout=60, check=True
    )
    found, pages = json.loads(done.stdout)
    return found, pages


@needs_node
def test_a_search_by_use_has_the_answer_first() -> None:
    found, pages = searched(DOCS / "_static" / "search.js")
    assert {query: found[query][0] for query in FIRST_HITS} == FIRST_HITS
    of_the_repository = [page for page in pages if not page.startswith("generated/")]
    assert [page for page in of_the_repository if not (DOCS / f"{page}.md").is_file()] == []


@pytest.mark.slow
# The navigation of the site's own theme takes more time than all the rest; so do the figures.
@pytest.mark.parametrize(
    ("theme", "figures"),
    [
        ("basic", "/plot_posterior"),
        pytest.param("furo", "/plot_", marks=pytest.mark.thorough),
    ],
)
def test_the_site_is_built_without_a_warning(theme: str, figures: str, tmp_path: Path) -> None:
    # A copy, because the build writes pages into docs/, as may another build at the same time.
    copied = tmp_path / "copy"
    copied.mkdir()
    for name in ("examples", "src", "tests", "CHANGELOG.md", "CONTRIBUTING.md"):
        (copied / name).symlink_to(ROOT / name)
    shutil.copytree(DOCS, copied / "docs", ignore=shutil.ignore_patterns("generated"))
    command = [sys.executable, "-m", "sphinx", "-W", "--keep-going", "-q"]
    command += ["-D", f"html_theme={theme}"]
    command += ["-D", f"sphinx_gallery_conf.filename_pattern={figures}", "docs", "site"]
    built = subprocess.run(command, cwd=copied, capture_output=True, text=True, timeout=600)

    assert built.returncode == 0, built.stderr
    site = copied / "site"
    assert "A measured value that the simulated" in (
        site / "generated" / "python" / "grainfit.Target.html"
    ).read_text(encoding="utf-8")
    figure = (site / "generated" / "gallery" / "plot_posterior.html").read_text(encoding="utf-8")
    assert "Plotly.newPlot" in figure
    assert (site / "_static" / "plotly.min.js").is_file()
    for page in ("benchmarks", "decisions"):
        assert f'"developers/{page}.html"' in (site / f"{page}.html").read_text()
    moved = (site / "calibration_file.html").read_text(encoding="utf-8")
    assert '"several-walls": "reference/calibration_file/walls.html"' in moved
    assert (site / "_static" / "favicon.svg").is_file()
    if shutil.which("node"):
        tools, language = site / "_static" / "searchtools.js", site / "_static" / "language_data.js"
        found, _ = searched(tools, language, site / "searchindex.js")
        assert {query: found[query][0] for query in FIRST_HITS} == FIRST_HITS
        for query in FULL_TEXT:
            last = [page.startswith(DEVELOPERS) for page in found[query]]
            assert any(last)
            assert last == sorted(last), query
        assert found["cylinder_radius"][0].startswith("reference/calibration_file/tests/")


def test_every_import_of_the_pages_works() -> None:
    pages = [path.read_text(encoding="utf-8") for path in (*DOCS.rglob("*.md"), ROOT / "README.md")]
    blocks = re.findall(r"```python\n(.*?)```", "\n".join(pages), re.DOTALL)
    found = {
        line for block in blocks for line in re.findall(r"(?m)^from grainfit.* import .*", block)
    }
    assert found
    for line in sorted(found):
        exec(line.replace("import (", "import *"), {})


def test_dir_shows_the_names_of_the_reference_and_no_others() -> None:
    page = (DOCS / "reference" / "python.md").read_text(encoding="utf-8")
    listed: dict[str, set[str]] = {}
    for block in page.split(".. currentmodule:: ")[1:]:
        names = re.findall(r"^   (\w+)$", block.partition("```")[0], re.MULTILINE)
        listed.setdefault(block.partition("\n")[0], set()).update(names)
    suites = set(re.findall(r"`(\w+_contract)`", page))
    rooms = {"plots", "scenes", "solvers", "testing", "tests"}

    # Two names of solvers stand on the page of their room.
    assert {*dir(gf)} == listed["grainfit"] | rooms | {"Solver", "Workspace"}
    assert {*dir(gf.tests)} == listed["grainfit.tests"]
    assert {*dir(gf.solvers)} == listed["grainfit.solvers"]
    assert {*dir(gf.scenes)} == listed["grainfit.scenes"]
    assert {*dir(gf.plots)} == listed["grainfit.plots"]
    assert {*dir(gf.testing)} == suites
    for module in (gf, gf.tests, gf.solvers, gf.scenes, gf.plots, gf.testing):
        for name in dir(module):
            assert getattr(module, name) is not None


def test_every_page_is_in_a_table_of_contents() -> None:
    pages = {
        path.relative_to(DOCS).with_suffix("")
        for path in DOCS.rglob("*.md")
        if not {"generated", "recorded"} & set(path.relative_to(DOCS).parts)
    }
    listed: set[Path] = set()
    for page in pages:
        text = (DOCS / page).with_suffix(".md").read_text(encoding="utf-8")
        for block in re.findall(r"```\{toctree\}\n(.*?)```", text, re.DOTALL):
            for entry in re.findall(r"^[\w./]+$", block, re.MULTILINE):
                listed.add((DOCS / page.parent / entry).resolve().relative_to(DOCS))
    assert pages - listed == {Path("index")}


def test_links_between_pages_lead_to_files_and_headings() -> None:
    for path in DOCS.rglob("*.md"):
        if {"generated", "recorded"} & set(path.relative_to(DOCS).parts):
            continue
        text = path.read_text(encoding="utf-8")
        for target in re.findall(r"\]\(([^):\s]+)\)", text):
            file, _, anchor = target.partition("#")
            to = (path.parent / file).resolve() if file else path
            if DOCS / "generated" in to.parents:
                continue
            assert to.exists(), f"{path}: {target}"
            assert not anchor or anchor in anchors(to), f"{path}: {target}"


def test_every_decision_has_context_decision_and_consequence_in_six_lines() -> None:
    page = (DOCS / "developers" / "decisions.md").read_text(encoding="utf-8")
    _, *decisions = re.split(r"^## .*\n", page, flags=re.MULTILINE)
    assert len(decisions) > 70
    for decision in decisions:
        lines = decision.strip().split("\n")
        assert len(lines) <= 6, decision
        assert max(map(len, lines)) <= 120, decision
        parts = re.findall(r"^- \*\*(\w+):\*\* \S", decision, re.MULTILINE)
        assert parts == ["Context", "Decision", "Consequence"], decision


def test_the_table_of_recorded_trials_is_up_to_date() -> None:
    page = PAGE.read_text(encoding="utf-8")
    assert updated(page) == page, "run: python tools/recorded_trials_table.py"


def test_the_equations_of_the_contact_law_are_those_of_the_contact_models() -> None:
    page = contact_law_page.PAGE.read_text(encoding="utf-8")
    assert contact_law_page.updated(page) == page, "run: python tools/contact_law_page.py"


def test_the_messages_that_are_explained_are_those_of_the_program(tmp_path: Path) -> None:
    (tmp_path / "faulty.toml").write_text(FAULTY, encoding="utf-8")
    runner = CliRunner(env={"COLUMNS": "400"})
    commands = [
        ("check", tmp_path / "faulty.toml"),
        ("status", tmp_path),
        ("run", tmp_path),
        ("simulate", ROOT / "examples/glass_beads/calibration.toml", "--set", "particle.densty=3"),
    ]
    results = [runner.invoke(app, list(map(str, command))) for command in commands]
    said = "".join(f"{result.output}{result.exception}" for result in results)
    page = (DOCS / "questions.md").read_text(encoding="utf-8")
    rows = re.findall(r"^\| `([^`]+)` \|", page.split("## Messages")[1], re.MULTILINE)

    assert len(rows) >= 9
    tested = [row for row in rows if "..." not in row and "LIGGGHTS" not in row]
    assert [row for row in tested if row not in said] == []


@pytest.mark.parametrize("name", ["README.md", "CONTRIBUTING.md", "CHANGELOG.md"])
def test_links_of_a_page_outside_of_the_site_lead_to_files_and_headings(name: str) -> None:
    text = (ROOT / name).read_text(encoding="utf-8")
    for target in re.findall(r"\]\(([^):]+)\)", text):
        file, _, anchor = target.partition("#")
        path = ROOT / (file or name)
        assert path.exists(), target
        assert not anchor or anchor in anchors(path), target


def anchors(page: Path) -> set[str]:
    """Anchors that Git forges make of the headings of a page."""
    headings = re.findall(r"^#+ (.*)$", page.read_text(encoding="utf-8"), re.MULTILINE)
    plain = (re.sub(r"[^\w\s-]", "", heading.lower()) for heading in headings)
    return {words.strip().replace(" ", "-") for words in plain}


def test_the_readme_begins_with_what_it_is_and_ends_with_its_tests() -> None:
    text = (ROOT / "README.md").read_text(encoding="utf-8")
    places = [
        text.index(words)
        for words in (
            "calibrates the material parameters",
            "(docs/images/heap.gif)",
            "<!-- first command -->",
            "## Where to go next",
            "## From Python",
            "<!-- test command -->",
        )
    ]
    assert places == sorted(places)
    assert "\n## " not in text[places[-1] :]
