"""What is measured on several pictures or videos at once, kept in a folder of its own."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar, Protocol, TypeVar

from grainfit.files import write_atomically
from grainfit.photographs.kept import version_of_code

if TYPE_CHECKING:
    from dataclasses import Field

#: What was measured, in the folder.
_MEASURED = "measured.json"


class _Versioned(Protocol):
    """A dataclass that names the code which measured it."""

    __dataclass_fields__: ClassVar[dict[str, Field[Any]]]

    @property
    def version(self) -> str: ...


Kept = TypeVar("Kept", bound=_Versioned)


def kept_once(
    folder: Path,
    stem: str,
    what: object,
    from_json: Callable[[Any], Kept],
    measure: Callable[[str], Kept],
    *,
    keep_version: bool,
) -> Kept:
    """Return what was kept, or else measure it now, and keep it.

    Parameters
    ----------
    folder : Path
        Where the folders of all that is kept are.
    stem : str
        Beginning of the folder's name.
    what : object
        All that decides what is measured, as plain data: its hash is the end of the name.
    from_json : callable
        Returns what was kept from plain data; its errors are those of damaged data.
    measure : callable
        Returns what to keep; called with the name of the folder, which it makes.
    keep_version : bool
        Take what another version of the code has measured, too.
    """
    key = hashlib.sha256(json.dumps(what).encode()).hexdigest()[:12]
    name = f"{stem}_{key}"
    path = folder / name / _MEASURED
    kept = _read(path, from_json)
    if kept is not None and (keep_version or kept.version == version_of_code()):
        return kept
    kept = measure(name)
    write_atomically(path, json.dumps(asdict(kept)))
    return kept


def _read(path: Path, from_json: Callable[[Any], Kept]) -> Kept | None:
    """Return what was kept; None if there is nothing, or if it is damaged."""
    try:
        return from_json(json.loads(path.read_text(encoding="utf-8")))
    except (OSError, ValueError, TypeError, KeyError, AttributeError):
        return None
