"""Random column of particles that do not touch, to rain into the cylinder.

Positions come from random sequential addition, so both solvers start from the same particles and
the seed is all that differs between two fillings.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from grainfit.errors import Fault, InputError
from grainfit.materials.sizes import ParticleSizes

#: Raised whenever the same seed gives other positions: part of a run's identity.
PACKING_REVISION = 1

#: Share of the column's volume that is solid: well below the jamming limit of random sequential
#: addition (0.38), so that places are found quickly.
_SOLID_FRACTION = 0.26
#: Distance kept between particles and from walls, over the particle diameter.
_CLEARANCE = 0.001
_ROUNDS_BEFORE_GROWING = 50
_GROWTH = 1.05


@dataclass(frozen=True)
class Column:
    """Particles before they fall.

    Parameters
    ----------
    positions : ndarray of shape (n, 3)
        Centres, m; the cylinder's axis is z, its ground is at z = 0.
    size_indices : ndarray of shape (n,)
        Index of each particle's diameter in the particle size distribution.
    height : float
        Height of the column, m.
    """

    positions: NDArray[np.float64]
    size_indices: NDArray[np.int64]
    height: float


def particle_numbers(sizes: ParticleSizes, count: int) -> list[int]:
    """Return how many particles of each diameter come nearest to the mass fractions.

    Examples
    --------
    >>> particle_numbers(ParticleSizes((0.010, 0.005), (0.5, 0.5)), 900)
    [100, 800]
    """
    exact = [fraction * count for fraction in sizes.number_fractions]
    numbers = [math.floor(number) for number in exact]
    by_remainder = sorted(range(len(exact)), key=lambda i: numbers[i] - exact[i])
    for index in by_remainder[: count - sum(numbers)]:
        numbers[index] += 1
    return numbers


def mean_particle_volume(sizes: ParticleSizes) -> float:
    """Return the mean volume of one particle, by number, m^3."""
    shares = zip(sizes.number_fractions, sizes.diameters, strict=True)
    return sum(share * math.pi / 6 * diameter**3 for share, diameter in shares)


def column_height(sizes: ParticleSizes, count: int, radius: float) -> float:
    """Return the first height to try for a random column of this many particles, m."""
    room = radius - max(sizes.diameters) / 2
    area = math.pi * (radius**2 + room**2) / 2
    height = count * mean_particle_volume(sizes) / (_SOLID_FRACTION * area)
    return max(height, 2 * max(sizes.diameters))


def random_column(sizes: ParticleSizes, count: int, radius: float, seed: int) -> Column:
    """Fill an upright cylinder with particles at random places, none touching another.

    Parameters
    ----------
    sizes : ParticleSizes
        Diameters and their mass fractions.
    count : int
        Number of particles; all of them are placed, in a higher column if need be.
    radius : float
        Inner radius of the cylinder, m.
    seed : int
        Not negative; equal seeds give equal columns.

    Returns
    -------
    Column
        Particles in random order.

    Raises
    ------
    InputError
        The seed is negative.
    """
    if seed < 0:
        raise InputError(Fault("seed", f"{seed} is negative.", "Use 0 or a positive number."))
    random = np.random.default_rng(seed)
    height = column_height(sizes, count, radius)
    numbers = particle_numbers(sizes, count)
    positions = np.empty((0, 3))
    indices = np.empty(0, dtype=np.int64)
    diameters = np.array(sizes.diameters)
    # The largest first: they find no place between many small ones.
    for index in np.argsort(-diameters, kind="stable"):
        diameter = float(diameters[index])
        missing = numbers[index]
        rounds = 0
        while missing:
            rounds += 1
            if rounds % _ROUNDS_BEFORE_GROWING == 0:
                height *= _GROWTH
            places = _candidates(random, 4 * missing + 50, diameter, radius, height)
            for other in np.unique(indices):
                tree = cKDTree(positions[indices == other])
                reach = (1 + _CLEARANCE) * (diameter + diameters[other]) / 2
                places = places[tree.query(places, distance_upper_bound=reach)[0] > reach]
            places = _without_contacts(places, (1 + _CLEARANCE) * diameter)[:missing]
            positions = np.vstack((positions, places))
            indices = np.append(indices, np.full(len(places), index))
            missing -= len(places)
    order = random.permutation(count)
    return Column(positions[order], indices[order], height)


def _candidates(
    random: np.random.Generator, count: int, diameter: float, radius: float, height: float
) -> NDArray[np.float64]:
    """Random places inside the cylinder, uniform in its volume, clear of wall and ground."""
    wall = (1 + _CLEARANCE) * diameter / 2
    distance = (radius - wall) * np.sqrt(random.random(count))
    azimuth = 2 * math.pi * random.random(count)
    z = wall + (height - 2 * wall) * random.random(count)
    return np.column_stack((distance * np.cos(azimuth), distance * np.sin(azimuth), z))


def _without_contacts(places: NDArray[np.float64], distance: float) -> NDArray[np.float64]:
    """Keep each place that is not too near to an earlier one that was kept."""
    pairs = cKDTree(places).query_pairs(distance, output_type="ndarray")
    pairs = pairs[np.lexsort((pairs[:, 1], pairs[:, 0]))]
    kept = np.ones(len(places), dtype=bool)
    # Pairs come in order of their first member, so it is decided already whether that one is kept.
    for first, second in pairs:
        if kept[first]:
            kept[second] = False
    return places[kept]
