"""Names of folders and files that shells, templates, patterns and pages read in another way."""

from __future__ import annotations

import unicodedata
from pathlib import Path

import pytest
from typer.testing import CliRunner

from grainfit.cli.app import app
from grainfit.options import messages as of_options

MODEL = "def simulate(parameters, seed):\n    return {'angle': 60 * parameters['friction']}\n"
FILE = """name = {name!r}
[parameters]
friction = {{ min = 0.1, max = 0.9 }}
[[test]]
type = "python"
function = "model.py:simulate"
targets.angle = {{ value = 30, tolerance = 0.6 }}
"""
NAMES = (
    "🌾 emoji",
    unicodedata.normalize("NFD", "Schüttgut äöü"),
    "a*[glob]?b",
    "back\\slash",
    "%s{x}$HOME{{y}}",
    "..dots.",
    "semi;colon & amp|pipe",
    "'single' \"double\"",
    "-leading",
    "#hash~tilde",
    "<b>html&lt;",
    "[red]rich[bold]",
)


@pytest.mark.parametrize("name", NAMES)
def test_calibration_in_a_folder_of_an_odd_name_is_made_and_read(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    folder = tmp_path / name
    folder.mkdir()
    (folder / "model.py").write_text(MODEL)
    file = folder / f"{name}.toml"
    file.write_text(FILE.format(name="sand"), encoding="utf-8")
    monkeypatch.chdir(folder)
    work = f"./{name}.grainfit"
    for arguments in (
        ("check", f"./{name}.toml"),
        ("run", f"./{name}.toml", "--no-report", "--max-runs", "9"),
        ("status", work),
        ("result", work),
        ("runs", "list", work),
    ):
        done = CliRunner().invoke(app, list(arguments))
        assert done.exit_code == 0, (arguments, done.output, done.exception)
    assert (folder / f"{name}.grainfit" / "result.json").is_file()
    assert sorted(path.name for path in tmp_path.iterdir()) == [name]


@pytest.mark.parametrize("name", ["two\nlines", "a\ttab", "x" * 200])
def test_name_that_no_run_can_have_is_refused_before_any_run(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "model.py").write_text(MODEL)
    file = tmp_path / "sand.toml"
    file.write_text(FILE.format(name="sand").replace('"python"', f'"python"\nname = {name!r}'))
    monkeypatch.chdir(tmp_path)
    done = CliRunner().invoke(app, ["check", "sand.toml"])
    assert done.exit_code == 1
    assert "test 1, name: " in str(done.exception)
    assert of_options.BAD_NAME.is_in(str(done.exception))
