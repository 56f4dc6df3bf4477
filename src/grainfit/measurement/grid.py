"""Limit of grids whose size follows from data: damaged data must not fill the memory."""

from __future__ import annotations

import math

from grainfit.errors import NotMeasurableError
from grainfit.measurement import messages

#: Largest number of cells; a heap of a million particles has half of it in a silhouette.
MOST_CELLS = 50_000_000
#: The same for cells that are worked on in parts: it limits the time, some seconds.
MOST_CELLS_IN_PARTS = 500_000_000


def require_grid(quantity: str, *sides: float, most: int = MOST_CELLS) -> None:
    """Raise an error unless a grid is small enough to be worked on.

    Parameters
    ----------
    quantity : str
        Quantity that needs the grid, for the message.
    sides : float
        Numbers of cells along its sides; not yet rounded, so that they may be infinite.
    most : int
        Largest number of cells.

    Raises
    ------
    NotMeasurableError
        It would have more than `most` cells.
    """
    if not math.prod(sides) <= most:
        shown = " x ".join(f"{side:.3g}" for side in sides)
        raise NotMeasurableError(messages.LARGE_GRID(quantity=quantity, cells=shown, most=most))
