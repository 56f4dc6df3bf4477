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
from grainfit.plain_data import read_plain

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
    kind: type[Kept],
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
    kind : type
        Dataclass of what is kept.
    measure : callable
        Returns what to keep; called with the name of the folder, which it makes.
    keep_version : bool
        Take what another version of the code has measured, too.
    """
    key = hashlib.sha256(json.dumps(what).encode()).hexdigest()[:12]
    name = f"{stem}_{key}"
    path = folder / name / _MEASURED
    kept = read_kept(path, kind)
    if kept is not None and (keep_version or kept.version == version_of_code()):
        return kept
    kept = measure(name)
    write_atomically(path, json.dumps(asdict(kept)))
    return kept


def read_kept(path: Path, kind: type[Kept]) -> Kept | None:
    """Return what was kept; None if there is nothing, or if it is damaged."""
    try:
        found: Kept = read_plain(kind, json.loads(path.read_text(encoding="utf-8")))
    except (OSError, ValueError):
        return None
    return found
