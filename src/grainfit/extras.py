"""Packages that extras of grainfit install, imported when they are first needed."""

from __future__ import annotations

from importlib import import_module
from typing import Any

from grainfit import ground_messages as messages
from grainfit.errors import InputError


def how_to_install(extra: str) -> str:
    """Return the command that installs an extra, as the end of a message."""
    return f"Install it with: pip install 'grainfit[{extra}]'"


def import_extra(module: str, extra: str, user: str, instead: str = "") -> Any:
    """Import a module of a package that an extra installs.

    Parameters
    ----------
    module : str
        Its name, such as ``"plotly.graph_objects"``.
    extra : str
        Name of the extra.
    user : str
        What needs it, as the subject of a sentence: ``"a Parquet file"``.
    instead : str
        What to do without it, in a sentence.

    Raises
    ------
    InputError
        It is not installed.
    """
    try:
        return import_module(module)
    except ImportError as error:
        package = module.partition(".")[0]
        remedy = f"{how_to_install(extra)}. {instead}".rstrip()
        fault = messages.NOT_INSTALLED.fault("", user=user, package=package, remedy=remedy)
        raise InputError(fault) from error
