"""Options as fields of a dataclass: one declaration for Python, file, schema and docs."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field, fields
from typing import Any

from grainfit.errors import InputError
from grainfit.options.kinds import Kind
from grainfit.options.places import Findings, Place
from grainfit.options.tables import Key
from grainfit.validation import plain

#: A number in SI units (degrees for angles), or a quantity with its unit, such as ``"10 mm"``.
Amount = float | str

_METADATA = "grainfit option"


@dataclass(frozen=True)
class Derived:
    """Default of an option that follows from something else.

    Parameters
    ----------
    text : str
        The default for readers, such as ``"6 d"``.
    of : callable, optional
        Returns the default, given an object that has everything else that is known as its
        attributes. Without it the option stays None.
    """

    text: str
    of: Callable[[Any], Any] = lambda _: None


@dataclass(frozen=True)
class _Declaration:
    kind: Kind
    description: str
    default: str
    example: str
    derived: Derived | None
    remarks: Mapping[str, str]


def option(
    kind: Kind,
    description: str,
    *,
    example: str,
    default: Any = None,
    default_text: str = "",
    kw_only: bool = True,
    **remarks: str,
) -> Any:
    """Declare an option as a field of a dataclass.

    Parameters
    ----------
    kind : Kind
        Unit and limits, or the keywords to choose from.
    description : str
        One sentence or two, for schema, documentation and help.
    example : str
        A good value, as TOML.
    default : object
        Value of the field when it is not given; a `Derived` one leaves the field None.
    default_text : str
        The default for readers; the value itself when there is one.
    kw_only : bool
        Whether it is given by keyword only.
    **remarks : str
        For those who read the declarations by `option_remarks`.
    """
    derived = default if isinstance(default, Derived) else None
    if derived is not None:
        default, default_text = None, derived.text
    elif default is not None:
        default_text = default_text or f"{default} {getattr(kind, 'unit', '') or ''}".rstrip()
    declaration = _Declaration(kind, description, default_text, example, derived, remarks)
    return field(default=default, kw_only=kw_only, metadata={_METADATA: declaration})


def derived_defaults(owner: type) -> dict[str, Derived]:
    """Return the defaults of a dataclass's options that follow from something else."""
    declared = ((f.name, f.metadata.get(_METADATA)) for f in fields(owner))
    return {name: it.derived for name, it in declared if it is not None and it.derived}


def option_remarks(owner: type, name: str) -> dict[str, str]:
    """Return a remark of a dataclass's options, of those that have it."""
    declared = ((f.name, f.metadata.get(_METADATA)) for f in fields(owner))
    return {key: it.remarks[name] for key, it in declared if it is not None and name in it.remarks}


def option_keys(owner: type) -> tuple[Key, ...]:
    """Return the options of a dataclass, in the order of its fields."""
    declared = [(f.name, f.metadata.get(_METADATA)) for f in fields(owner)]
    return tuple(
        Key(name, it.kind, it.description, example=it.example, default=it.default)
        for name, it in declared
        if it is not None
    )


def read_options(keys: Iterable[Key], given: Mapping[str, Any]) -> dict[str, Any]:
    """Read options given in Python: numbers, or texts with a unit.

    Parameters
    ----------
    keys : iterable of Key
        The options.
    given : mapping of str to object
        Values by name; None stands for the default, and stays.

    Returns
    -------
    dict
        All of the options; a plain number stays as it was given.

    Raises
    ------
    InputError
        Names every option at fault, with its value.
    """
    findings = Findings()
    values = {key.name: _read(key, given.get(key.name), findings) for key in keys}
    InputError.raise_for(findings.faults)
    return values


def _read(key: Key, value: Any, findings: Findings) -> Any:
    if value is None:
        return None
    value = plain(value)
    read = key.kind.read(value, Place(findings, (key.name,)))
    # 1 and 1.0 are written differently into the identity of a run: keep what was given.
    return value if read is not None and read == value else read
