"""Files of the atlas: rows and metamodels of every stratum."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterator, Mapping
from functools import cache, cached_property
from pathlib import Path
from typing import Any

from grainfit.atlas import messages
from grainfit.atlas.differences import REFERENCE, Difference
from grainfit.atlas.reading import DamagedAtlasError, NotInAtlasError
from grainfit.atlas.row import Row, rows_in
from grainfit.atlas.strata import strata
from grainfit.atlas.surrogate import Surrogate
from grainfit.bulk_tests.base import BulkTest
from grainfit.scenes.scene import SCENES_REVISION

#: The rows that ship with the package.
SHIPPED = Path(__file__).parent / "rows"
CONTENTS = "contents.json"


class Atlas:
    """Rows and metamodels of a folder, each read when it is first asked for.

    Parameters
    ----------
    folder : Path
        Has ``NAME.jsonl`` and ``NAME.models.json`` of every stratum, ``contents.json`` with their
        hashes, and the revision of the physics.
    """

    def __init__(self, folder: Path = SHIPPED) -> None:
        self.folder = folder
        self._read: dict[str, Surrogate | None] = {}

    @cached_property
    def _contents(self) -> Mapping[str, Any]:
        try:
            found = json.loads((self.folder / CONTENTS).read_text(encoding="utf-8"))
            return found if isinstance(found.get("strata"), dict) else {}
        except (OSError, ValueError, AttributeError):
            return {}

    @property
    def is_readable(self) -> bool:
        """Whether its contents can be read; without them it tells nothing about any test."""
        return bool(self._contents)

    @property
    def _strata(self) -> Mapping[str, Any]:
        found: Mapping[str, Any] = self._contents.get("strata", {})
        return {name: one for name, one in found.items() if isinstance(one, dict)}

    @property
    def strata(self) -> tuple[str, ...]:
        """Names of the strata of which it has rows."""
        return tuple(self._strata)

    @property
    def counts(self) -> dict[str, int]:
        """Numbers of rows by stratum."""
        found = {name: one.get("count", 0) for name, one in self._strata.items()}
        return {name: one if isinstance(one, int) else 0 for name, one in found.items()}

    def of_stratum(self, name: str) -> Surrogate | None:
        """Return what it tells about a stratum; None if damaged, or of another physics."""
        if name not in self._read:
            try:
                self._read[name] = self._open(name)
            except (OSError, KeyError, TypeError, ValueError):
                self._read[name] = None
        return self._read[name]

    def require(self, name: str) -> Surrogate:
        """Return what it tells about a stratum.

        Raises
        ------
        NotInAtlasError
            It has no rows of it.
        DamagedAtlasError
            They are damaged, or of another physics.
        """
        found = self.of_stratum(name)
        if found is None:
            if name in self.strata or not self.is_readable:
                raise DamagedAtlasError(messages.DAMAGED())
            raise NotInAtlasError(messages.NO_ROWS())
        return found

    def difference(self, solver: str, stratum: str, response: str) -> Difference | None:
        """Return how far a solver is from LAMMPS in a response; None where no rows tell it."""
        try:
            mean, spread = self._strata[stratum]["solvers"][solver][response]
            return Difference(float(mean), float(spread))
        except (KeyError, TypeError, ValueError):
            return None

    def faults(self) -> Iterator[str]:
        """Yield the strata of which it has rows that tell nothing."""
        for name in self.strata:
            if self.of_stratum(name) is None:
                yield name

    def _open(self, name: str) -> Surrogate | None:
        stratum, known = strata().get(name), self._strata.get(name)
        if stratum is None or known is None or known["revision"] != revision_of(stratum.kind):
            return None
        models = models_of(self.folder, name)
        if hash_of(models) != known["models"]:
            return None
        plain = json.loads(models.read_text(encoding="utf-8"))
        dry = self._rows(stratum.kind.type) if stratum.limit else []
        return Surrogate(stratum, self._rows(name), dry, plain)

    def _rows(self, name: str) -> list[Row]:
        """Return the rows of a stratum; raise ValueError if they are not those of the contents."""
        path = rows_of(self.folder, name)
        if hash_of(path) != self._strata[name]["rows"]:
            raise ValueError(name)
        return rows_in(path)


@cache
def shipped_atlas() -> Atlas:
    """Return the atlas that ships with the package."""
    return Atlas()


def revision_of(kind: type[BulkTest]) -> str:
    """Return the revision of the physics of a test: that of scenes and decks, and its own."""
    return f"{SCENES_REVISION}.{kind.revision}"


def rows_of(folder: Path, name: str, solver: str = REFERENCE) -> Path:
    """Return the file with the rows of a stratum that a solver made."""
    return folder / (f"{name}.jsonl" if solver == REFERENCE else f"{name}.{solver}.jsonl")


def models_of(folder: Path, name: str) -> Path:
    """Return the file with the metamodels of a stratum."""
    return folder / f"{name}.models.json"


def hash_of(path: Path) -> str:
    """Return the hash of a file, as the contents have it."""
    return hashlib.sha256(path.read_bytes()).hexdigest()
