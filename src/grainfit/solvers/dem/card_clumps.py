"""Clumps in material cards: the templates of LAMMPS and LIGGGHTS, as comments to copy."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace

import numpy as np

from grainfit.formatting import without_noise
from grainfit.materials.sizes import ParticleSizes
from grainfit.scenes.spheres import ClumpSpheres, clump_spheres


@dataclass(frozen=True)
class CardClump:
    """A clump of one diameter.

    Parameters
    ----------
    number : int
        From 1, in the order of the diameters.
    diameter : float
        Of a sphere of equal volume, m.
    spheres : tuple of tuple of float
        x, y, z and radius of each sphere, from the centre of mass along the principal axes, m.
    types : tuple of int
        Type of each sphere in LAMMPS: that of its radius.
    mass : float
        kg.
    inertia : tuple of float
        Principal moments, kg m^2.
    """

    number: int
    diameter: float
    spheres: tuple[tuple[float, ...], ...]
    types: tuple[int, ...]
    mass: float
    inertia: tuple[float, float, float]


def card_clumps(sizes: ParticleSizes | None, density: float) -> list[CardClump]:
    """Return the clump of each diameter, for a density of the solid in kg/m^3; none of spheres."""
    spheres = None if sizes is None else clump_spheres(sizes)
    if spheres is None:
        return []
    every = (card_clump(spheres, index, density) for index in range(len(spheres.diameters)))
    return [_without_noise(clump) for clump in every]


def _without_noise(clump: CardClump) -> CardClump:
    x, y, z = map(without_noise, clump.inertia)
    return replace(
        clump,
        spheres=tuple(
            tuple(without_noise(length, size=clump.diameter) for length in sphere)
            for sphere in clump.spheres
        ),
        mass=without_noise(clump.mass),
        inertia=(x, y, z),
    )


def clump_comments(sizes: ParticleSizes | None) -> list[str]:
    """Return the comments that say which clumps the particles are; none for spheres."""
    if sizes is None or sizes.clump is None:
        return []
    return [
        "#",
        f"# Particles are clumps of spheres: {sizes.shape}. Mass and inertia are those of the",
        "# union of the spheres. Positions are from the centre of mass, along the principal axes.",
    ]


def clump_lines(
    sizes: ParticleSizes | None, density: float, write: Callable[[CardClump], Iterator[str]]
) -> list[str]:
    """Return the comments on the clumps of a card; none for spheres.

    Parameters
    ----------
    sizes : ParticleSizes or None
        Particle sizes, as far as they are known.
    density : float
        Of the solid, kg/m^3.
    write : callable
        Yields the template of a clump for a solver.
    """
    lines = []
    for clump in card_clumps(sizes, density):
        lines += ["", f"Clump {clump.number}, with the volume of a sphere of {clump.diameter!r} m:"]
        lines += [f"    {line}".rstrip() for line in write(clump)]
    return [*clump_comments(sizes), *(f"# {line}".rstrip() for line in lines)]


def card_clump(spheres: ClumpSpheres, index: int, density: float) -> CardClump:
    """Return the clump of a diameter, by its index."""
    diameter, clump = spheres.diameters[index], spheres.clump
    indices = np.array([index])
    radii = spheres.radii(indices)[0].tolist()
    places = (diameter * clump.positions).tolist()
    mass = density * math.pi / 6 * diameter**3
    x, y, z = (mass * diameter**2 * moment for moment in clump.moments)
    return CardClump(
        index + 1,
        diameter,
        tuple((*place, radius) for place, radius in zip(places, radii, strict=True)),
        tuple((spheres.kinds(indices)[0] + 1).tolist()),
        mass,
        (x, y, z),
    )


def lammps_molecule(clump: CardClump) -> Iterator[str]:
    """Yield a molecule file for LAMMPS, whose first line it skips."""
    yield f"clump{clump.number}.mol"
    yield f"{len(clump.spheres)} atoms"
    yield f"{clump.mass!r} mass"
    yield "0.0 0.0 0.0 com"
    yield f"{' '.join(map(repr, clump.inertia))} 0.0 0.0 0.0 inertia"
    numbered = [*enumerate(clump.spheres, 1)]
    whole = sum(radius**3 for *_, radius in clump.spheres)
    masses = [without_noise(clump.mass * radius**3 / whole) for *_, radius in clump.spheres]
    for title, rows in (
        ("Coords", [f"{n} {x!r} {y!r} {z!r}" for n, (x, y, z, _) in numbered]),
        ("Types", [f"{n} {kind}" for n, kind in enumerate(clump.types, 1)]),
        ("Diameters", [f"{n} {without_noise(2 * radius)!r}" for n, (*_, radius) in numbered]),
        ("Masses", [f"{n} {mass!r}" for n, mass in enumerate(masses, 1)]),
    ):
        yield from ("", title, "", *rows)


def liggghts_template(clump: CardClump) -> Iterator[str]:
    """Yield a particle template for LIGGGHTS, for ``fix multisphere``."""
    x, y, z = clump.inertia
    density = without_noise(clump.mass / (math.pi / 6 * clump.diameter**3))
    template = f"particletemplate/multisphere {_prime(clump.number)}"
    yield f"fix clump{clump.number} all {template} atom_type 1 &"
    yield f"    density constant {density!r} nspheres {len(clump.spheres)} ntry 1000000 spheres &"
    yield from (f"    {' '.join(map(repr, sphere))} &" for sphere in clump.spheres)
    yield f"    type {clump.number} mass {clump.mass!r} &"
    yield f"    inertia_tensor {x!r} 0.0 0.0 {y!r} 0.0 {z!r} use_density"


def _prime(number: int) -> int:
    """Return a prime above 10000: LIGGGHTS wants another seed for every template."""
    odd = itertools.count(10001, 2)
    primes = (n for n in odd if all(n % divisor for divisor in range(3, math.isqrt(n) + 1, 2)))
    return next(itertools.islice(primes, number - 1, None))
