"""Command-line options of the search, derived from the declared options."""

from __future__ import annotations

import inspect
from collections.abc import Callable
from typing import Annotated, Any

import typer

from grainfit.calibration.options import CalibrationOptions
from grainfit.cli.added_options import added_option, with_options
from grainfit.cli.help_texts import shown_default
from grainfit.options.fields import option_keys
from grainfit.options.kinds import Choice, Flag, Kind, Whole
from grainfit.options.tables import Key
from grainfit.strategies.registry import all_options, merged_key

_PANEL = "Options of the search (default: from the file)"


def with_search_options(command: Callable[..., None]) -> Callable[..., None]:
    """Add the options of calibrations and strategies to a command.

    Parameters
    ----------
    command : callable
        Gets the options that were given as the dictionary ``search_options``, a parameter that must
        be named.
    """
    of_strategies = map(merged_key, all_options().values())
    added = [_parameter(key) for key in (*option_keys(CalibrationOptions), *of_strategies)]

    def given(values: dict[str, Any]) -> dict[str, Any]:
        known = {name: value for name, value in values.items() if value is not None}
        return {"search_options": known}

    return with_options(command, added, given)


def _parameter(option: Key) -> inspect.Parameter:
    option = option.in_words()
    flag = "--" + option.name.replace("_", "-")
    spelled = f"{flag}/--no-{flag[2:]}" if isinstance(option.kind, Flag) else flag
    declared = typer.Option(
        spelled,
        metavar=None if isinstance(option.kind, Flag) else _metavar(option.kind),
        help=f"{option.description} {shown_default(option.default)}",
        show_default=False,
        rich_help_panel=_PANEL,
    )
    return added_option(option.name, Annotated[_type(option.kind) | None, declared])


def _metavar(kind: Kind) -> str:
    if isinstance(kind, Choice):
        return "|".join(kind.options)
    return "N" if isinstance(kind, Whole) else "VALUE"


def _type(kind: Kind) -> type:
    # A quantity may have a unit: its text is read where the option is checked.
    return {Whole: int, Flag: bool}.get(type(kind), str)
