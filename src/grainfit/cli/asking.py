"""Questions of the commands, on a terminal only."""

from __future__ import annotations

import sys
from collections.abc import Mapping

import typer
from rich.text import Text

from grainfit.cli import messages
from grainfit.cli.consoles import err
from grainfit.cli.verbosity import is_quiet
from grainfit.formatting import plain


def can_ask() -> bool:
    """Return whether somebody sits at a terminal and wants to be asked."""
    return sys.stdin.isatty() and err.is_terminal and not is_quiet()


def choose(question: str, options: Mapping[str, str], usual: str) -> list[str]:
    """Ask for one or several of some options, by number or by name, with commas between them.

    Parameters
    ----------
    question : str
        Question, without its mark.
    options : mapping of str to str
        Names, and what they stand for.
    usual : str
        Name that an empty answer chooses.
    """
    names = list(options)
    width = max(map(len, names))
    for number, (name, words) in enumerate(options.items(), 1):
        err.print(Text(f"{number:3}  {name:<{width}}  {plain(words)}"))
    while True:
        answer = typer.prompt(f"{question} (number or name)", default=usual, err=True)
        chosen = [_named(part.strip(), names) for part in answer.split(",")]
        if all(chosen):
            return chosen
        err.print(messages.NOT_IN_LIST(), style="red")


def _named(answer: str, names: list[str]) -> str:
    """Return the name that an answer stands for; "" for none."""
    if answer.isdecimal():
        return names[int(answer) - 1] if 1 <= int(answer) <= len(names) else ""
    if answer in names:
        return answer
    # One word is enough where it says which: sand, plastic.
    alike = [name for name in names if answer in name.split("_")]
    return alike[0] if len(alike) == 1 else ""
