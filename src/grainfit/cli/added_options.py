"""Options that are added to the signature of a command."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Collection, Mapping
from functools import wraps
from typing import Any, get_type_hints


def added_option(name: str, annotation: Any, default: Any = None) -> inspect.Parameter:
    """Return the parameter of an option."""
    kind = inspect.Parameter.POSITIONAL_OR_KEYWORD
    return inspect.Parameter(name, kind, default=default, annotation=annotation)


def with_options(
    command: Callable[..., Any],
    added: Collection[inspect.Parameter],
    use: Callable[[dict[str, Any]], Mapping[str, Any]],
) -> Callable[..., Any]:
    """Add options to a command.

    Parameters
    ----------
    command : callable
        The command.
    added : collection of inspect.Parameter
        Parameters of the options.
    use : callable
        Takes the values of the added options, and returns arguments of the command that are no
        options of their own.
    """

    @wraps(command)
    def derived(**values: Any) -> Any:
        given = {parameter.name: values.pop(parameter.name) for parameter in added}
        return command(**values, **use(given))

    hints = get_type_hints(command, include_extras=True)
    own = [
        parameter.replace(annotation=hints[parameter.name])
        for parameter in inspect.signature(command).parameters.values()
        if parameter.kind is not inspect.Parameter.KEYWORD_ONLY
    ]
    derived.__signature__ = inspect.Signature([*own, *added])  # type: ignore[attr-defined]
    derived.__annotations__ = {p.name: p.annotation for p in (*own, *added)}
    return derived
