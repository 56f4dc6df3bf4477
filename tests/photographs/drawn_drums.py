"""Pictures of drums drawn at random: usable ones, and those that no one can measure."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from grainfit.bulk_tests.drum.bed import TurningBed
from tests.photographs.drawn_pictures import _contrasting
from tests.photographs.rendered_drums import DrumShot, seen_from_the_front

Array = NDArray[np.float64]

#: Why no one can measure them.
UNUSABLE = ("cut off", "empty", "no contrast", "moving camera", "oblique", "stands still")


class Simulated(NamedTuple):
    """A simulated bed, places along the axis of the drum, and turn from frame to frame, rad."""

    bed: TurningBed
    along: Array
    step: float


def every(simulated: Simulated, number: int) -> Simulated:
    """Return every so many frames of a bed."""
    bed = simulated.bed
    some = replace(
        bed,
        times=bed.times[::number],
        across=bed.across[::number],
        heights=bed.heights[::number],
    )
    return Simulated(some, simulated.along[::number], number * simulated.step)


def usable_drum(
    simulated: Simulated, number: int, size: tuple[int, int] = (480, 360)
) -> tuple[DrumShot, float]:
    """Draw a video of a simulated drum; and by how much its camera is level, degrees."""
    rng = np.random.default_rng([45, number])
    bed, setup = simulated.bed, simulated.bed.setup
    # The lining is at the wall: the bed ends at it.
    radius = setup.clear_radius
    places, radii = seen_from_the_front(
        simulated.along, bed.across, bed.heights, bed.last.radii, radius
    )
    colour, back, backdrop, rim = _contrasting(rng)
    level = float(rng.choice([0.1, 0.3]))
    shot = DrumShot(
        places,
        radii,
        length=setup.drum_length / radius,
        step=simulated.step,
        interval=float(np.diff(bed.times).mean()),
        yaw=float(rng.uniform(-6, 6)),
        pitch=float(rng.uniform(-3, 6)),
        roll=level * float(rng.normal()),
        distance=float(rng.uniform(5, 12)),
        size=size,
        share=float(rng.uniform(0.6, 0.85)),
        aim=(float(rng.uniform(-0.04, 0.04)), float(rng.uniform(-0.04, 0.04))),
        rim=float(rng.uniform(1.08, 1.15)),
        colour=colour,
        colour_spread=float(rng.uniform(0.02, 0.1)),
        gloss=float(rng.choice([0.0, 0.0, 0.4])),
        back=back,
        rim_colour=rim,
        backdrop=backdrop,
        mark=(0.7, 0.1, 0.1) if rng.random() < 0.7 else None,
        ambient=float(rng.uniform(0.4, 0.7)),
        glare=float(rng.choice([0.0, 0.2, 0.4])),
        glare_at=(float(rng.uniform(-0.6, 0.6)), float(rng.uniform(-0.6, 0.6))),
        glare_width=float(rng.uniform(0.05, 0.15)),
        uneven=float(rng.uniform(-0.25, 0.25)),
        vignette=float(rng.uniform(0, 0.3)),
        blur=float(rng.uniform(0.4, 1.2)),
        noise=float(rng.uniform(0.002, 0.03)),
        mirrored=bool(rng.random() < 0.5),
        seed=number,
    )
    return shot, level


def unusable_drum(
    simulated: Simulated, number: int, size: tuple[int, int] = (480, 360)
) -> DrumShot:
    """Draw a video that no one can measure, of a kind of `UNUSABLE` by its number."""
    shot, _ = usable_drum(simulated, number, size)
    kind = UNUSABLE[number % len(UNUSABLE)]
    if kind == "cut off":
        return replace(shot, aim=(0.3, 0.0))
    if kind == "empty":
        far = shot.places.copy()
        far[..., 0] = 60.0
        return replace(shot, places=far)
    if kind == "no contrast":
        return replace(shot, back=shot.colour, colour_spread=0.12, gloss=0.0)
    if kind == "moving camera":
        return replace(shot, moves=0.3 / len(shot.places))
    if kind == "oblique":
        return replace(shot, yaw=math.copysign(28.0, shot.yaw))
    return replace(shot, places=np.repeat(shot.places[:1], len(shot.places), axis=0), mark=None)


__all__ = ["UNUSABLE", "Simulated", "every", "unusable_drum", "usable_drum"]
