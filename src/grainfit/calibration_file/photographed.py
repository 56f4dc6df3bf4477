"""What was measured on the photographs of a target."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from grainfit.calibration_file import messages

if TYPE_CHECKING:
    from grainfit.photographs.kept import KeptPicture


@dataclass(frozen=True)
class PhotographedTarget:
    """What was measured on the pictures of one target.

    Parameters
    ----------
    key : str
        Dotted key of the target in the file.
    test : int
        Position of its test in the file.
    response : str
        Name of the response.
    heaps : tuple of tuple of KeptPicture
        Measured pictures of each heap.
    refused : tuple of KeptPicture
        Pictures that were not measured.
    result : str
        Value and uncertainty in words.
    folder : Path
        Where overlays and what was measured are kept.
    changes : tuple of str
        How the pictures differ from those with which the calibration was begun.
    """

    key: str
    test: int
    response: str
    heaps: tuple[tuple[KeptPicture, ...], ...]
    refused: tuple[KeptPicture, ...]
    result: str
    folder: Path
    changes: tuple[str, ...] = ()

    @property
    def pictures(self) -> tuple[KeptPicture, ...]:
        """All pictures, those that were refused last."""
        return (*(one for heap in self.heaps for one in heap), *self.refused)

    def lines(self) -> Iterator[str]:
        """Yield what was measured, for people."""
        count = len(self.pictures) - len(self.refused)
        yield messages.PHOTOGRAPHS(
            response=self.response, result=self.result, count=count, heaps=len(self.heaps)
        )
        for number, heap in enumerate(self.heaps, 1):
            for one in heap:
                yield "  " + messages.PICTURE_MEASURED(
                    file=one.file,
                    heap=number,
                    angle=one.angle,
                    error=one.uncertainty,
                    flanks=" and ".join(f"{angle:.1f}" for angle in one.flanks),
                    elevation=one.elevation,
                    elevation_error=one.elevation_error,
                    seen_by=one.seen_by,
                )
        for one in self.refused:
            yield "  " + messages.PICTURE_REFUSED(file=one.file, reason=one.refused)
        yield "  " + messages.OVERLAYS(folder=self.folder)
