"""Questions of the commands, on a terminal only."""

from __future__ import annotations

import sys
from collections.abc import Iterable, Mapping

import typer
from rich.text import Text

from grainfit.cli import messages
from grainfit.cli.consoles import err
from grainfit.cli.verbosity import is_quiet
from grainfit.errors import InputError
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
    show_options(options)
    while True:
        answer = typer.prompt(f"{question} (number or name)", default=usual, err=True)
        try:
            return as_names(answer.split(","), options)
        except InputError as error:
            err.print(str(error), style="red")


def show_options(options: Mapping[str, str]) -> None:
    """Print options with their numbers."""
    width = max(map(len, options))
    for number, (name, words) in enumerate(options.items(), 1):
        err.print(Text(f"{number:3}  {name:<{width}}  {plain(words)}"))


def as_names(answers: Iterable[str], options: Iterable[str]) -> list[str]:
    """Return the options that numbers and names stand for.

    Raises
    ------
    InputError
        One of them stands for none.
    """
    names = list(options)
    chosen = [_named(part.strip(), names) for part in answers]
    if not all(chosen):
        raise InputError(messages.NOT_IN_LIST.fault(""))
    return chosen


def _named(answer: str, names: list[str]) -> str:
    """Return the name that an answer stands for; "" for none."""
    if answer.isdecimal():
        return names[int(answer) - 1] if 1 <= int(answer) <= len(names) else ""
    if answer in names:
        return answer
    # One word is enough where it says which: sand, plastic.
    alike = [name for name in names if answer in name.split("_")]
    return alike[0] if len(alike) == 1 else ""
