"""What a bulk test is: decks in, responses out.

A bulk test knows its geometry, how to write a solver's input into a run folder, and how to measure
what the solver left there. It knows nothing of campaigns, and it never starts a solver itself.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping
from pathlib import Path
from typing import Any, ClassVar

from grainfit.evaluation import Response


class BulkTest(ABC):
    """A laboratory test of a bulk solid, ready to be simulated."""

    #: Name in the calibration file, ``type = "..."``.
    type: ClassVar[str]
    #: Names and units of the responses that it yields.
    response_units: ClassVar[Mapping[str, str]]

    @abstractmethod
    def definition(self) -> dict[str, Any]:
        """Return all of the test that decides a run's outcome (geometry, procedure), as JSON."""

    @abstractmethod
    def write_deck(
        self, folder: Path, solver: str, material: Mapping[str, float], seed: int
    ) -> Path:
        """Write everything that a solver reads into the folder; return the deck to start with.

        Parameters
        ----------
        folder : Path
            The run's own folder.
        solver : str
            ``"lammps"`` or ``"liggghts"``.
        material : mapping of str to float
            Material parameters by dotted name; those with a default may be missing.
        seed : int
            Insertion seed.
        """

    @abstractmethod
    def measure(self, folder: Path) -> dict[str, Response]:
        """Measure the responses on what the solver left in the folder.

        Raises
        ------
        NotMeasurableError
            A response has no value there, with the reason.
        """
