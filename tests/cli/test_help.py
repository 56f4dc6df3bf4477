"""Help of every command at 80 columns: whole names, no types of flags, all defaults."""

from __future__ import annotations

import re
from typing import Any

import pytest
import typer
from typer.testing import CliRunner

from grainfit.cli.app import app
from grainfit.cli.help_texts import WORK_FOLDER

GROUP: Any = typer.main.get_command(app)
COMMANDS: dict[tuple[str, ...], Any] = {
    (): GROUP,
    **{(name,): command for name, command in GROUP.commands.items()},
    **{("runs", name): command for name, command in GROUP.commands["runs"].commands.items()},
}


def help_of(*command: str) -> str:
    done = CliRunner(env={"COLUMNS": "80"}).invoke(app, [*command, "--help"])
    assert done.exit_code == 0, done.output
    return done.output


@pytest.mark.parametrize("command", COMMANDS, ids=" ".join)
def test_help_in_80_columns_cuts_no_option_and_gives_flags_no_type(
    command: tuple[str, ...],
) -> None:
    shown = help_of(*command)
    assert max(map(len, shown.splitlines())) <= 80
    assert not re.search(r"…|bool|\bpath>|\\", shown, re.IGNORECASE)
    names = set(re.findall(r"--?[\w-]+", shown))
    for parameter in COMMANDS[command].params:
        if parameter.param_type_name == "option":
            assert {*parameter.opts, *parameter.secondary_opts} <= names
    assert {"--quiet", "--verbose", "--help"} <= names or command == ("runs",)


@pytest.mark.parametrize("command", [(), ("runs",)], ids=" ".join)
def test_help_of_a_group_has_the_whole_first_sentence_of_each_command(
    command: tuple[str, ...],
) -> None:
    shown = " ".join(help_of(*command).partition("Commands:")[2].split())
    for name, one in COMMANDS[command].commands.items():
        assert f"{name} {' '.join(one.help.partition('.')[0].split())}" in shown


@pytest.mark.parametrize(
    ("command", "option", "default"),
    [
        (["run"], "--strategy", "from the file"),
        (["run"], "--workdir", WORK_FOLDER),
        (["run"], "--design-runs", r"d \+ 2 for d.*"),
        (["new"], "--test", "heap; on a terminal it asks"),
        (["advise"], "--test", "all bulk tests"),
        (["advise"], "--seeds", "2"),
        (["export"], "--output", "standard output"),
        (["preview"], "--set", "the middle of its interval"),
        (["runs", "list"], "--limit", "30, with --json all"),
    ],
)
def test_help_shows_the_default_of_option(command: list[str], option: str, default: str) -> None:
    [text] = re.findall(rf"^  (?:-\w, )?{option} .*\n(?:    .*\n)*", help_of(*command), re.M)
    assert re.search(rf"\[default: {default}\]", " ".join(text.split())), text


def test_options_of_the_search_have_a_heading_of_their_own() -> None:
    usual, _, search = help_of("run").partition("Options of the search (default: from the file):")
    assert "--workdir" in usual
    assert "--max-runs" not in usual
    assert "--max-runs" in search
