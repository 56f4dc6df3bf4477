"""Random columns of particles that do not touch, to rain into a container.

Positions come from random sequential addition, so all solvers start from the same particles and
the seed is all that differs between two fillings.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from grainfit.errors import InputError
from grainfit.materials.sizes import ParticleSizes
from grainfit.scenes import messages
from grainfit.scenes.clump_packing import place_clumps
from grainfit.scenes.spheres import ClumpSpheres, random_orientations
from grainfit.validation import is_whole, plain

#: Share of the column's volume that is solid: well below the jamming limit of random sequential
#: addition (0.38), so that places are found quickly.
_SOLID_FRACTION = 0.26
#: Distance kept between particles and from walls, over the particle diameter.
_CLEARANCE = 0.001
_ROUNDS_BEFORE_GROWING = 50
_GROWTH = 1.05
#: Particles in a tube are pushed apart at most so often; above this solid fraction they jam.
_MOST_PUSHES, _JAMMED = 2000, 0.6
#: Most particles of a test.
MOST_PARTICLES = 1_000_000


def factor_for_fewer(count: float) -> float:
    """Return how many times as large particles have to be, at least, for a test to hold few enough.

    Examples
    --------
    >>> factor_for_fewer(8.24e6)
    2.1
    """
    return math.ceil(10 * math.cbrt(count / MOST_PARTICLES)) / 10


class Footprint(Protocol):
    """Horizontal cross-section of a column."""

    @property
    def area(self) -> float:
        """Area inside the walls, m^2."""

    def area_of_centres(self, radius: float) -> float:
        """Return the area that centres of particles of a radius can take, m^2."""

    def places(
        self, random: np.random.Generator, count: int, wall: float
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Draw x and y of places, uniform in the area, this far from the walls."""

    @property
    def period(self) -> tuple[float, float, float] | None:
        """Periods along the axes, 0 where there is none; None without any."""


@dataclass(frozen=True)
class Round:
    """A circle about the z axis.

    Parameters
    ----------
    radius : float
        m.
    """

    radius: float
    period: None = None

    def __post_init__(self) -> None:
        _require_lengths(radius=self.radius)

    @property
    def area(self) -> float:
        """Area inside the wall, m^2."""
        return math.pi * self.radius**2

    def area_of_centres(self, radius: float) -> float:
        """Return the area that centres of particles of a radius can take, m^2."""
        return math.pi * max(self.radius - radius, 0.0) ** 2

    def places(
        self, random: np.random.Generator, count: int, wall: float
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Draw x and y of places, uniform in the area, this far from the wall."""
        distance = (self.radius - wall) * np.sqrt(random.random(count))
        azimuth = 2 * math.pi * random.random(count)
        return distance * np.cos(azimuth), distance * np.sin(azimuth)


@dataclass(frozen=True)
class Rectangle:
    """A rectangle between walls at x = -width/2 and width/2, periodic in y from 0 to depth.

    Parameters
    ----------
    width, depth : float
        m.
    """

    width: float
    depth: float

    def __post_init__(self) -> None:
        _require_lengths(width=self.width, depth=self.depth)

    @property
    def period(self) -> tuple[float, float, float]:
        """Periods along the axes, 0 where there is none."""
        return (0.0, self.depth, 0.0)

    @property
    def area(self) -> float:
        """Area inside the walls, m^2."""
        return self.width * self.depth

    def area_of_centres(self, radius: float) -> float:
        """Return the area that centres of particles of a radius can take, m^2."""
        return max(self.width - 2 * radius, 0.0) * self.depth

    def places(
        self, random: np.random.Generator, count: int, wall: float
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Draw x and y of places, uniform in the area, this far from the walls."""
        x = (self.width / 2 - wall) * (2 * random.random(count) - 1)
        return x, self.depth * random.random(count)


@dataclass(frozen=True)
class Square:
    """A square between four walls, about the z axis.

    Parameters
    ----------
    width : float
        m.
    """

    width: float
    period: None = None

    def __post_init__(self) -> None:
        _require_lengths(width=self.width)

    @property
    def area(self) -> float:
        """Area inside the walls, m^2."""
        return self.width**2

    def area_of_centres(self, radius: float) -> float:
        """Return the area that centres of particles of a radius can take, m^2."""
        return max(self.width - 2 * radius, 0.0) ** 2

    def places(
        self, random: np.random.Generator, count: int, wall: float
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Draw x and y of places, uniform in the area, this far from the walls."""
        x, y = (self.width / 2 - wall) * (2 * random.random((2, count)) - 1)
        return x, y


@dataclass(frozen=True)
class PeriodicRectangle:
    """A rectangle without walls, periodic in x from 0 to length and in y from 0 to depth.

    Parameters
    ----------
    length, depth : float
        m.
    """

    length: float
    depth: float

    def __post_init__(self) -> None:
        _require_lengths(length=self.length, depth=self.depth)

    @property
    def period(self) -> tuple[float, float, float]:
        """Periods along the axes, 0 where there is none."""
        return (self.length, self.depth, 0.0)

    @property
    def area(self) -> float:
        """Area of a period, m^2."""
        return self.length * self.depth

    def area_of_centres(self, radius: float) -> float:  # noqa: ARG002
        """Return the area that centres of particles can take, m^2: all of it."""
        return self.area

    def places(
        self,
        random: np.random.Generator,
        count: int,
        wall: float,  # noqa: ARG002
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Draw x and y of places, uniform in the area."""
        return self.length * random.random(count), self.depth * random.random(count)


def _require_lengths(**lengths: float) -> None:
    wrong = {name: value for name, value in lengths.items() if not 0 < value < math.inf}
    if wrong:
        raise InputError([messages.NO_LENGTH.fault(n, value=value) for n, value in wrong.items()])


@dataclass(frozen=True)
class Column:
    """Particles at the beginning.

    Parameters
    ----------
    positions : ndarray of shape (n, 3)
        Centres, m; the ground is at z = 0.
    size_indices : ndarray of shape (n,)
        Index of each particle's diameter in the particle size distribution.
    height : float
        Height of the column, m.
    velocities : ndarray of shape (n, 3), optional
        Velocities, m/s; None is at rest.
    orientations : ndarray of shape (n, 4), optional
        Orientations of clumps as quaternions, the scalar last; None is that of their shape.
    spins : ndarray of shape (n, 3), optional
        Angular velocities of clumps, rad/s; None is at rest.
    """

    positions: NDArray[np.float64]
    size_indices: NDArray[np.int64]
    height: float
    velocities: NDArray[np.float64] | None = None
    orientations: NDArray[np.float64] | None = None
    spins: NDArray[np.float64] | None = None

    def __repr__(self) -> str:
        return f"<Column of {len(self.size_indices)} particles, {self.height:.4g} m high>"

    @property
    def turns(self) -> NDArray[np.float64]:
        """Orientations of clumps, also where they are not turned, shape (n, 4)."""
        if self.orientations is not None:
            return self.orientations
        return np.tile([0.0, 0.0, 0.0, 1.0], (len(self.size_indices), 1))

    def raised(self, way: float) -> Column:
        """Return the column higher by a way, m."""
        positions = self.positions + np.array([0.0, 0.0, way])
        return replace(self, positions=positions, height=self.height + way)

    def outlines(self, spheres: ClumpSpheres) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return centres and radii of the spheres of clumps, clump by clump, m."""
        places = spheres.places(self.positions, self.turns, self.size_indices)
        return places.reshape(-1, 3), spheres.radii(self.size_indices).reshape(-1)


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


def column_height(sizes: ParticleSizes, count: int, footprint: Footprint) -> float:
    """Return the first height to try for a random column of this many particles, m."""
    largest = max(sizes.outer_diameters)
    area = (footprint.area + footprint.area_of_centres(largest / 2)) / 2
    height = count * mean_particle_volume(sizes) / (_SOLID_FRACTION * area)
    return max(height, 2 * largest)


def random_column(sizes: ParticleSizes, count: int, footprint: Footprint, seed: int) -> Column:
    """Fill an upright container with particles at random places, none touching another.

    Parameters
    ----------
    sizes : ParticleSizes
        Diameters and their mass fractions.
    count : int
        Number of particles; all of them are placed, in a higher column if need be.
    footprint : Footprint
        Cross-section of the container.
    seed : int
        Not negative; equal seeds give equal columns.

    Returns
    -------
    Column
        Particles in random order.

    Raises
    ------
    InputError
        The seed is negative, there are no or too many particles, either is no whole number, or the
        container is narrower than a particle.
    """
    random = _generator(seed)
    _require_whole("count", count)
    _require_room(sizes, count, footprint)
    height = column_height(sizes, count, footprint)
    period = footprint.period
    numbers = particle_numbers(sizes, count)
    if sizes.clump is not None:
        return _clump_column(random, sizes, numbers, footprint, height)
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
            places = _candidates(random, 4 * missing + 50, diameter, footprint, height)
            for other in np.unique(indices):
                tree = cKDTree(positions[indices == other], boxsize=period)
                reach = (1 + _CLEARANCE) * (diameter + diameters[other]) / 2
                places = places[tree.query(places, distance_upper_bound=reach)[0] > reach]
            places = _without_contacts(places, (1 + _CLEARANCE) * diameter, period)[:missing]
            positions = np.vstack((positions, places))
            indices = np.append(indices, np.full(len(places), index))
            missing -= len(places)
    order = random.permutation(count)
    return Column(positions[order], indices[order], height)


def _clump_column(
    random: np.random.Generator,
    sizes: ParticleSizes,
    numbers: list[int],
    footprint: Footprint,
    height: float,
) -> Column:
    """Fill an upright container with clumps, from a first height on."""

    def draw(count: int, diameter: float) -> NDArray[np.float64]:
        return _candidates(random, count, diameter, footprint, height)

    def grow() -> None:
        nonlocal height
        height *= _GROWTH

    placed = place_clumps(random, sizes, numbers, draw, footprint.period, _CLEARANCE, grow)
    placed = placed.take(random.permutation(sum(numbers)))
    return Column(placed.positions, placed.size_indices, height, orientations=placed.orientations)


def random_in_tube(
    sizes: ParticleSizes, count: int, radius: float, length: float, seed: int
) -> Column:
    """Place particles at random in a lying tube about the x axis, none touching another.

    They are placed without regard to each other, and pushed apart. The tube repeats along x.

    Parameters
    ----------
    sizes : ParticleSizes
        Diameters and their mass fractions.
    count : int
        Number of particles, up to about half of the tube's volume.
    radius, length : float
        Inner radius, and period from x = 0, m.
    seed : int
        Not negative; equal seeds give equal places.

    Returns
    -------
    Column
        Particles in random order; its height is the radius.

    Raises
    ------
    InputError
        The seed is negative, or the particles find no room.
    """
    random = _generator(seed)
    _require_whole("count", count)
    _require_lengths(radius=radius, length=length)
    _require_periods(sizes, (length,))
    no_room = InputError(messages.NO_ROOM.fault("particle_count", count=count, radius=radius))
    if count * mean_particle_volume(sizes) > _JAMMED * math.pi * radius**2 * length:
        raise no_room
    numbers = particle_numbers(sizes, count)
    indices = random.permutation(np.repeat(np.arange(len(numbers)), numbers))
    if sizes.clump is not None:
        spheres = ClumpSpheres(sizes.clump, sizes.diameters)
        column = _clumps_in_tube(random, spheres, indices, (radius, length))
        if column is None:
            raise no_room
        return column
    radii = (1 + 2 * _CLEARANCE) / 2 * np.array(sizes.diameters)[indices]
    reach = radius - radii
    places = _in_tube(random, reach, length)
    for _ in range(_MOST_PUSHES):
        if not _push_apart(places, radii, length):
            return Column(places, indices, radius)
        outside = np.maximum(np.hypot(places[:, 1], places[:, 2]) / reach, 1.0)
        places[:, 1:] /= outside[:, None]
    raise no_room


def _clumps_in_tube(
    random: np.random.Generator,
    spheres: ClumpSpheres,
    indices: NDArray[np.int64],
    tube: tuple[float, float],
) -> Column | None:
    """Place clumps in a lying tube of this radius and length; None if they find no room."""
    (radius, length), count = tube, len(indices)
    outer = np.array(spheres.diameters)[indices] * spheres.clump.outer_radius
    reach = radius - (1 + _CLEARANCE) * outer
    centres = _in_tube(random, reach, length)
    orientations = random_orientations(random, count)
    arms = spheres.places(np.zeros((count, 3)), orientations, indices)
    radii = (1 + 2 * _CLEARANCE) * spheres.radii(indices).reshape(-1)
    owners = np.repeat(np.arange(count), arms.shape[1])
    for _ in range(_MOST_PUSHES):
        outside = np.maximum(np.hypot(centres[:, 1], centres[:, 2]) / reach, 1.0)
        centres[:, 1:] /= outside[:, None]
        centres[:, 0] %= length
        places = (centres[:, None] + arms).reshape(-1, 3)
        before = places.copy()
        if not _push_apart(places, radii, length, owners):
            return Column(centres, indices, radius, orientations=orientations)
        moved = places - before
        moved[:, 0] -= length * np.round(moved[:, 0] / length)
        # The mean: two clumps that overlap in several places would jump far apart.
        pushed = np.bincount(owners, moved.any(axis=1), minlength=count)
        np.add.at(centres, owners, moved / np.maximum(pushed, 1.0)[owners, None])
    return None


def _in_tube(
    random: np.random.Generator, reach: NDArray[np.float64], length: float
) -> NDArray[np.float64]:
    """Draw places in a lying tube, each up to its own distance from the axis."""
    count = len(reach)
    distance, azimuth = reach * np.sqrt(random.random(count)), 2 * math.pi * random.random(count)
    return np.column_stack(
        (length * random.random(count), distance * np.cos(azimuth), distance * np.sin(azimuth))
    )


def _push_apart(
    places: NDArray[np.float64],
    radii: NDArray[np.float64],
    period: float,
    owners: NDArray[np.int64] | None = None,
) -> bool:
    """Push each pair of spheres that overlap apart in place; return whether there were any.

    Spheres of one owner may overlap.
    """
    places[:, 0] %= period
    tree = cKDTree(places, boxsize=(period, 0.0, 0.0))
    first, second = tree.query_pairs(2 * radii.max(), output_type="ndarray").T
    if owners is not None:
        apart = owners[first] != owners[second]
        first, second = first[apart], second[apart]
    between = places[second] - places[first]
    between[:, 0] -= period * np.round(between[:, 0] / period)
    gap = np.linalg.norm(between, axis=1)
    missing = radii[first] + radii[second] - gap
    # Distances are larger than needed by the clearance: most of it is enough.
    near = missing > _CLEARANCE * radii.min()
    if not near.any():
        return False
    push = (missing[near] / 2 / np.maximum(gap[near], 1e-30))[:, None] * between[near]
    np.add.at(places, first[near], -push)
    np.add.at(places, second[near], push)
    return True


def _require_room(sizes: ParticleSizes, count: int, footprint: Footprint) -> None:
    if not 0 < count <= MOST_PARTICLES:
        fault = messages.TOO_MANY_PARTICLES.fault("particles", count=count, most=MOST_PARTICLES)
        raise InputError(fault)
    largest = max(sizes.outer_diameters)
    _require_periods(sizes, footprint.period or ())
    if footprint.area_of_centres((1 + _CLEARANCE) * largest / 2) <= 0:
        raise InputError(
            messages.NARROW_CONTAINER.fault("particles", area=footprint.area, diameter=largest)
        )


def _require_periods(sizes: ParticleSizes, periods: Sequence[float]) -> None:
    """Raise `InputError` if a particle would touch a neighbour from both sides, or itself."""
    largest = max(sizes.outer_diameters)
    InputError.raise_for(
        messages.SHORT_PERIOD.fault("particles", axis=axis, period=period, diameter=largest)
        for axis, period in zip("xyz", periods, strict=False)
        if 0 < period < 2 * largest
    )


def _generator(seed: int) -> np.random.Generator:
    """Return the random numbers of a seed; raise `InputError` for one that is not accepted."""
    _require_whole("seed", seed)
    if seed < 0:
        raise InputError(messages.NEGATIVE_SEED.fault("seed", seed=seed))
    return np.random.default_rng(seed)


def _require_whole(name: str, given: object) -> None:
    if not is_whole(plain(given)):
        raise InputError(messages.NO_WHOLE_NUMBER.fault(name, given=given))


def _candidates(
    random: np.random.Generator, count: int, diameter: float, footprint: Footprint, height: float
) -> NDArray[np.float64]:
    """Random places inside the container, uniform in its volume, clear of walls and ground."""
    wall = (1 + _CLEARANCE) * diameter / 2
    x, y = footprint.places(random, count, wall)
    z = wall + (height - 2 * wall) * random.random(count)
    return np.column_stack((x, y, z))


def _without_contacts(
    places: NDArray[np.float64], distance: float, period: tuple[float, float, float] | None
) -> NDArray[np.float64]:
    """Keep each place that is not too near to an earlier one that was kept."""
    pairs = cKDTree(places, boxsize=period).query_pairs(distance, output_type="ndarray")
    pairs = pairs[np.lexsort((pairs[:, 1], pairs[:, 0]))]
    kept = np.ones(len(places), dtype=bool)
    # Pairs come in order of their first member, so it is decided already whether that one is kept.
    for first, second in pairs:
        if kept[first]:
            kept[second] = False
    return places[kept]
