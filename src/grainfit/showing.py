"""Show a result or a saved calibration where one is: tables and figures in a notebook, or text."""

from __future__ import annotations

import importlib.util
from collections.abc import Iterator
from pathlib import Path
from typing import Any, Protocol

from rich.console import Console

from grainfit.opened import open_calibration
from grainfit.tables import TextTable
from grainfit.work_folder.saved_calibration import SavedCalibration


class HasSummary(Protocol):
    """A result, a saved calibration, an advice, an estimate: what has sentences and tables."""

    def summary(self) -> tuple[str | TextTable, ...]:
        """Return the sentences and tables that `print` and a notebook show."""


def show(shown: HasSummary | str | Path) -> None:
    """Show a result or another object with a summary, or the calibration in a work folder.

    In a notebook it appears with tables, and a saved calibration also with its figures, as far as
    Plotly is installed; elsewhere it is printed.

    Parameters
    ----------
    shown : object or path
        A result, saved calibration, advice, estimate or plan of measurements; or a work folder.

    Raises
    ------
    StoreError
        A path is not a work folder, or has no calibration.

    Examples
    --------
    >>> import grainfit as gf
    >>> problem = gf.Problem([gf.Parameter("friction", 0.1, 0.9)], [gf.Target("angle", 30.0)])
    >>> simulate = lambda parameters, seed: {"angle": 60 * parameters["friction"]}
    >>> gf.show(gf.calibrate(problem, simulate))  # doctest: +ELLIPSIS
    calibrated: every target is met within its tolerance
    ...
    """
    one = open_calibration(shown) if isinstance(shown, str | Path) else shown
    if not Console().is_jupyter:
        print(one)
        return
    display = importlib.import_module("IPython.display").display
    display(one)
    if isinstance(one, SavedCalibration) and importlib.util.find_spec("plotly") is not None:
        for figure in _figures(one):
            display(figure)


def _figures(saved: SavedCalibration) -> Iterator[Any]:
    from grainfit import plots

    if saved.evaluations:
        yield plots.convergence(saved)
    if saved.analyse().posterior is not None:
        yield plots.posterior(saved)
