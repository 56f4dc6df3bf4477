"""Help of the commands: every option with its whole name, its text beside or below it."""

from __future__ import annotations

from collections import defaultdict
from typing import Any

from typer.core import TyperCommand, TyperGroup
from typing_extensions import override

#: Default of the options that name a work folder.
WORK_FOLDER = "the file's name with .grainfit, here"


def shown_default(text: str) -> str:
    """Return a default in the form in which the help shows all defaults.

    Examples
    --------
    >>> shown_default("all bulk tests")
    '[default: all bulk tests]'
    """
    return f"[default: {text}]"


class CommandWithPanels(TyperCommand):
    """A command whose help lists its options under the headings of their panels."""

    @override
    def format_options(self, ctx: Any, formatter: Any) -> None:
        panels = defaultdict[str, list[tuple[str, str]]](list)
        for parameter in self.get_params(ctx):
            record = parameter.get_help_record(ctx)
            if record is None:
                continue
            if parameter.param_type_name == "argument":
                # Without its type, which the name and the text say.
                panels["Arguments"].append((record[0].partition(" <")[0], record[1]))
            else:
                panels[getattr(parameter, "rich_help_panel", None) or "Options"].append(record)
        for title, records in panels.items():
            with formatter.section(title):
                formatter.write_dl(records)


class GroupWithSummaries(TyperGroup):
    """Commands whose help has the whole first paragraph of each."""

    @override
    def format_commands(self, ctx: Any, formatter: Any) -> None:
        commands = {name: self.get_command(ctx, name) for name in self.list_commands(ctx)}
        with formatter.section("Commands"):
            formatter.write_dl(
                [
                    (name, " ".join((command.help or "").split("\n\n")[0].split()))
                    for name, command in commands.items()
                    if command is not None
                ]
            )
