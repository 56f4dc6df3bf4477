"""Nothing that the command line does needs an extra; what does says which one."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest
from sand_files import FILE, MODEL

EXTRAS = (
    "IPython",
    "arviz",
    "cv2",
    "ipywidgets",
    "pandas",
    "parsl",
    "plotly",
    "psycopg",
    "pyarrow",
)
#: Python runs it at its start, and takes these packages for not installed.
SITE = f"""
import sys

class Without:
    def __init__(self, finder):
        self._finder = finder

    def __getattr__(self, name):
        return getattr(self._finder, name)

    def find_spec(self, name, *where):
        if name.partition(".")[0] in {EXTRAS}:
            return None
        return self._finder.find_spec(name, *where)

sys.meta_path[:] = [Without(finder) for finder in sys.meta_path]
"""
#: Many commands in one process: most of their time is that of imports.
COMMANDS = """
import json, sys
from typer.testing import CliRunner
from grainfit.cli.app import app

for arguments in json.loads(sys.argv[1]):
    done = CliRunner().invoke(app, arguments)
    assert done.exit_code == 0, (arguments, done.output, done.exception)
"""
MODULES = """
import importlib, pkgutil, grainfit

# The modules that an extra is for, and those that end the interpreter or test others.
apart = (
    "grainfit.__main__",
    "grainfit.campaign.cluster.",
    "grainfit.campaign.store.postgresql",
    "grainfit.testing.",
)
for module in pkgutil.walk_packages(grainfit.__path__, "grainfit."):
    if not module.name.startswith(apart):
        importlib.import_module(module.name)
"""
PYTHON = """
import grainfit as gf
from grainfit.cli.app import app
from typer.testing import CliRunner

saved = gf.open("sand.grainfit")
for use in (
    saved.runs,
    lambda: gf.plots.convergence(saved),
    lambda: saved.analyse().posterior.to_arviz(),
):
    try:
        use()
    except gf.InputError as error:
        print(error)
print(CliRunner().invoke(app, ["runs", "export", "sand.grainfit", "runs.parquet"]).exception)
print(CliRunner().invoke(app, ["photo", "heap.jpg"]).exception)
"""


def python(program: str, *arguments: str, folder: Path) -> str:
    """Run a program in an interpreter without the packages of the extras."""
    site = folder / "site"
    site.mkdir(exist_ok=True)
    (site / "sitecustomize.py").write_text(SITE)
    path = os.pathsep.join(filter(None, [str(site), os.environ.get("PYTHONPATH")]))
    done = subprocess.run(
        [sys.executable, "-c", program, *arguments],
        cwd=folder,
        env={**os.environ, "PYTHONPATH": path},
        capture_output=True,
        text=True,
        timeout=300,
        check=False,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


def test_the_packages_of_the_extras_are_really_hidden(tmp_path: Path) -> None:
    found = python(
        "import importlib.util as u, sys; print(*[n for n in sys.argv[1:] if u.find_spec(n)])",
        *EXTRAS,
        "scipy",
        folder=tmp_path,
    )
    assert found.split() == ["scipy"]


@pytest.fixture(scope="module")
def calibrated(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder in which the commands of a calibration were called, without any extra."""
    folder = tmp_path_factory.mktemp("without")
    (folder / "model.py").write_text(MODEL)
    (folder / "sand.toml").write_text(FILE)
    work = "sand.grainfit"
    run = ["run", "sand.toml", "--max-runs", "12"]
    commands = [
        ["new", "new.toml", "--material", "sand"],
        ["check", "sand.toml"],
        ["preview", "new.toml"],
        [*run, "--watch", "--no-open"],
        [*run, "--workdir", "other", "--seed", "5", "--no-report"],
        ["simulate", "sand.toml"],
        ["status", work],
        ["result", work, "--json"],
        ["report", work],
        ["compare", work, "other"],
        ["export", work, "--to", "json", "--output", "card.json"],
        ["runs", "list", work],
        ["runs", "show", work, "1"],
        ["runs", "export", work, "runs.csv"],
        ["runs", "import", "sand.toml", "runs.csv", "--workdir", "imported"],
        ["analyse", "sand.toml", "--runs", "runs.csv"],
        ["runs", "prune", work],
    ]
    python(COMMANDS, json.dumps(commands), folder=folder)
    return folder


def test_a_calibration_its_report_and_its_tables_need_no_extra(calibrated: Path) -> None:
    assert (calibrated / "sand.grainfit" / "report.html").stat().st_size > 1_000_000
    assert len((calibrated / "runs.csv").read_text().splitlines()) > 8


def test_all_of_the_package_but_jobs_of_clusters_is_imported_without_extras(
    tmp_path: Path,
) -> None:
    python(MODULES, folder=tmp_path)


def test_what_needs_an_extra_says_which_and_how_to_install_it(calibrated: Path) -> None:
    said = python(PYTHON, folder=calibrated).splitlines()
    assert said == [
        "a table of runs needs the Python package pandas, which is not installed. "
        "Install it with: pip install 'grainfit[notebook]'.",
        "a figure needs the Python package plotly, which is not installed. "
        "Install it with: pip install 'grainfit[notebook]'.",
        "a posterior for ArviZ needs the Python package arviz, which is not installed. "
        "Install it with: pip install 'grainfit[arviz]'.",
        "a Parquet file needs the Python package pandas, which is not installed. "
        "Install it with: pip install 'grainfit[parquet]'. Or export to a .csv file.",
        "a measurement on photographs needs the Python package cv2, which is not installed. "
        "Install it with: pip install 'grainfit[photos]'.",
    ]
