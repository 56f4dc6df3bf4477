"""Random sequential addition of clumps: by their outlines, not by the spheres about them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from grainfit.materials.sizes import ParticleSizes
from grainfit.scenes.spheres import ClumpSpheres, random_orientations

_ROUNDS_BEFORE_GROWING = 50


@dataclass
class PlacedClumps:
    """Clumps that have found a place.

    Parameters
    ----------
    positions : ndarray of shape (n, 3)
        Centres of mass, m.
    orientations : ndarray of shape (n, 4)
        Quaternions, the scalar last.
    size_indices : ndarray of shape (n,)
        Index of each clump's diameter.
    """

    positions: NDArray[np.float64]
    orientations: NDArray[np.float64]
    size_indices: NDArray[np.int64]

    def take(self, which: NDArray[np.bool_] | NDArray[np.int64] | slice) -> PlacedClumps:
        """Return some of the clumps."""
        return PlacedClumps(
            self.positions[which], self.orientations[which], self.size_indices[which]
        )

    def with_more(self, more: PlacedClumps) -> PlacedClumps:
        """Return these clumps and more of them."""
        return PlacedClumps(
            np.vstack((self.positions, more.positions)),
            np.vstack((self.orientations, more.orientations)),
            np.append(self.size_indices, more.size_indices),
        )


def place_clumps(
    random: np.random.Generator,
    sizes: ParticleSizes,
    numbers: list[int],
    draw: Callable[[int, float], NDArray[np.float64]],
    period: tuple[float, float, float] | None,
    clearance: float,
    grow: Callable[[], None],
) -> PlacedClumps:
    """Place clumps at random, with random orientations, none touching another.

    Parameters
    ----------
    random : Generator
        Of the run's seed.
    sizes : ParticleSizes
        With a clump.
    numbers : list of int
        Number of clumps of each diameter.
    draw : callable
        Draws so many centres of clumps of an outer diameter, m.
    period : tuple of float or None
        Periods along the axes, 0 where there is none.
    clearance : float
        Distance between clumps over the sum of two radii.
    grow : callable
        Makes more room, or raises an error, when clumps hardly find a place.
    """
    clump = sizes.clump
    assert clump is not None, "spheres are placed by random_column"
    spheres = ClumpSpheres(clump, sizes.diameters)
    placed = PlacedClumps(np.empty((0, 3)), np.empty((0, 4)), np.empty(0, dtype=np.int64))
    # The largest first: they find no place between many small ones.
    for index in np.argsort(-np.array(sizes.diameters), kind="stable"):
        missing, rounds = numbers[index], 0
        while missing:
            rounds += 1
            if rounds % _ROUNDS_BEFORE_GROWING == 0:
                grow()
            count = 4 * missing + 50
            centres = draw(count, sizes.outer_diameters[index])
            tried = PlacedClumps(centres, random_orientations(random, count), np.full(count, index))
            apart = _Outlines(tried, spheres, period).apart(
                _Outlines(placed, spheres, period), 1 + clearance
            )
            found = tried.take(np.flatnonzero(apart)[:missing])
            placed = placed.with_more(found)
            missing -= len(found.positions)
    return placed


class _Outlines:
    """Spheres of clumps, in a tree."""

    def __init__(
        self,
        clumps: PlacedClumps,
        spheres: ClumpSpheres,
        period: tuple[float, float, float] | None,
    ) -> None:
        self.count = len(clumps.positions)
        places = spheres.places(clumps.positions, clumps.orientations, clumps.size_indices)
        self.radii = spheres.radii(clumps.size_indices).reshape(-1)
        self.owners = np.repeat(np.arange(self.count), places.shape[1])
        places = places.reshape(-1, 3)
        if period is not None:
            lengths = np.array(period)
            wrapped = places % np.where(lengths > 0, lengths, 1.0)
            # Of a negative rounding error, the remainder is the period itself.
            wrapped = np.where(wrapped >= lengths, 0.0, wrapped)
            places = np.where(lengths > 0, wrapped, places)
        self.tree = cKDTree(places, boxsize=period)

    def apart(self, others: _Outlines, factor: float) -> NDArray[np.bool_]:
        """Return which clumps touch neither others nor an earlier one that is kept."""
        kept = np.ones(self.count, dtype=bool)
        if others.count:
            reach = factor * (self.radii.max() + others.radii.max())
            near = self.tree.sparse_distance_matrix(others.tree, reach, output_type="coo_matrix")
            touch = near.data < factor * (self.radii[near.row] + others.radii[near.col])
            kept[self.owners[near.row[touch]]] = False
        pairs = self.tree.query_pairs(2 * factor * self.radii.max(), output_type="ndarray")
        one, other = self.owners[pairs].T
        pairs = pairs[(one != other) & kept[one] & kept[other]]
        for first, second in self._touching(pairs, factor):
            # Sorted: it is decided already whether the first is kept.
            if kept[first]:
                kept[second] = False
        return kept

    def _touching(self, pairs: NDArray[np.int64], factor: float) -> NDArray[np.int64]:
        """Return pairs of clumps whose spheres in these pairs touch, sorted by the first."""
        places, lengths = self.tree.data, self.tree.boxsize
        between = places[pairs[:, 0]] - places[pairs[:, 1]]
        if lengths is not None:
            span = np.where(lengths > 0, lengths, 1.0)
            between -= np.where(lengths > 0, lengths * np.round(between / span), 0.0)
        near = np.linalg.norm(between, axis=1) < factor * self.radii[pairs].sum(axis=1)
        owners = np.sort(self.owners[pairs[near]], axis=1)
        found: NDArray[np.int64] = np.unique(owners.reshape(-1, 2), axis=0)
        return found
