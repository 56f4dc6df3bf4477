"""Glued sets: particles of the material that are one rigid body, such as a rough plate."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from grainfit.scenes import messages


@dataclass(frozen=True)
class Glued:
    """Particles glued into one rigid body, which stands still unless a stage moves it.

    Loose particles touch them as they touch each other. Glued particles touch neither walls nor
    other glued particles, have no weight, and count neither among the particles of a stage nor in
    its kinetic energy.

    Parameters
    ----------
    positions : ndarray of shape (n, 3)
        Centres at the beginning, m; they may overlap.
    size_indices : ndarray of shape (n,)
        Index of each particle's diameter in the particle size distribution.

    Raises
    ------
    ValueError
        There is no particle, or positions and sizes do not belong together.
    """

    positions: NDArray[np.float64]
    size_indices: NDArray[np.int64]

    def __post_init__(self) -> None:
        n = len(self.size_indices)
        if n == 0 or self.positions.shape != (n, 3):
            raise ValueError(messages.GLUED_COUNT(count=n, shape=self.positions.shape))

    def __repr__(self) -> str:
        return f"<Glued: {len(self.size_indices)} particles>"
