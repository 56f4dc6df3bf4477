"""Command-line options of the search, derived from the declared options."""

from __future__ import annotations

import inspect
from collections.abc import Callable
from functools import wraps
from typing import Annotated, Any, get_type_hints

import typer

from grainfit.calibration.options import CalibrationOptions
from grainfit.cli.help_texts import escaped, shown_default
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
        Gets the options that were given as the dictionary ``search_options``.
    """
    of_strategies = map(merged_key, all_options().values())
    added = [_parameter(key) for key in (*option_keys(CalibrationOptions), *of_strategies)]
    names = [parameter.name for parameter in added]

    @wraps(command)
    def derived(**values: Any) -> None:
        given = {name: values.pop(name) for name in names}
        known = {name: value for name, value in given.items() if value is not None}
        command(**values, search_options=known)

    hints = get_type_hints(command, include_extras=True)
    own = [
        parameter.replace(annotation=hints[parameter.name])
        for parameter in inspect.signature(command).parameters.values()
        if parameter.name != "search_options"
    ]
    signature = inspect.Signature([*own, *added])
    derived.__signature__ = signature  # type: ignore[attr-defined]
    derived.__annotations__ = {p.name: p.annotation for p in signature.parameters.values()}
    return derived


def _parameter(option: Key) -> inspect.Parameter:
    flag = "--" + option.name.replace("_", "-")
    spelled = f"{flag}/--no-{flag[2:]}" if isinstance(option.kind, Flag) else flag
    declared = typer.Option(
        spelled,
        metavar=None if isinstance(option.kind, Flag) else _metavar(option.kind),
        help=f"{escaped(option.description)} {shown_default(option.default)}",
        show_default=False,
        rich_help_panel=_PANEL,
    )
    return inspect.Parameter(
        option.name,
        inspect.Parameter.POSITIONAL_OR_KEYWORD,
        default=None,
        annotation=Annotated[_type(option.kind) | None, declared],
    )


def _metavar(kind: Kind) -> str:
    if isinstance(kind, Choice):
        return "|".join(kind.options)
    return "N" if isinstance(kind, Whole) else "VALUE"


def _type(kind: Kind) -> type:
    # A quantity may have a unit: its text is read where the option is checked.
    return {Whole: int, Flag: bool}.get(type(kind), str)
