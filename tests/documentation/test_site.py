"""The documentation site: built without a warning, complete, and up to date."""

from __future__ import annotations

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


@pytest.mark.slow
# The navigation of the site's own theme takes more time than all the rest.
@pytest.mark.parametrize("theme", ["basic", pytest.param("furo", marks=pytest.mark.thorough)])
def test_the_site_is_built_without_a_warning(theme: str, tmp_path: Path) -> None:
    # A copy, because the build writes pages into docs/, as may another build at the same time.
    copied = tmp_path / "copy"
    copied.mkdir()
    for name in ("examples", "tests", "CHANGELOG.md", "CONTRIBUTING.md"):
        (copied / name).symlink_to(ROOT / name)
    shutil.copytree(DOCS, copied / "docs", ignore=shutil.ignore_patterns("generated"))
    command = [sys.executable, "-m", "sphinx", "-W", "--keep-going", "-q"]
    command += ["-D", f"html_theme={theme}", "docs", "site"]
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
        assert f'"developers/{page}.html" + location.hash' in (site / f"{page}.html").read_text()


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
    listed = re.findall(
        r"^([\w/]+)$", (DOCS / "index.md").read_text(encoding="utf-8"), re.MULTILINE
    )
    pages = {
        path.relative_to(DOCS).with_suffix("").as_posix()
        for path in DOCS.rglob("*.md")
        if not {"generated", "recorded"} & set(path.relative_to(DOCS).parts)
    }
    assert pages - set(listed) == {"index"}


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
