"""Pictures of heaps drawn at random: usable ones, and those that no one can measure."""

from __future__ import annotations

import math
from dataclasses import replace
from functools import cache

import numpy as np

from grainfit.measurement.particles import Particles
from tests.measurement.synthetic_heaps import heap
from tests.photographs.rendered_pictures import Shot, skin

#: Why no one can measure them.
UNUSABLE = ("cut off", "no contrast", "two heaps", "from too high", "no heap", "half hidden")


@cache
def cone(angle: float, height: float, seed: int) -> Particles:
    """Return a cone of beads of 10 mm, some diameters high: the ones near its surface."""
    return skin(heap(angle, height, seed), angle)


def usable(number: int, *, angles: tuple[float, ...] = (), height: float | None = None) -> Shot:
    """Draw a picture of a heap; with angles, of one of them, so that heaps are shared."""
    rng = np.random.default_rng([43, number])
    angle = float(rng.uniform(10, 45)) if not angles else angles[number % len(angles)]
    tall = float(rng.uniform(9, 18)) if height is None else height
    particles = cone(angle, tall, int(number if not angles else 1))
    base = tall * 0.01 / math.tan(math.radians(angle))
    width = int(rng.choice([800, 1000, 1200])) if not angles else 700
    focal = float(rng.uniform(0.75, 2.0))
    # The base takes 35 to 60 % of the width.
    distance = 2 * base * focal / float(rng.uniform(0.35, 0.6))
    elevation = float(rng.uniform(0, angle - 8))
    ground = _contrasting(rng)
    has_plate = bool(rng.random() < 0.6) or elevation > 5
    return Shot(
        particles,
        elevation=elevation,
        roll=float(rng.uniform(-5, 5)),
        azimuth=float(rng.uniform(0, 360)),
        distance=distance,
        focal=focal,
        size=(width, width * 3 // 4),
        aim=(float(rng.uniform(-0.06, 0.06)), float(rng.uniform(-0.05, 0.1))),
        colour=ground[0],
        colour_spread=float(rng.uniform(0.02, 0.12)),
        gloss=float(rng.choice([0.0, 0.0, 0.5])),
        backdrop=ground[1],
        table=ground[2],
        plate_radius=base * float(rng.uniform(1.25, 1.6)) if has_plate else 0.0,
        plate_colour=ground[3],
        uneven=float(rng.uniform(-0.35, 0.35)),
        vignette=float(rng.uniform(0, 0.4)),
        texture=float(rng.uniform(0, 0.06)),
        light=(float(rng.uniform(-0.8, 0.8)), float(rng.uniform(-0.9, 0.1)), 1.0),
        ambient=float(rng.uniform(0.4, 0.7)),
        shadow=float(rng.uniform(0, 0.7)),
        blur=float(rng.uniform(0.4, 1.4)),
        noise=float(rng.uniform(0.002, 0.03)),
        quality=int(rng.integers(40, 96)),
        seed=number,
    )


Colour = tuple[float, float, float]


def _contrasting(rng: np.random.Generator) -> tuple[Colour, Colour, Colour, Colour]:
    """Colours of a heap, a backdrop, a table and a plate: the heap pale, dark or coloured."""

    def grey(low: float, high: float) -> Colour:
        tint = 1 + 0.08 * rng.normal(size=3)
        colour = np.clip(rng.uniform(low, high) * tint, 0.01, 1)
        return float(colour[0]), float(colour[1]), float(colour[2])

    kind = rng.integers(3)
    if kind == 0:  # pale on dark
        return grey(0.7, 0.95), grey(0.03, 0.2), grey(0.08, 0.25), grey(0.15, 0.35)
    if kind == 1:  # dark on pale
        return grey(0.03, 0.12), grey(0.5, 0.9), grey(0.5, 0.8), grey(0.4, 0.6)
    hue = [(0.6, 0.2, 0.1), (0.15, 0.35, 0.65), (0.7, 0.5, 0.1)][int(rng.integers(3))]
    return hue, grey(0.6, 0.9), grey(0.55, 0.8), grey(0.45, 0.6)


def unusable(number: int, *, angles: tuple[float, ...] = (), height: float | None = None) -> Shot:
    """Draw a picture that no one can measure, of a kind of `UNUSABLE` by its number."""
    shot = usable(number, angles=angles, height=height)
    rng = np.random.default_rng([44, number])
    kind = UNUSABLE[number % len(UNUSABLE)]
    particles = shot.particles
    base = float(np.hypot(*particles.positions[:, :2].T).max())
    angle = math.degrees(math.atan(float(particles.positions[:, 2].max()) / base))
    if kind == "cut off":
        side = float(rng.choice([-1, 1]))
        return replace(shot, aim=(side * float(rng.uniform(0.4, 0.5)), 0.0))
    if kind == "no contrast":
        table = tuple(0.85 * value for value in shot.colour)
        return replace(shot, backdrop=table, table=table, plate_radius=0.0, texture=0.15, blur=1.5)
    if kind == "two heaps":
        shift = np.array([1.15 * base, 0, 0])
        both = np.vstack([particles.positions - shift, particles.positions + shift])
        pair = Particles(both, np.tile(particles.radii, 2), np.tile(particles.masses, 2))
        return replace(
            shot, particles=pair, azimuth=0.0, distance=2 * shot.distance, plate_radius=0.0
        )
    if kind == "from too high":
        return replace(shot, elevation=min(angle + float(rng.uniform(0, 15)), 60.0))
    if kind == "no heap":
        lone = particles.select(np.arange(len(particles)) < 2)
        low = lone.positions.copy()
        low[:, 2] = lone.radii
        return replace(shot, particles=Particles(low, lone.radii, lone.masses))
    # Something stands before one half of it.
    return replace(shot, hidden=float(rng.uniform(-0.02, 0.02)))
