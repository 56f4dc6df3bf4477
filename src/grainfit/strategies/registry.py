"""Strategies by name: the built-in ones, and those of other packages.

A package adds a strategy with an entry point of the group ``grainfit.strategies``:

.. code-block:: toml

    [project.entry-points."grainfit.strategies"]
    my_strategy = "my_package.my_module:MyStrategy"
"""

from __future__ import annotations

import warnings
from collections.abc import Mapping
from dataclasses import fields, replace
from functools import cache
from importlib.metadata import EntryPoint, entry_points
from types import MappingProxyType
from typing import Any

from grainfit.errors import Fault, InputError
from grainfit.options.fields import option_keys
from grainfit.options.kinds import suggest
from grainfit.options.tables import Key
from grainfit.registration import gaps, incomplete, require_complete
from grainfit.strategies import messages
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

    A strategy of another package that cannot be used is left out with a warning.
    """
    found: dict[str, type[Strategy]] = {}
    for name, at in _BUILT_IN.items():
        found[name] = EntryPoint(name, at, GROUP).load()
        require_complete("strategy", name, gaps(found[name], ["name"]))
    for point in entry_points(group=GROUP):
        try:
            found[point.name] = _loaded(point, found)
        except Exception as error:
            # An error in another package must not prevent the use of all other strategies.
            left_out = messages.LEFT_OUT(name=point.name, place=point.value, error=error)
            warnings.warn(left_out, stacklevel=2)
    return MappingProxyType(found)


def _loaded(point: EntryPoint, known: Mapping[str, type[Strategy]]) -> type[Strategy]:
    if point.name in known:
        raise ValueError(messages.NAME_TAKEN())
    strategy = point.load()
    if not (isinstance(strategy, type) and issubclass(strategy, Strategy)):
        raise TypeError(messages.NO_SUBCLASS())
    if sentence := incomplete("strategy", point.value, gaps(strategy, ["name"])):
        raise TypeError(sentence)
    if strategy.name != point.name:
        raise ValueError(messages.OTHER_NAME(name=strategy.name))
    return strategy


def strategy_named(name: str) -> type[Strategy]:
    """Return the options class of a strategy.

    Raises
    ------
    InputError
        There is no strategy of this name.
    """
    if name not in strategies():
        known = ", ".join(strategies())
        raise InputError(messages.UNKNOWN_STRATEGY.fault("strategy", name=name, known=known))
    return strategies()[name]


def make_strategy(name: str, options: Mapping[str, Any]) -> Strategy:
    """Make a strategy from its name and options.

    Raises
    ------
    InputError
        There is no such strategy, or it does not have or accept some option.
    """
    strategy = strategy_named(name)
    InputError.raise_for(option_faults(name, options))
    return strategy(**options)


def option_faults(name: str, options: Mapping[str, Any]) -> list[Fault]:
    """Return a fault for every option that a strategy does not have."""
    own = [known.name for known in option_keys(strategy_named(name))]
    return [
        messages.FOREIGN_OPTION.fault(key, strategy=name, instead=_instead(key, own))
        for key in options
        if key not in own
    ]


def _instead(key: str, own: list[str]) -> str:
    others = [
        f'"{name}"'
        for name, strategy in strategies().items()
        if key in (known.name for known in option_keys(strategy))
    ]
    if others:
        return messages.OPTION_OF_OTHERS(others=" or ".join(others))
    return suggest(key, own, "Its options")


def as_strategy(strategy: object) -> Strategy:
    """Return a strategy that is given as an object or by its name.

    Raises
    ------
    InputError
        The argument is neither a strategy nor the name of one.
    """
    if isinstance(strategy, Strategy):
        return strategy
    if isinstance(strategy, str):
        return make_strategy(strategy, {})
    names = " or ".join(f'"{name}"' for name in strategies())
    raise InputError(messages.NO_STRATEGY.fault("strategy", given=strategy, names=names))


def changed(strategy: Strategy, name: str | None, options: Mapping[str, Any]) -> Strategy:
    """Return a strategy with some options replaced, or another strategy with its options.

    Parameters
    ----------
    strategy : Strategy
        Its options that are not at their default are kept.
    name : str, optional
        Another strategy to take these options.
    options : mapping of str to object
        Options that replace those of the strategy.
    """
    given = {
        known.name: value
        for known in fields(strategy)
        if (value := getattr(strategy, known.name)) != known.default
    }
    return make_strategy(name or strategy.name, given | dict(options))


def all_options() -> dict[str, dict[str, Key]]:
    """Return the options of all strategies: by option name, then by strategy name."""
    found: dict[str, dict[str, Key]] = {}
    for name, strategy in strategies().items():
        for known in option_keys(strategy):
            found.setdefault(known.name, {})[name] = known
    return found


def merged_key(declared: Mapping[str, Key]) -> Key:
    """Return one key for an option that several strategies share; its kind is the first one's."""
    first = next(iter(declared.values()))
    texts = _by_strategy({name: key.description for name, key in declared.items()})
    defaults = _by_strategy({name: key.default for name, key in declared.items()})
    only = "" if len(declared) == len(strategies()) else f" Strategy: {', '.join(declared)}."
    return replace(first, description=" ".join(texts) + only, default=", ".join(defaults))


def _by_strategy(texts: Mapping[str, str]) -> list[str]:
    """Return the common text if all are the same, otherwise each text with its strategy."""
    if len(set(texts.values())) == 1:
        return [next(iter(texts.values()))]
    return [f"{text} ({name})" for name, text in texts.items()]
