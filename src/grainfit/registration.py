"""Completeness of what is registered: contact models, solvers, tests, strategies, and so on."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable

from grainfit.messages import Message

INCOMPLETE = Message("The {kind} {name} is incomplete: {missing}.")


def gaps(declared: type, attributes: Iterable[str]) -> list[str]:
    """Return what a class lacks: attributes, and methods that its base class leaves open.

    Examples
    --------
    >>> from abc import ABC, abstractmethod
    >>> class Base(ABC):
    ...     @abstractmethod
    ...     def measure(self): ...
    >>> gaps(type("Mine", (Base,), {"title": "mine"}), ["type", "title"])
    ['type is missing', 'measure is missing']
    """
    missing = [name for name in attributes if not hasattr(declared, name)]
    missing += sorted(getattr(declared, "__abstractmethods__", ()))
    return [f"{name} is missing" for name in missing]


def incomplete(kind: str, name: str, missing: Iterable[str]) -> str:
    """Return a sentence on what a registered object lacks; empty if that is nothing.

    Examples
    --------
    >>> incomplete("solver", "esys", ["deck is missing"])
    'The solver esys is incomplete: deck is missing.'
    """
    found = ", ".join(missing)
    return INCOMPLETE(kind=kind, name=name, missing=found) if found else ""


def require_complete(kind: str, name: str, missing: Iterable[str]) -> None:
    """Raise `ImportError` if a built-in object lacks something."""
    if sentence := incomplete(kind, name, missing):
        raise ImportError(sentence)


def require_unique(kind: str, names: Iterable[str]) -> None:
    """Raise `ImportError` if two built-in objects have the same name."""
    for name, number in Counter(names).items():
        require_complete(kind, name, [f"{number} have this name"] if number > 1 else [])
