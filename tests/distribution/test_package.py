"""Wheel and source distribution, their description, and the files that repeat the version."""

from __future__ import annotations

import re
import subprocess
import sys
import tarfile
import tomllib
import zipfile
from email import message_from_bytes
from importlib.metadata import version
from pathlib import Path

import pytest
import yaml

import grainfit
from hatch_build import description

ROOT = Path(__file__).parents[2]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]


@pytest.fixture(scope="module")
def built(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Folder with a source distribution, and the wheel that is built from it."""
    folder = tmp_path_factory.mktemp("built")
    command = [sys.executable, "-m", "build", "--no-isolation", "--outdir", str(folder), str(ROOT)]
    made = subprocess.run(command, capture_output=True, text=True, timeout=300)
    assert made.returncode == 0, made.stdout + made.stderr
    return folder


def test_twine_accepts_both(built: Path) -> None:
    command = [sys.executable, "-m", "twine", "check", "--strict", *map(str, built.iterdir())]
    checked = subprocess.run(command, capture_output=True, text=True, timeout=120)

    assert checked.returncode == 0, checked.stdout
    assert checked.stdout.count("PASSED") == 2


def test_the_wheel_has_every_file_of_the_package_and_no_others(built: Path) -> None:
    (wheel,) = built.glob("*.whl")
    files = {name for name in zipfile.ZipFile(wheel).namelist() if ".dist-info/" not in name}
    package = ROOT / "src" / "grainfit"
    there = {
        path.relative_to(package.parent).as_posix()
        for path in package.rglob("*")
        if path.is_file() and "__pycache__" not in path.parts
    }

    assert files == there
    assert any(name.endswith(".schema.json") for name in files)


def test_the_wheel_has_no_helper_of_our_own_tests(built: Path) -> None:
    (wheel,) = built.glob("*.whl")
    files = {Path(name).name for name in zipfile.ZipFile(wheel).namelist()}
    folders = [ROOT / "tests" / "crash", ROOT / "tests" / "servers"]
    helpers = {path.name for folder in folders for path in folder.glob("*.py")}

    assert "crash_harness.py" in helpers
    assert not helpers & files


def test_the_source_distribution_has_what_documentation_and_tests_need(built: Path) -> None:
    (archive,) = built.glob("*.tar.gz")
    with tarfile.open(archive) as file:
        names = {name.partition("/")[2] for name in file.getnames()}

    assert {
        "README.md",
        "CITATION.cff",
        "docs/conf.py",
        "docs/recorded/beads/runs.sqlite",
        "examples/glass_beads/calibration.toml",
        "recipe/meta.yaml",
        "tests/conftest.py",
        "tools/house.py",
    } <= names
    assert not [name for name in names if "generated/" in name or ".grainfit/" in name]


def test_the_description_has_no_link_that_is_dead_on_the_index(built: Path) -> None:
    (wheel,) = built.glob("*.whl")
    archive = zipfile.ZipFile(wheel)
    (name,) = [name for name in archive.namelist() if name.endswith(".dist-info/METADATA")]
    metadata = message_from_bytes(archive.read(name))
    text = str(metadata.get_payload())

    assert metadata["Description-Content-Type"] == "text/markdown"
    assert "# grainfit" in text
    words = re.sub(r"```.*?```", "", text, flags=re.DOTALL)
    targets = re.findall(r"\]\(([^)]+)\)", words)
    assert [target for target in targets if not target.startswith(("https://", "#"))] == []


def test_links_become_absolute_with_an_address() -> None:
    readme = (
        "[a](docs/a.md#b) ![c](docs/c.png) [d](https://d.org) [![e](e.png)](docs/e.md)\n"
        "<!-- mark -->\n```python\nvalues[0](x)\n```\n"
    )

    assert description(readme, "https://example.org/g") == (
        "[a](https://example.org/g/blob/main/docs/a.md#b) "
        "![c](https://example.org/g/raw/main/docs/c.png) [d](https://d.org) "
        "[![e](https://example.org/g/raw/main/e.png)](https://example.org/g/blob/main/docs/e.md)\n"
        "```python\nvalues[0](x)\n```\n"
    )
    assert description("See [a](docs/a.md).![c](c.png)", "") == "See a."


def test_the_version_is_the_same_everywhere() -> None:
    citation = yaml.safe_load((ROOT / "CITATION.cff").read_text(encoding="utf-8"))
    recipe = (ROOT / "recipe" / "meta.yaml").read_text(encoding="utf-8")
    changes = (ROOT / "CHANGELOG.md").read_text(encoding="utf-8")

    assert grainfit.__version__ == version("grainfit") == PROJECT["version"]
    assert citation["version"] == PROJECT["version"]
    assert f'set version = "{PROJECT["version"]}"' in recipe
    assert re.search(r"^## (\S+)", changes, re.MULTILINE)[1] == PROJECT["version"]  # type: ignore[index]
    assert citation["license"] == PROJECT["license"]


def test_the_recipe_has_the_dependencies_of_the_package() -> None:
    recipe = (ROOT / "recipe" / "meta.yaml").read_text(encoding="utf-8")
    run = recipe.split("\n  run:\n")[1].split("  run_constrained")[0]
    listed = {
        line.strip("- ").replace(" ", "") for line in run.splitlines() if "python >" not in line
    }

    assert listed - {""} == set(PROJECT["dependencies"])
