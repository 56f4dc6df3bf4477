"""Shares of the mass of a clump by sphere: YADE takes the centre of mass from them."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from grainfit.materials.clumps import Clump

#: How much more the centre of mass of a clump counts than the volumes of its spheres.
_WEIGHT_OF_CENTRE = 1e6


class ClumpShares(NamedTuple):
    """Shares by the volumes of the spheres, and shares that give the right centre of mass."""

    shares: list[float]
    weights: list[float]


def clump_shares(clump: Clump) -> ClumpShares:
    """Return the shares of the spheres in the mass of a clump."""
    # Loaded late: only decks of clumps need it.
    from scipy.optimize import nnls

    shares = clump.radii**3 / (clump.radii**3).sum()
    # As near to the volumes as the centre allows.
    centre = _WEIGHT_OF_CENTRE * np.vstack((clump.positions.T, np.ones(len(clump))))
    wanted = np.concatenate((np.array([0.0, 0.0, 0.0, _WEIGHT_OF_CENTRE]), shares))
    weights, _ = nnls(np.vstack((centre, np.eye(len(clump)))), wanted)
    return ClumpShares(shares.tolist(), weights.tolist())
