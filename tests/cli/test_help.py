"""Help of every command: defaults and brackets are shown."""

from __future__ import annotations

import re

import pytest
import typer
from typer.testing import CliRunner

from grainfit.cli.app import app
from grainfit.cli.help_texts import WORK_FOLDER


def _commands() -> list[list[str]]:
    group = typer.main.get_command(app)
    commands = dict(group.commands)  # type: ignore[attr-defined]
    runs = commands.pop("runs")
    return [*([name] for name in commands), *(["runs", name] for name in runs.commands)]


@pytest.fixture(autouse=True)
def wide(monkeypatch: pytest.MonkeyPatch) -> None:
    """A terminal that breaks no line; Typer asks for the width when it is imported."""
    monkeypatch.setattr("typer.rich_utils.MAX_WIDTH", 1000)


def help_of(*command: str) -> str:
    done = CliRunner().invoke(app, [*command, "--help"])
    assert done.exit_code == 0, done.output
    return done.output


@pytest.mark.parametrize("command", _commands(), ids=" ".join)
def test_help_of_command_leaves_out_no_bracket_of_its_texts(command: list[str]) -> None:
    shown = help_of(*command)
    assert "Default:" not in shown
    assert "\\[" not in shown
    for option in ("--quiet", "--verbose", "--help"):
        assert option in shown


@pytest.mark.parametrize(
    ("command", "option", "default"),
    [
        (["run"], "--strategy", "from the file"),
        (["run"], "--workdir", WORK_FOLDER),
        (["run"], "--design-runs", r"1\.5 \(d \+ 1\).*"),
        (["new"], "--test", "heap; on a terminal it asks"),
        (["advise"], "--test", "all bulk tests"),
        (["advise"], "--seeds", "2"),
        (["export"], "--output", "standard output"),
        (["preview"], "--set", "the middle of its interval"),
        (["runs", "list"], "--limit", "30, with --json all"),
    ],
)
def test_help_shows_the_default_of_option(command: list[str], option: str, default: str) -> None:
    [line] = re.findall(rf"^\W+{option} .*", help_of(*command), re.M)
    assert re.search(rf"\[default: {default}\]", line), line


@pytest.mark.parametrize("command", [["advise"], ["simulate"], ["runs", "prune"]])
def test_help_breaks_paragraphs_where_the_terminal_ends_only(command: list[str]) -> None:
    words = help_of(*command).partition("Arguments")[0].strip().splitlines()
    paragraphs = "\n".join(line.strip() for line in words).split("\n\n")
    assert len(paragraphs) > 2
    assert [one for one in paragraphs if "\n" in one] == []
