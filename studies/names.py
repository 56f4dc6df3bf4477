"""Names that the commands of all studies take: of their steps, of materials."""

from __future__ import annotations

from collections.abc import Callable, Collection

import typer


def one_of(kind: str, known: Collection[str]) -> Callable[[str], str]:
    """Return the reader of an argument that is one of some names."""

    def read(name: str) -> str:
        if name not in known:
            raise typer.BadParameter(f"There is no {kind} {name!r}.")
        return name

    return read
