"""Evaluate the equations of a contact law, which are plain text for people."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Mapping

from grainfit.contact_models.base import ContactLaw
from grainfit.contact_models.contact import Contact, particle_mass
from grainfit.materials.equations import FUNCTIONS, Equation

_RELATION = re.compile(" <?= ")
_NAME = re.compile(r"[A-Za-z]\w*\*?")


def evaluate(equations: Iterable[Equation], known: Mapping[str, float]) -> dict[str, float]:
    """Return the right side of every equation, by its term.

    Parameters
    ----------
    equations : iterable of Equation
        In any order; a symbol alone on a left side is known from there on.
    known : mapping of str to float
        Values of symbols.

    Raises
    ------
    ValueError
        A symbol is neither known nor given by another equation.

    Examples
    --------
    >>> evaluate([Equation("radius", "R* = 1/(1/R_1 + 1/R_2)")], {"R_1": 2.0, "R_2": 2.0})
    {'radius': 1.0}
    """
    values, found, left = dict(known), {}, list(equations)
    while left:
        ready = [equation for equation in left if not unknown_symbols(equation, values)]
        if not ready:
            gaps = {equation.formula: unknown_symbols(equation, values) for equation in left}
            raise ValueError(f"symbols without a value: {gaps}")
        for equation in ready:
            symbol, expression = _RELATION.split(equation.formula)
            found[equation.term] = _value(expression, values)
            values.setdefault(symbol, found[equation.term])
            left.remove(equation)
    return found


def unknown_symbols(equation: Equation, known: Iterable[str]) -> set[str]:
    """Return the symbols on the right of an equation that are not known."""
    names = set(_NAME.findall(_RELATION.split(equation.formula)[1]))
    return names - FUNCTIONS - set(known)


def symbols_of(law: ContactLaw, contact: Contact) -> dict[str, float]:
    """Return the symbols of a contact: both bodies, and the parameters of the law."""
    other = math.inf if contact.other_radius is None else contact.other_radius
    radii = {"R_1": contact.radius, "R_2": other}
    masses = {f"m_{n[-1]}": particle_mass(contact.material, r) for n, r in radii.items()}
    found = {**radii, **masses}
    for one in law.conventions:
        if f"particle.{one.key}" in contact.material:
            found[f"{one.symbol}_1"] = contact.material[f"particle.{one.key}"]
            found[f"{one.symbol}_2"] = contact.material[f"{contact.body}.{one.key}"]
        else:
            found[one.symbol] = contact.value(one.key)
    return found


def _value(expression: str, values: Mapping[str, float]) -> float:
    """Return the value of an expression whose products have spaces for signs."""
    names = {name.replace("*", "_effective"): value for name, value in values.items()}
    text = re.sub(r"([A-Za-z]\w*)\*", r"\1_effective", expression)
    text = re.sub(r"\|([^|]+)\|", r"abs(\1)", text).replace("^", "**")
    text = re.sub(r"\s*([-+/,])\s*", r"\1", text)
    functions = {"abs": abs, "max": max, "min": min, "ln": math.log}
    for name in FUNCTIONS - functions.keys():
        functions[name] = getattr(math, name)
    return float(eval(text.strip().replace(" ", "*"), {**functions, **names}))
