"""A saved calibration with its analysis, advice, material card and report."""

from __future__ import annotations

from dataclasses import dataclass, fields
from pathlib import Path
from typing import TYPE_CHECKING, Any

from grainfit.one_line import OneLine
from grainfit.work_folder.saved_calibration import SavedCalibration

if TYPE_CHECKING:
    from grainfit.cards import WritableCard
    from grainfit.which_test.next_test import Advice


@dataclass(frozen=True)
class OpenedCalibration(SavedCalibration, OneLine):
    """A saved calibration that also gives advice and creates its material card and its report.

    A subclass, because the packages of cards and reports depend on that of work folders.
    """

    def advise(self, **options: Any) -> Advice:
        """Compute which further test would settle the parameters that the runs leave open.

        Parameters
        ----------
        **options : object
            See `grainfit.work_folder.advice.advise`.

        Examples
        --------
        >>> print(saved.advise(max_seconds=600))  # doctest: +SKIP
        """
        from grainfit.work_folder.advice import advise

        return advise(self, **options)

    def card(self) -> WritableCard:
        """Return the material card.

        Raises
        ------
        InputError
            The calibration has no answer yet.
        StoreError
            The result is damaged.

        Examples
        --------
        >>> saved.card().write("liggghts", "beads.liggghts")  # doctest: +SKIP
        """
        from grainfit.cards import material_card

        return material_card(self)

    def report(self, path: str | Path | None = None) -> Path:
        """Write the report and return its path; by default ``report.html`` in the work folder.

        Raises
        ------
        StoreError
            The report cannot be written.
        """
        from grainfit.report.page import write_report

        return write_report(self, path)

    def sheet(self, path: str | Path | None = None) -> Path:
        """Write the customer's sheet and return its path; by default ``sheet.pdf`` in the folder.

        Raises
        ------
        InputError
            The calibration has no answer yet.
        StoreError
            The result is damaged, or the sheet cannot be written.
        """
        from grainfit.report.sheet.sheet import write_sheet

        return write_sheet(self, path)


def open_calibration(folder: str | Path) -> OpenedCalibration:
    """Open the work folder of a calibration for reading; the calibration may be running.

    Parameters
    ----------
    folder : path
        The work folder.

    Returns
    -------
    OpenedCalibration
        The current state; open it again to see the progress.

    Raises
    ------
    StoreError
        The folder is not a work folder, its store cannot be read, or it has no calibration.

    Examples
    --------
    >>> import tempfile
    >>> import grainfit as gf
    >>> problem = gf.Problem([gf.Parameter("friction", 0.1, 0.9)], [gf.Target("angle", 30.0)])
    >>> simulate = lambda parameters, seed: {"angle": 60 * parameters["friction"]}
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     result = gf.calibrate(problem, simulate, workdir=folder)
    ...     saved = gf.open(folder)
    >>> saved.result == result
    True
    """
    saved = SavedCalibration.open(folder)
    return OpenedCalibration(**{field.name: getattr(saved, field.name) for field in fields(saved)})
