"""How much the commands print: the options --quiet and --verbose of all of them."""

from __future__ import annotations

import inspect
from collections.abc import Callable
from enum import IntEnum
from functools import wraps
from typing import Annotated, Any, TypeVar, get_type_hints

import typer
from typing_extensions import override

from grainfit.cli.consoles import err_remarks, out_remarks
from grainfit.cli.help_texts import paragraphs

_Command = TypeVar("_Command", bound=Callable[..., Any])


class Verbosity(IntEnum):
    """How much is printed."""

    QUIET = -1
    USUAL = 0
    VERBOSE = 1


Quiet = Annotated[
    bool, typer.Option("--quiet", "-q", help="Print only results, warnings and errors.")
]
Verbose = Annotated[
    bool, typer.Option("--verbose", "-v", help="Print every run of a calibration as it ends.")
]
_OPTIONS = {"quiet": Quiet, "verbose": Verbose}
_chosen = Verbosity.USUAL


def is_quiet() -> bool:
    """Return whether progress, paths and remarks are left out."""
    return _chosen is Verbosity.QUIET


def is_verbose() -> bool:
    """Return whether every run is printed."""
    return _chosen is Verbosity.VERBOSE


def begin(*, quiet: bool = False, verbose: bool = False) -> None:
    """Begin a command with the options before its name."""
    _choose(Verbosity.USUAL)
    _change(quiet=quiet, verbose=verbose)


def _change(*, quiet: bool, verbose: bool) -> None:
    if quiet and verbose:
        raise typer.BadParameter("--quiet and --verbose exclude each other.")
    if quiet or verbose:
        _choose(Verbosity.QUIET if quiet else Verbosity.VERBOSE)


def _choose(wanted: Verbosity) -> None:
    global _chosen
    _chosen = wanted
    out_remarks.quiet = err_remarks.quiet = is_quiet()


class CommandLine(typer.Typer):
    """Commands, each with the options ``--quiet`` and ``--verbose``."""

    @override
    def command(self, *arguments: Any, **options: Any) -> Callable[[_Command], _Command]:
        """Register a command."""
        register = super().command(*arguments, **options)

        def registered(command: _Command) -> _Command:
            register(_with_verbosity(command))
            return command

        return registered


def _with_verbosity(command: Callable[..., Any]) -> Callable[..., Any]:
    @wraps(command)
    def derived(*, quiet: bool, verbose: bool, **values: Any) -> Any:
        _change(quiet=quiet, verbose=verbose)
        return command(**values)

    hints = get_type_hints(command, include_extras=True)
    own = [
        parameter.replace(annotation=hints[parameter.name])
        for parameter in inspect.signature(command).parameters.values()
    ]
    added = [
        inspect.Parameter(
            name, inspect.Parameter.POSITIONAL_OR_KEYWORD, default=False, annotation=annotation
        )
        for name, annotation in _OPTIONS.items()
    ]
    derived.__signature__ = inspect.Signature([*own, *added])  # type: ignore[attr-defined]
    derived.__doc__ = paragraphs(command.__doc__)
    derived.__annotations__ = {p.name: p.annotation for p in (*own, *added)}
    return derived
