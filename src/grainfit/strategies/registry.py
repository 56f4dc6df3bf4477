"""Strategies by name: the built-in ones, and those of other packages.

A package offers a strategy of its own by an entry point of the group ``grainfit.strategies``:

.. code-block:: toml

    [project.entry-points."grainfit.strategies"]
    my_strategy = "my_package.my_module:MyStrategy"
"""

from __future__ import annotations

import warnings
from collections.abc import Mapping
from functools import cache
from importlib.metadata import EntryPoint, entry_points
from types import MappingProxyType
from typing import Any

from grainfit.errors import Fault, InputError
from grainfit.options.fields import Option, options_of
from grainfit.options.kinds import suggest
from grainfit.strategies.base import Strategy

GROUP = "grainfit.strategies"
DEFAULT_STRATEGY = "sequential"
#: Built-in strategies: the name in the calibration file, and the class of the options.
_BUILT_IN = {
    "sequential": "grainfit.strategies.sequential.strategy:Sequential",
    "staged": "grainfit.strategies.staged.strategy:Staged",
}


@cache
def strategies() -> Mapping[str, type[Strategy]]:
    """Return all strategies by name, the built-in ones first.

    One of another package that cannot be used is left out with a warning.
    """
    found = {name: EntryPoint(name, at, GROUP).load() for name, at in _BUILT_IN.items()}
    for point in entry_points(group=GROUP):
        try:
            found[point.name] = _loaded(point, found)
        except Exception as error:
            # The code of another package must not keep anybody from using the others.
            warnings.warn(
                f"the strategy {point.name!r} ({point.value}) is left out: {error}", stacklevel=2
            )
    return MappingProxyType(found)


def _loaded(point: EntryPoint, known: Mapping[str, type[Strategy]]) -> type[Strategy]:
    if point.name in known:
        raise ValueError("there is another one of this name")
    strategy = point.load()
    if not (isinstance(strategy, type) and issubclass(strategy, Strategy)):
        raise TypeError("it is no subclass of grainfit.Strategy")
    if strategy.name != point.name:
        raise ValueError(f"its class calls it {strategy.name!r}")
    return strategy


def strategy_named(name: str) -> type[Strategy]:
    """Return the options class of a strategy.

    Raises
    ------
    InputError
        There is no strategy of this name.
    """
    if name not in strategies():
        remedy = f"Use one of: {', '.join(strategies())}."
        raise InputError(Fault("strategy", f"{name!r} is unknown.", remedy))
    return strategies()[name]


def make_strategy(name: str, options: Mapping[str, Any]) -> Strategy:
    """Make a strategy from its name and options.

    Raises
    ------
    InputError
        There is no such strategy, or it does not have or accept some option.
    """
    strategy = strategy_named(name)
    faults = option_faults(name, options)
    if faults:
        raise InputError(faults)
    return strategy(**options)


def option_faults(name: str, options: Mapping[str, Any]) -> list[Fault]:
    """Return a fault for every option that a strategy does not have."""
    own = [known.name for known in options_of(strategy_named(name))]
    return [
        Fault(key, f"has no meaning for the {name} strategy.", _instead(key, own))
        for key in options
        if key not in own
    ]


def _instead(key: str, own: list[str]) -> str:
    others = [
        f'"{name}"'
        for name, strategy in strategies().items()
        if key in (known.name for known in options_of(strategy))
    ]
    if others:
        return f"Leave it out, or use strategy {' or '.join(others)}."
    return suggest(key, own, "Its options")


def as_strategy(strategy: object) -> Strategy:
    """Return a strategy that is given as an object or by its name.

    Raises
    ------
    InputError
        It is neither a strategy nor the name of one.
    """
    if isinstance(strategy, Strategy):
        return strategy
    if isinstance(strategy, str):
        return make_strategy(strategy, {})
    names = " or ".join(f'"{name}"' for name in strategies())
    remedy = f"Give {names}, or an object such as grainfit.Sequential()."
    raise InputError(Fault("strategy", f"is {strategy!r}.", remedy))


def changed(strategy: Strategy, name: str | None, options: Mapping[str, Any]) -> Strategy:
    """Return a strategy with some options, or all of it, replaced.

    Parameters
    ----------
    strategy : Strategy
        Its options that are not at their default are kept.
    name : str, optional
        Another strategy to take these options.
    options : mapping of str to object
        Options that win.
    """
    given = {
        known.name: value
        for known in options_of(strategy)
        if (value := getattr(strategy, known.name)) != known.default
    }
    return make_strategy(name or strategy.name, given | dict(options))


def all_options() -> dict[str, dict[str, Option]]:
    """Return the options of all strategies by name, each by the strategies that have it."""
    found: dict[str, dict[str, Option]] = {}
    for name, strategy in strategies().items():
        for known in options_of(strategy):
            found.setdefault(known.name, {})[name] = known
    return found


def describe_option(declared: Mapping[str, Option]) -> str:
    """Return help and defaults of an option, by the strategies that have it, in one text."""
    helps = list(dict.fromkeys(known.help for known in declared.values()))
    if len(helps) > 1:
        helps = [f"{name}: {known.help}" for name, known in declared.items()]
    defaults = list(dict.fromkeys(known.default_words for known in declared.values()))
    if len(defaults) > 1:
        defaults = [f"{known.default_words} ({name})" for name, known in declared.items()]
    text = f"{' '.join(helps)} Default: {', '.join(defaults)}."
    if len(declared) == len(strategies()):
        return text
    return f"{text} Strategy: {', '.join(declared)}."
