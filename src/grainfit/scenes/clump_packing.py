"""Random sequential addition of clumps: by their outlines, not by the spheres about them."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from grainfit.materials.sizes import ParticleSizes
from grainfit.scenes.spheres import ClumpSpheres, random_orientations

_ROUNDS_BEFORE_GROWING = 50
#: Clumps that are tried at once.
_BLOCK = 256
#: Most clumps that are tried touch others, and few of their spheres show it: of each, first so many
#: spheres are looked at, and so many times as many after that.
_FIRST_SPHERES, _MORE_SPHERES = 1, 2
#: Steps of so much of a whole spread numbers evenly, however many there are.
_GOLDEN = (5**0.5 - 1) / 2


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
    bed = _Bed(ClumpSpheres(clump, sizes.diameters), period, 1 + clearance)
    # The largest first: they find no place between many small ones.
    for index in np.argsort(-np.array(sizes.diameters), kind="stable"):
        missing, rounds = numbers[index], 0
        outer = sizes.outer_diameters[index]
        while missing:
            rounds += 1
            if rounds % _ROUNDS_BEFORE_GROWING == 0:
                grow()
            count = 4 * missing + 50
            centres = draw(count, outer)
            tried = PlacedClumps(centres, random_orientations(random, count), np.full(count, index))
            missing -= bed.place(tried, missing)
    return bed.placed


class _Bed:
    """Clumps that have found a place, with their outlines."""

    def __init__(
        self, spheres: ClumpSpheres, period: tuple[float, float, float] | None, factor: float
    ) -> None:
        self.placed = PlacedClumps(np.empty((0, 3)), np.empty((0, 4)), np.empty(0, dtype=np.int64))
        self._spheres, self._period, self._factor = spheres, period, factor
        # Several trees, each of them more than six times as large as the next: most of the time,
        # what is new needs a small one only.
        self._outlines: list[_Outlines] = []

    def place(self, tried: PlacedClumps, most: int) -> int:
        """Place clumps that touch neither the bed nor an earlier one; return their number.

        Parameters
        ----------
        tried : PlacedClumps
            At random.
        most : int
            Number of clumps to place at most.
        """
        left = most
        for start in range(0, len(tried.positions), _BLOCK):
            block = tried.take(slice(start, start + _BLOCK))
            outlines = _Outlines.of(block, self._spheres, self._period)
            free = outlines.without_contact(self._outlines, self._factor)
            found = free[outlines.take(free).apart(self._factor)][:left]
            if len(found):
                self._add(block.take(found), outlines.take(found))
            left -= len(found)
            if not left:
                break
        return most - left

    def _add(self, clumps: PlacedClumps, outlines: _Outlines) -> None:
        self.placed = self.placed.with_more(clumps)
        while self._outlines and 6 * len(outlines.places) >= len(self._outlines[-1].places):
            outlines = self._outlines.pop().with_more(outlines)
        self._outlines.append(outlines)


@dataclass(frozen=True)
class _Outlines:
    """Spheres of clumps.

    Parameters
    ----------
    places : ndarray of shape (clumps, spheres, 3)
        Centres, m, within the period.
    radii : ndarray of shape (clumps, spheres)
        m.
    period : tuple of float or None
        Periods along the axes, 0 where there is none.
    """

    places: NDArray[np.float64]
    radii: NDArray[np.float64]
    period: tuple[float, float, float] | None

    @classmethod
    def of(
        cls,
        clumps: PlacedClumps,
        spheres: ClumpSpheres,
        period: tuple[float, float, float] | None,
    ) -> _Outlines:
        """Return the outlines of clumps."""
        places = spheres.places(clumps.positions, clumps.orientations, clumps.size_indices)
        if period is not None:
            lengths = np.array(period)
            wrapped = places % np.where(lengths > 0, lengths, 1.0)
            # Of a negative rounding error, the remainder is the period itself.
            wrapped = np.where(wrapped >= lengths, 0.0, wrapped)
            places = np.where(lengths > 0, wrapped, places)
        return cls(places, spheres.radii(clumps.size_indices), period)

    def take(self, which: NDArray[np.int64]) -> _Outlines:
        """Return the outlines of some of the clumps."""
        return _Outlines(self.places[which], self.radii[which], self.period)

    def with_more(self, more: _Outlines) -> _Outlines:
        """Return these outlines and more of them."""
        return _Outlines(
            np.concatenate((self.places, more.places)),
            np.concatenate((self.radii, more.radii)),
            self.period,
        )

    @cached_property
    def tree(self) -> cKDTree:
        """Tree of all spheres, clump by clump."""
        return cKDTree(self.places.reshape(-1, 3), boxsize=self.period)

    def without_contact(self, others: list[_Outlines], factor: float) -> NDArray[np.int64]:
        """Return the positions of the clumps that touch none of the others."""
        left = np.arange(len(self.places))
        for spheres in self._shares():
            for other in others:
                part = _Outlines(
                    self.places[left][:, spheres], self.radii[left][:, spheres], self.period
                )
                left = left[~part.touch(other, factor)]
        return left

    def _shares(self) -> Iterator[NDArray[np.int64]]:
        """Yield shares of the spheres of a clump, the first one small; the spheres are spread."""
        count = self.places.shape[1]
        order = np.argsort(np.arange(count) * _GOLDEN % 1, kind="stable")
        start, size = 0, _FIRST_SPHERES
        while start < count:
            yield order[start : start + size]
            start, size = start + size, size * _MORE_SPHERES

    def touch(self, others: _Outlines, factor: float) -> NDArray[np.bool_]:
        """Return which clumps touch others."""
        if not len(self.places):
            return np.zeros(0, dtype=bool)
        if np.ptp(others.radii) == 0:
            return self._touch_equal(others, factor)
        radii, theirs = self.radii.reshape(-1), others.radii.reshape(-1)
        reach = factor * (radii.max() + theirs.max())
        near = self.tree.sparse_distance_matrix(others.tree, reach, output_type="ndarray")
        touch = near["v"] < factor * (radii[near["i"]] + theirs[near["j"]])
        found = np.zeros(len(self.places), dtype=bool)
        found[near["i"][touch] // self.places.shape[1]] = True
        return found

    def _touch_equal(self, others: _Outlines, factor: float) -> NDArray[np.bool_]:
        """Return which clumps touch others whose spheres are equal: the nearest one decides."""
        reach = factor * (self.radii + others.radii[0, 0])
        nearest, _ = others.tree.query(self.places, distance_upper_bound=reach.max())
        found: NDArray[np.bool_] = (nearest < reach).any(axis=1)
        return found

    def apart(self, factor: float) -> NDArray[np.bool_]:
        """Return which clumps touch no earlier one that is kept."""
        kept = np.ones(len(self.places), dtype=bool)
        if len(kept) > 1:
            for first, second in self._touching(factor):
                # Sorted: it is decided already whether the first is kept.
                if kept[first]:
                    kept[second] = False
        return kept

    def _touching(self, factor: float) -> NDArray[np.int64]:
        """Return pairs of clumps that touch, sorted by the first."""
        radii, each = self.radii.reshape(-1), self.places.shape[1]
        pairs = self.tree.query_pairs(2 * factor * radii.max(), output_type="ndarray")
        pairs = pairs[pairs[:, 0] // each != pairs[:, 1] // each]
        places, lengths = self.tree.data, self.tree.boxsize
        between = places[pairs[:, 0]] - places[pairs[:, 1]]
        if lengths is not None:
            span = np.where(lengths > 0, lengths, 1.0)
            between -= np.where(lengths > 0, lengths * np.round(between / span), 0.0)
        near = np.linalg.norm(between, axis=1) < factor * radii[pairs].sum(axis=1)
        owners = np.sort(pairs[near] // each, axis=1)
        found: NDArray[np.int64] = np.unique(owners.reshape(-1, 2), axis=0)
        return found
