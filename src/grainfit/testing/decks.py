"""Write the deck of a bulk test without running it."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from grainfit.bulk_tests.base import BulkTest
from grainfit.solvers.registry import DEM_PROGRAMS


def write_deck(
    test: BulkTest, folder: Path, solver: str, material: Mapping[str, float], seed: int
) -> Path:
    """Write everything that a solver reads into the folder; return the deck to start with."""
    folder.mkdir(exist_ok=True)
    return DEM_PROGRAMS[solver].deck(test.scene(material, seed), folder).write()
