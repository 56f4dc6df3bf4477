"""How much the commands print: the options --quiet and --verbose of all of them."""

from __future__ import annotations

from collections.abc import Callable
from typing import Annotated, Any, TypeVar

import typer
from typing_extensions import override

from grainfit.cli import messages
from grainfit.cli.added_options import added_option, with_options
from grainfit.cli.consoles import err_remarks, out_remarks
from grainfit.cli.help_texts import CommandWithPanels, GroupWithSummaries

_Command = TypeVar("_Command", bound=Callable[..., Any])

Quiet = Annotated[
    bool, typer.Option("--quiet", "-q", help="Print only results, warnings and errors.")
]
Verbose = Annotated[
    bool, typer.Option("--verbose", "-v", help="Print every run of a calibration as it ends.")
]
_ADDED = [added_option("quiet", Quiet, False), added_option("verbose", Verbose, False)]
_verbose = False


def is_quiet() -> bool:
    """Return whether progress, paths and remarks are left out."""
    return out_remarks.quiet


def is_verbose() -> bool:
    """Return whether every run is printed."""
    return _verbose


def begin(*, quiet: bool = False, verbose: bool = False) -> None:
    """Choose how much is printed from now on."""
    global _verbose
    if quiet and verbose:
        raise typer.BadParameter(messages.QUIET_AND_VERBOSE())
    out_remarks.quiet = err_remarks.quiet = quiet
    _verbose = verbose


def _begin_again(given: dict[str, bool]) -> dict[str, Any]:
    """Let the options of a command replace those before it."""
    if any(given.values()):
        begin(**given)
    return {}


class CommandLine(typer.Typer):
    """Commands, each with the options ``--quiet`` and ``--verbose``."""

    def __init__(self, **options: Any) -> None:
        super().__init__(
            **{"cls": GroupWithSummaries} | options,
            no_args_is_help=True,
            rich_markup_mode=None,
            context_settings={"help_option_names": ["-h", "--help"]},
        )

    @override
    def command(self, *arguments: Any, **options: Any) -> Callable[[_Command], _Command]:
        """Register a command."""
        register = super().command(*arguments, cls=CommandWithPanels, **options)

        def registered(command: _Command) -> _Command:
            register(with_options(command, _ADDED, _begin_again))
            return command

        return registered
